// A quarter (x, y >= 0) of the lower half of a sphere of radius R that touches z = 0 at the origin,
// its flat cut at z = R. Tetrahedra of size h within half_width of the origin, growing to the size
// coarse. On the planes of symmetry "x0" and "y0" the displacement along x and y is zero. Any unit.
DefineConstant[
  R = {1},
  h = {0.02},
  half_width = {0.1},
  coarse = {0.2},
  order = {1}  // of the cells, or 2
];
If (!(R > 0) || !(h > 0) || !(half_width > 0))
  Error("R = %g, h = %g, half_width = %g: must be > 0", R, h, half_width);
  Abort;
EndIf
If (coarse < h)
  Error("coarse = %g: must be >= h = %g", coarse, h);
  Abort;
EndIf
Point(1) = {0, 0, R};
Point(2) = {0, 0, 0};
Point(3) = {R, 0, R};
Point(4) = {0, R, R};
Circle(1) = {2, 1, 3};
Circle(2) = {3, 1, 4};
Circle(3) = {4, 1, 2};
Line(4) = {1, 2};
Line(5) = {1, 3};
Line(6) = {1, 4};
Curve Loop(1) = {1, 2, 3};
Surface(1) = {1} In Sphere {1};
Curve Loop(2) = {5, 2, -6};
Plane Surface(2) = {2};
Curve Loop(3) = {6, 3, -4};
Plane Surface(3) = {3};
Curve Loop(4) = {4, 1, -5};
Plane Surface(4) = {4};
Surface Loop(1) = {1, 2, 3, 4};
Volume(1) = {1};
Field[1] = Distance;
Field[1].PointsList = {2};
Field[2] = Threshold;
Field[2].InField = 1;
Field[2].SizeMin = h;
Field[2].SizeMax = coarse;
Field[2].DistMin = half_width;
Field[2].DistMax = half_width + 3*(coarse - h);
Background Field = 2;
Mesh.ElementOrder = order;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Physical Volume("half sphere") = {1};
Physical Surface("bottom") = {1};
Physical Surface("top") = {2};
Physical Surface("x0") = {3};
Physical Surface("y0") = {4};
