// Half the section of a sphere of radius R that touches y = 0 at the origin, x being the radius; with
// above = 0 it hangs below y = 0. Triangles of size h within half_width of the origin, growing to the
// size coarse. Any unit.
DefineConstant[
  R = {1},
  h = {0.005},
  half_width = {0.06},
  coarse = {0.1},
  above = {1},
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
If (above != 0 && above != 1)
  Error("above = %g: must be 0 or 1", above);
  Abort;
EndIf
s = 2*above - 1;
Point(1) = {0, 0, 0};
Point(2) = {0, s*R, 0};
Point(3) = {R, s*R, 0};
Point(4) = {0, s*2*R, 0};
Circle(1) = {1, 2, 3};
Circle(2) = {3, 2, 4};
Line(3) = {4, 1};
Curve Loop(1) = {1, 2, 3};
Plane Surface(1) = {1};
Field[1] = Distance;
Field[1].PointsList = {1};
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
Physical Surface("sphere") = {1};
Physical Curve("near") = {1};
Physical Curve("far") = {2};
