"""A lattice as data: fields, masses and bonds with polynomial forces."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, Poly, Symbol

from derive.algebra.exact_numbers import exact, integer, shown
from derive.symbols import check_constants, eps, rational_function, x

Cell = tuple[int, ...]

MOST_CELLS = 10**6
"""Bound on shifts and weights."""


@dataclass(frozen=True)
class Stencil:
    """``weight`` times ``field`` in the cell at offset ``shift`` (a tuple, one entry an axis)."""

    shift: Cell
    weight: int = 1
    field: int = 0

    def __post_init__(self) -> None:
        if not isinstance(self.shift, tuple) or not self.shift:
            raise ValueError(
                f"shift must be a tuple of integers, one an axis, got {shown(self.shift)} "
                "((1,) is the next cell of a chain)"
            )
        for step in (*self.shift, self.weight):
            integer("shift and weight", step, -MOST_CELLS, "whole cells, whole weights")
        integer("field", self.field, 0, "the place of the field in the lattice's fields")


@dataclass(frozen=True)
class Bond:
    """One kind of bond: what it measures, the force it answers with, and where that force acts.

    The bond of cell n is stretched by ``x = sum weight f_{n+shift}`` over ``stretch``; field f
    then feels ``sum weight force(x_{n+shift})`` over those entries of ``action`` that name it.
    ``force`` is a polynomial in the symbol ``derive.symbols.x``; its coefficients are exact
    rational functions of symbols, and polynomials in ``derive.symbols.eps`` where a constant is
    small.  Raises ValueError for anything else.
    """

    stretch: tuple[Stencil, ...]
    force: Expr
    action: tuple[Stencil, ...]

    def __post_init__(self) -> None:
        for name in ("stretch", "action"):
            entries = getattr(self, name)
            if not isinstance(entries, tuple) or not entries:
                raise ValueError(
                    f"{name} must be a tuple of Stencil, got {shown(entries)} (name one at least)"
                )
        if not isinstance(self.force, Expr) or not self.force.is_polynomial(x):
            raise ValueError(
                f"force must be a polynomial in derive.symbols.x, got {shown(self.force)} "
                "(expand the force law about zero stretch)"
            )
        exact("force", self.force)
        for coefficient in self.coefficients():
            rational_function("force", coefficient)

    def coefficients(self) -> tuple[Expr, ...]:
        """The force's coefficients, highest power first, as Horner's rule wants them."""
        return tuple(Poly(self.force, x).all_coeffs())

    def stiffness(self, stretch: Expr) -> Expr:
        """The force's slope at a uniform ``stretch``: its linearisation."""
        return self.force.diff(x).subs(x, stretch)


@dataclass(frozen=True)
class Lattice:
    """Equations of motion ``mass f'' = sum of bond forces``, one for each field.

    >>> from derive import LATTICES
    >>> LATTICES["fput_strain"].constants
    (K2, K3, K4)
    """

    name: str
    title: str
    fields: tuple[str, ...]
    masses: tuple[Expr, ...]
    bonds: tuple[Bond, ...]

    @property
    def constants(self) -> tuple[Symbol, ...]:
        """The symbols in forces and masses, by name; eps, which is no constant, apart."""
        found: set[Symbol] = set()
        for expression in (*self.masses, *(bond.force for bond in self.bonds)):
            found |= expression.free_symbols
        return tuple(sorted(found - {x, eps}, key=str))

    @property
    def dimension(self) -> int:
        """The number of axes of the lattice."""
        return len(self.bonds[0].stretch[0].shift)

    def __post_init__(self) -> None:
        if not self.fields or not self.bonds or len(self.masses) != len(self.fields):
            raise ValueError(
                "lattice must have fields, a mass for each of them, and bonds, got "
                f"{len(self.fields)} fields, {len(self.masses)} masses, {len(self.bonds)} bonds"
            )
        exact_masses = tuple(rational_function("mass", mass) for mass in self.masses)
        object.__setattr__(self, "masses", exact_masses)
        for mass in self.masses:
            if mass.is_nonpositive:
                raise ValueError(f"mass must satisfy mass > 0, got {mass} (1 is the unit)")
        for entry in (entry for bond in self.bonds for entry in (*bond.stretch, *bond.action)):
            if entry.field >= len(self.fields) or len(entry.shift) != self.dimension:
                raise ValueError(
                    f"{entry} must name one of {len(self.fields)} fields and shift along "
                    f"{self.dimension} axes, got field {entry.field} and {len(entry.shift)} axes "
                    "(fields are counted from 0)"
                )
        check_constants(self.constants)
