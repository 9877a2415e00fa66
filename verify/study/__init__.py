"""Studies on the lattice: hard cases, costs, convergence."""
