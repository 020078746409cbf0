// Half (y >= 0) of a sphere of radius R that touches z = 0 at the origin, its centre at z = R.
// Tetrahedra of size h within half_width of the origin, growing to the size coarse; on the plane of
// symmetry "y0" the displacement along y is zero. Any unit.
DefineConstant[
  R = {1},
  h = {0.02},
  half_width = {0.1},
  coarse = {0.3},
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
Point(5) = {-R, 0, R};
Point(6) = {0, 0, 2*R};
Circle(1) = {2, 1, 3};
Circle(2) = {3, 1, 6};
Circle(3) = {6, 1, 5};
Circle(4) = {5, 1, 2};
Circle(5) = {3, 1, 4};
Circle(6) = {4, 1, 5};
Circle(7) = {2, 1, 4};
Circle(8) = {4, 1, 6};
Curve Loop(1) = {1, 5, -7};
Surface(1) = {1} In Sphere {1};
Curve Loop(2) = {7, 6, 4};
Surface(2) = {2} In Sphere {1};
Curve Loop(3) = {2, -8, -5};
Surface(3) = {3} In Sphere {1};
Curve Loop(4) = {8, 3, -6};
Surface(4) = {4} In Sphere {1};
Curve Loop(5) = {1, 2, 3, 4};
Plane Surface(5) = {5};
Surface Loop(1) = {1, 2, 3, 4, 5};
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
Physical Volume("half ball") = {1};
Physical Surface("near") = {1, 2};
Physical Surface("far") = {3, 4};
Physical Surface("y0") = {5};
