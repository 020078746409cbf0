// A box standing on z = 0, its base centred at x = y = 0. Lengths in metres.
DefineConstant[
  length_x = {0.36},
  length_y = {0.50},
  height = {0.80},
  n_x = {1},
  n_y = {1},
  n_z = {1},
  hexahedra = {1}
];
If (!(length_x > 0) || !(length_y > 0) || !(height > 0))
  Error("length_x = %g, length_y = %g, height = %g: must be > 0", length_x, length_y, height);
  Abort;
EndIf
If (n_x < 1 || n_x != Floor(n_x) || n_y < 1 || n_y != Floor(n_y) || n_z < 1 || n_z != Floor(n_z))
  Error("n_x = %g, n_y = %g, n_z = %g: must be whole and >= 1", n_x, n_y, n_z);
  Abort;
EndIf
Point(1) = {-length_x/2, -length_y/2, 0};
Point(2) = { length_x/2, -length_y/2, 0};
Point(3) = { length_x/2,  length_y/2, 0};
Point(4) = {-length_x/2,  length_y/2, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve {1, 3} = n_x + 1;
Transfinite Curve {2, 4} = n_y + 1;
Transfinite Surface {1};
If (hexahedra)
  Recombine Surface {1};
  out[] = Extrude {0, 0, height} { Surface{1}; Layers{n_z}; Recombine; };
Else
  out[] = Extrude {0, 0, height} { Surface{1}; Layers{n_z}; };
EndIf
Physical Volume("box") = {out[1]};
Physical Surface("base") = {1};
Physical Surface("top") = {out[0]};
Physical Surface("sides") = {out[2], out[3], out[4], out[5]};
