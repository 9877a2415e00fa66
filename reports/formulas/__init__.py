"""Formulas on the page: SymPy expressions as LaTeX displays that fit the line."""

from reports.formulas.formula import Formula, broken
from reports.formulas.printing import equation_latex, latex

__all__ = ["Formula", "broken", "equation_latex", "latex"]
