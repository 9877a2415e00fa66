"""A lattice as data: fields, masses and bonds with polynomial forces."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, Integer, Poly, Symbol

from derive.symbols import K2, K3, K4, x

Cell = tuple[int, ...]


@dataclass(frozen=True)
class Stencil:
    """``weight`` times ``field`` in the cell at offset ``shift`` (a tuple, one entry an axis)."""

    shift: Cell
    weight: int = 1
    field: int = 0


@dataclass(frozen=True)
class Bond:
    """One kind of bond: what it measures, the force it answers with, and where that force acts.

    The bond of cell n is stretched by ``x = sum weight f_{n+shift}`` over ``stretch``; field f
    then feels ``sum weight force(x_{n+shift})`` over those entries of ``action`` that name it.
    ``force`` is a polynomial in the symbol ``derive.symbols.x``.
    """

    stretch: tuple[Stencil, ...]
    force: Expr
    action: tuple[Stencil, ...]

    def coefficients(self) -> tuple[Expr, ...]:
        """The force's coefficients, highest power first, as Horner's rule wants them."""
        return tuple(Poly(self.force, x).all_coeffs())

    def stiffness(self, stretch: Expr) -> Expr:
        """The force's slope at a uniform ``stretch``: its linearisation."""
        return self.force.diff(x).subs(x, stretch)


@dataclass(frozen=True)
class Lattice:
    """Equations of motion ``mass f'' = sum of bond forces``, one for each field.

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
        """The symbols in forces and masses, by name."""
        found: set[Symbol] = set()
        for expression in (*self.masses, *(bond.force for bond in self.bonds)):
            found |= expression.free_symbols
        return tuple(sorted(found - {x}, key=str))


FPUT_STRAIN = Lattice(
    name="fput_strain",
    title="FPUT lattice in the strain y_n = u_{n+1} - u_n",
    fields=("y",),
    masses=(Integer(1),),
    bonds=(
        Bond(
            stretch=(Stencil((0,)),),
            force=K2 * x + K3 * x**2 + K4 * x**3,
            action=(Stencil((1,)), Stencil((0,), -2), Stencil((-1,))),
        ),
    ),
)
"""The lattice of the paper's eqs. (2) and (3), in the strain: the paper's eq. (4)."""

LATTICES: dict[str, Lattice] = {lattice.name: lattice for lattice in (FPUT_STRAIN,)}
