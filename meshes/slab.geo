// The slab of the ironing scene: [0, 4] x [-1, 0], 6n x 2n bilinear quadrilaterals. Any unit.
// With n_width > 0: hexahedra, extruded along z over width, in n_width layers.
DefineConstant[
  n = {12},
  width = {0.5},
  n_width = {0}
];
If (n < 1 || n != Floor(n) || n_width < 0 || n_width != Floor(n_width) || !(width > 0))
  Error("n = %g, n_width = %g, width = %g: must be whole numbers >= 1 and >= 0, and > 0", n, n_width, width);
  Abort;
EndIf
Point(1) = {0, -1, 0};
Point(2) = {4, -1, 0};
Point(3) = {4, 0, 0};
Point(4) = {0, 0, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve {1, 3} = 6*n + 1;
Transfinite Curve {2, 4} = 2*n + 1;
Transfinite Surface {1};
Recombine Surface {1};
If (n_width > 0)
  out[] = Extrude {0, 0, width} { Surface{1}; Layers{n_width}; Recombine; };
  Physical Volume("slab") = {out[1]};
  Physical Surface("bottom") = {out[2]};
  Physical Surface("right") = {out[3]};
  Physical Surface("top") = {out[4]};
  Physical Surface("left") = {out[5]};
  Physical Surface("back") = {1};
  Physical Surface("front") = {out[0]};
Else
  Physical Surface("slab") = {1};
  Physical Curve("bottom") = {1};
  Physical Curve("right") = {2};
  Physical Curve("top") = {3};
  Physical Curve("left") = {4};
EndIf
