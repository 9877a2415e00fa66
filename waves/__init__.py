"""A lattice's own waves: found numerically, proved to exist in ball arithmetic."""
