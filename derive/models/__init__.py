"""Lattices in the catalogue, and the paper's reduction of one of them."""
