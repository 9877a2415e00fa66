"""Lattices on rings of real circumference, integrated in Fourier space."""
