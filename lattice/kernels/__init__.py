"""Compiled loops of the strain FPUT lattice: plain, blocked, as vector code, on two cores."""
