"""Formulas on the page: SymPy expressions as LaTeX displays that fit the line."""
