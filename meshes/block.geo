// A rectangular block standing on y = 0, its base centred at x = 0. Lengths in metres.
DefineConstant[
  width = {0.36},
  height = {0.80},
  n_width = {1},
  n_height = {2},
  quadrilaterals = {1}
];
If (!(width > 0) || !(height > 0))
  Error("width = %g, height = %g: must be > 0", width, height);
  Abort;
EndIf
If (n_width < 1 || n_width != Floor(n_width) || n_height < 1 || n_height != Floor(n_height))
  Error("n_width = %g, n_height = %g: must be whole and >= 1", n_width, n_height);
  Abort;
EndIf
Point(1) = {-width/2, 0, 0};
Point(2) = { width/2, 0, 0};
Point(3) = { width/2, height, 0};
Point(4) = {-width/2, height, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve {1, 3} = n_width + 1;
Transfinite Curve {2, 4} = n_height + 1;
Transfinite Surface {1};
If (quadrilaterals)
  Recombine Surface {1};
EndIf
Physical Surface("block") = {1};
Physical Curve("base") = {1};
Physical Curve("right") = {2};
Physical Curve("top") = {3};
Physical Curve("left") = {4};
