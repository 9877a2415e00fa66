"""Studies behind the report: evaluation accuracy, costs, hard cases, proofs and lattice runs."""
