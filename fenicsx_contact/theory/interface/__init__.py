# SPDX-License-Identifier: LGPL-3.0-or-later
"""Laws of the interface beyond Coulomb's, a small file each; where they differ they are UFL, which
the compiler differentiates.

Friction laws are bounds (:mod:`fenicsx_contact.theory.friction`), read at the time at which the
scheme takes its forces: by theta = 1/2 they are of second order.
"""
