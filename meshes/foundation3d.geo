// A quarter (x, y >= 0) of a block under z = 0, the middle of its top at the origin: width is that
// of the quarter. Tetrahedra of size h within half_width of the origin, growing to the size coarse.
// On the planes of symmetry "x0" and "y0" the displacement along x and y is zero. Any unit.
DefineConstant[
  width = {1},
  height = {1},
  h = {0.02},
  half_width = {0.1},
  coarse = {0.2}
];
If (!(width > 0) || !(height > 0) || !(h > 0) || !(half_width > 0))
  Error("width = %g, height = %g, h = %g, half_width = %g: must be > 0", width, height, h, half_width);
  Abort;
EndIf
If (coarse < h)
  Error("coarse = %g: must be >= h = %g", coarse, h);
  Abort;
EndIf
Point(1) = {0, 0, 0};
Point(2) = {width, 0, 0};
Point(3) = {width, width, 0};
Point(4) = {0, width, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
out[] = Extrude {0, 0, -height} { Surface{1}; };
Field[1] = Distance;
Field[1].PointsList = {1};
Field[2] = Threshold;
Field[2].InField = 1;
Field[2].SizeMin = h;
Field[2].SizeMax = coarse;
Field[2].DistMin = half_width;
Field[2].DistMax = half_width + 3*(coarse - h);
Background Field = 2;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Physical Volume("foundation") = {out[1]};
Physical Surface("top") = {1};
Physical Surface("base") = {out[0]};
Physical Surface("y0") = {out[2]};
Physical Surface("sides") = {out[3], out[4]};
Physical Surface("x0") = {out[5]};
