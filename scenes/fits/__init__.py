"""Lattices from measurements: a force law from measured points."""
