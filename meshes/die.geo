// The die of the ironing scene: [0.5, 1.5] x [0, 0.5], its points raised by
// 0.1 s^2 (1 - y/0.5), s = (x - 1)/0.5; 2n x n bilinear quadrilaterals. Any unit.
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
// The bottom is 2n straight edges, so that its points are where they should be; transfinite
// interpolation then is the mapping above.
For i In {0 : 2*n}
  Point(1 + i) = {0.5 + i/(2*n), 0.1*(i/n - 1)^2, 0};
EndFor
Point(2*n + 2) = {1.5, 0.5, 0};
Point(2*n + 3) = {0.5, 0.5, 0};
bottom[] = {};
For i In {1 : 2*n}
  Line(i) = {i, i + 1};
  bottom[] += {i};
EndFor
Line(2*n + 1) = {2*n + 1, 2*n + 2};
Line(2*n + 2) = {2*n + 2, 2*n + 3};
Line(2*n + 3) = {2*n + 3, 1};
Curve Loop(1) = {1 : 2*n + 3};
Plane Surface(1) = {1};
Transfinite Curve {bottom[]} = 2;
Transfinite Curve {2*n + 1, 2*n + 3} = n + 1;
Transfinite Curve {2*n + 2} = 2*n + 1;
Transfinite Surface {1} = {1, 2*n + 1, 2*n + 2, 2*n + 3};
Recombine Surface {1};
If (n_width > 0)
  out[] = Extrude {0, 0, width} { Surface{1}; Layers{n_width}; Recombine; };
  Physical Volume("die") = {out[1]};
  Physical Surface("bottom") = {out[{2 : 2*n + 1}]};
  Physical Surface("right") = {out[2*n + 2]};
  Physical Surface("top") = {out[2*n + 3]};
  Physical Surface("left") = {out[2*n + 4]};
  Physical Surface("back") = {1};
  Physical Surface("front") = {out[0]};
Else
  Physical Surface("die") = {1};
  Physical Curve("bottom") = {bottom[]};
  Physical Curve("right") = {2*n + 1};
  Physical Curve("top") = {2*n + 2};
  Physical Curve("left") = {2*n + 3};
EndIf
