// A block under y = 0, the middle of its top at the origin: triangles of size h within half_width
// of the origin, growing to the size coarse. Any unit.
DefineConstant[
  width = {2},
  height = {1},
  h = {0.005},
  half_width = {0.06},
  coarse = {0.1}
];
If (!(width > 0) || !(height > 0) || !(h > 0) || !(half_width > 0))
  Error("width = %g, height = %g, h = %g, half_width = %g: must be > 0", width, height, h, half_width);
  Abort;
EndIf
If (coarse < h)
  Error("coarse = %g: must be >= h = %g", coarse, h);
  Abort;
EndIf
Point(1) = {-width/2, -height, 0};
Point(2) = { width/2, -height, 0};
Point(3) = { width/2, 0, 0};
Point(4) = {0, 0, 0};
Point(5) = {-width/2, 0, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 5};
Line(5) = {5, 1};
Curve Loop(1) = {1, 2, 3, 4, 5};
Plane Surface(1) = {1};
Field[1] = Distance;
Field[1].PointsList = {4};
Field[2] = Threshold;
Field[2].InField = 1;
Field[2].SizeMin = h;
Field[2].SizeMax = coarse;
Field[2].DistMin = half_width;
Field[2].DistMax = half_width + 5*(coarse - h);
Background Field = 2;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Physical Surface("foundation") = {1};
Physical Curve("base") = {1};
Physical Curve("right") = {2};
Physical Curve("top") = {3, 4};
Physical Curve("left") = {5};
