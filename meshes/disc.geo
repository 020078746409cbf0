// A disc of radius R about the origin; its rim in four quarters, each about an axis. Triangles of the
// size h at the lowest and the highest point, growing to the size coarse. Any unit.
DefineConstant[
  R = {1},
  h = {0.05},
  coarse = {0.15},
  order = {1}  // of the cells, or 2
];
If (!(R > 0) || !(h > 0))
  Error("R = %g, h = %g: must be > 0", R, h);
  Abort;
EndIf
If (coarse < h)
  Error("coarse = %g: must be >= h = %g", coarse, h);
  Abort;
EndIf
c = R/Sqrt(2);
Point(1) = {0, 0, 0};
Point(2) = {-c, -c, 0};
Point(3) = {c, -c, 0};
Point(4) = {c, c, 0};
Point(5) = {-c, c, 0};
Point(6) = {0, -R, 0};
Point(7) = {0, R, 0};
Circle(1) = {2, 1, 6};
Circle(2) = {6, 1, 3};
Circle(3) = {3, 1, 4};
Circle(4) = {4, 1, 7};
Circle(5) = {7, 1, 5};
Circle(6) = {5, 1, 2};
Curve Loop(1) = {1 : 6};
Plane Surface(1) = {1};
Field[1] = Distance;
Field[1].PointsList = {6, 7};
Field[2] = Threshold;
Field[2].InField = 1;
Field[2].SizeMin = h;
Field[2].SizeMax = coarse;
Field[2].DistMin = 0.2*R;
Field[2].DistMax = 0.8*R;
Background Field = 2;
Mesh.ElementOrder = order;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Physical Surface("disc") = {1};
Physical Curve("under") = {1, 2};
Physical Curve("right") = {3};
Physical Curve("over") = {4, 5};
Physical Curve("left") = {6};
