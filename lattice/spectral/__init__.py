"""The lattice on a ring of real circumference, in Fourier space."""
