// The lower half of a cylinder of radius R that touches y = 0 at the origin, its flat cut at y = R.
// Triangles of size h within half_width of the origin, growing to the size coarse. Any unit.
DefineConstant[
  R = {1},
  h = {0.005},
  half_width = {0.06},
  coarse = {0.1},
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
Point(1) = {0, R, 0};
Point(2) = {-R, R, 0};
Point(3) = {0, 0, 0};
Point(4) = {R, R, 0};
Circle(1) = {2, 1, 3};
Circle(2) = {3, 1, 4};
Line(3) = {4, 2};
Curve Loop(1) = {1, 2, 3};
Plane Surface(1) = {1};
Field[1] = Distance;
Field[1].PointsList = {3};
Field[2] = Threshold;
Field[2].InField = 1;
Field[2].SizeMin = h;
Field[2].SizeMax = coarse;
Field[2].DistMin = half_width;
Field[2].DistMax = half_width + 5*(coarse - h);
Background Field = 2;
Mesh.ElementOrder = order;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Physical Surface("cylinder") = {1};
Physical Curve("bottom") = {1, 2};
Physical Curve("top") = {3};
