"""Compiled kernels that advance rings: splittings on any chain or plane, Nystroem methods."""
