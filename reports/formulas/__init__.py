"""LaTeX displays of SymPy expressions and of typed formulas that fit the line."""
