"""The double-double machine: arithmetic with bounds, Jacobi functions, compiled kernels."""
