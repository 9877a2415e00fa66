"""Exponential integrators for p' = L p + N(p) with diagonal L, for the lattice and the PDE."""
