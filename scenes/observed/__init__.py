"""Observables of a run, and the view of lattice and wave that they are computed from."""
