"""The result of a reduction, as text, LaTeX and JSON."""

from __future__ import annotations

import json

from longwave.derive.algebra.exact_numbers import Number
from longwave.derive.output.notation import latex_of, text_of
from longwave.derive.output.report import latex_report, reduction_data, text_report
from longwave.derive.reduced_equation import ReducedEquation


class Reduction(ReducedEquation):
    """Result of `reduce`: a `ReducedEquation` with text, LaTeX and JSON output."""

    def __repr__(self) -> str:
        needed = "".join(f", {text_of(item.expression)} = 0" for item in self.conditions)
        squared = f"{text_of(self.scaling.speed**2)} = {text_of(self.speed_squared)}"
        return f"Reduction({self.lattice.name}: {self.pde.text()}, {squared}{needed})"

    def _repr_latex_(self) -> str:
        parts = [self.pde.latex(), latex_of(self.sound_condition)]
        joined = r",\quad ".join([*parts, *(item.latex() for item in self.conditions)])
        return rf"$\displaystyle {joined}$"

    def text(self) -> str:
        """Return the whole reduction in plain text."""
        return text_report(self)

    def latex(self, **constants: Number) -> str:
        """Return orders, conditions, reduced equation and coefficients as one ``aligned`` block.

        The coefficients are those at ``constants``. Raises ValueError as coefficients does.
        """
        return latex_report(self, constants)

    def json(self, **constants: Number) -> str:
        """Return the reduction as a JSON document (layout: derive.output.report).

        The coefficients are those at ``constants``. Raises ValueError as coefficients does.
        """
        return json.dumps(reduction_data(self, constants), indent=2)
