# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers that several rooms share, each for one reason."""

#: Places, lengths, directions, motions and forces that differ by less than this share of their
#: size are the same; a cell with less than this share of the volume of its edges is flat.
SAME = 1e-9
#: What is below this share of the terms that it is the difference of is round-off.
ROUND_OFF = 1e-14
#: A surface has a sharp corner where the cosine between the normals of two facets is below this (26
#: degrees): those of something round are almost parallel.
SHARP = 0.9
#: The share of the energies that took part which may come from nowhere: by the few points at which
#: a step takes the forces, in the books of a run.
MADE = 1e-6
#: What is off by less than this share of its size is as it should be: the length of unit normals
#: that are given, distances along them, a slip that has stopped.
RIGHT = 1e-6
#: The share of a step, or of the shortest time of a solid, over which a motion that is given as a
#: function of time is differentiated: what moves faster than that no step can follow.
BRIEF = 2.0**-10
#: Cost: linearisations that a linear solid keeps, of so many lengths of steps: adaptive ones.
KEPT = 12
