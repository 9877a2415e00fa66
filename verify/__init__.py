"""Check closed forms against their equations, and the reduction against the lattice."""
