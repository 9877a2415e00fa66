"""Force laws to fit: formulas in the stretch and in named constants."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np
from sympy import Expr, Symbol, lambdify

from longwave.derive.algebra.contact import contact
from longwave.derive.algebra.exact_numbers import Number
from longwave.derive.algebra.formula_printing import formula_as_text
from longwave.derive.lattice import spring
from longwave.derive.lattice_file import force_of_text
from longwave.derive.models.lattices import LATTICES
from longwave.derive.symbols import check_constants, eps, number_value, x
from longwave.lattice.force_program import UNARY
from longwave.scenes.fits.force_data import Points
from longwave.support.user_files import shown

HERTZ = "hertz"
"""Keyword for Hertz's law of contact, the force of the catalogue's granular chain."""

TABLE: Literal["table"] = "table"
"""Keyword for a spline, for data without a known formula."""


@dataclass(frozen=True)
class ForceLaw:
    """Force law: a formula in the stretch x and constants, some of them ``fixed`` to values."""

    force: Expr
    fixed: Mapping[Symbol, Expr] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if x not in self.force.free_symbols or eps in self.force.free_symbols or not self.free:
            raise ValueError(
                "law must be a formula in the stretch x and constants, one of them not fixed, got "
                f"{shown(self.text)} (such as K2*x + K4*x**3)"
            )

    def __reduce__(self) -> tuple[object, ...]:
        return ForceLaw, (self.force, self.fixed)

    @property
    def text(self) -> str:
        """Right-hand side of the force law as text, such as "K2*x"."""
        return formula_as_text(self.force)

    @property
    def parts(self) -> list[str]:
        """Formulas, with at most one ``contact`` each, that add up to the force.

        The force is split because a spring of a lattice file may open at one stretch only.
        """
        terms = self.force.as_ordered_terms()
        contacts = [term for term in terms if term.has(contact)]
        if len(contacts) < 2:
            return [self.text]
        smooth = [term for term in terms if term not in contacts]
        forces = (sum(smooth), *contacts) if smooth else contacts
        return [formula_as_text(force) for force in forces]

    @property
    def free(self) -> tuple[Symbol, ...]:
        """Constants to fit, sorted by name."""
        return tuple(sorted(self.force.free_symbols - {x, *self.fixed}, key=str))

    @cached_property
    def values(self) -> LawValues:
        """Law and its derivatives as numeric functions."""
        return LawValues(self.force.xreplace(dict(self.fixed)), self.free)


class LawValues:
    """Numeric evaluation of a law and of its derivatives with respect to each constant.

    ``linear`` and ``positive`` are flags, one for each constant: whether the law is linear in it,
    and whether it must be positive.
    """

    def __init__(self, force: Expr, free: Sequence[Symbol]) -> None:
        self._force, *self._slopes = (
            lambdify((x, *free), expression, [UNARY, "numpy"])
            for expression in (force, *(force.diff(symbol) for symbol in free))
        )
        linear: list[Symbol] = []
        for symbol in free:
            if not force.diff(symbol).free_symbols & {symbol, *linear}:
                linear.append(symbol)
        self.linear = [symbol in linear for symbol in free]
        self.positive = [bool(symbol.is_positive) for symbol in free]

    def forces(self, stretch: Points, constants: Points) -> Points:
        """Return the forces at given stretches; NaN where the law is undefined."""
        return self._at(self._force, stretch, constants)

    def slopes(self, stretch: Points, constants: Points) -> Points:
        """Return the derivatives of the forces by the constants, shape (points, constants)."""
        return np.column_stack([self._at(slope, stretch, constants) for slope in self._slopes])

    @staticmethod
    def _at(function: object, stretch: Points, constants: Points) -> Points:
        with np.errstate(all="ignore"):
            values = function(stretch, *constants)  # type: ignore[operator]
        return np.broadcast_to(np.asarray(values, dtype=float), stretch.shape)


def stated_law(
    text: str | None, fixed: Mapping[str, Number] | None = None
) -> ForceLaw | Literal["table"] | None:
    """Return the force law of a formula or of ``hertz``, with some constants ``fixed`` to values.

    If ``text`` is None or "table" it is returned unchanged: the law then depends on the points.
    Raises ValueError for a formula that is not a force, and for a wrong name or value in ``fixed``.

    >>> stated_law("K2*x + K4*x**3").free, stated_law("hertz").text, stated_law("table")
    ((K2, K4), '-A*contact(d - x)**(3/2)', 'table')
    """
    if text is None or text == TABLE:
        if fixed:
            got = "table" if text else "none"
            raise ValueError(
                f"fixed constants must come with a formula, got {', '.join(fixed)} and {got} "
                "(state the law)"
            )
        return TABLE if text else None
    if text == HERTZ:
        force = LATTICES["granular"].bonds[0].force
    else:
        force = force_of_text(text, "law")
        spring(force, ((0,), 0), ((1,), 0))
        check_constants([symbol for symbol in force.free_symbols if symbol not in (x, eps)])
    known = {str(symbol): symbol for symbol in force.free_symbols - {x}}
    for name in fixed or {}:
        if name not in known:
            raise ValueError(
                f"fixed constants must be among {', '.join(sorted(known))}, got {shown(name)} "
                "(rename it or leave it out)"
            )
    values = {known[name]: number_value(name, value) for name, value in (fixed or {}).items()}
    return ForceLaw(force, values)
