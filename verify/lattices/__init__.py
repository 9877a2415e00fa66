"""Waves on any lattice: data that they start from, and what the lattice is compared with."""
