"""Lattices that ship, and the paper's reduction of one of them."""
