"""Long-wave limits of lattices in closed form, found without this program, row by row.

Each row: a lattice as it is declared, an ansatz, c^2, and the coefficients of the reduced equation
``Y_T + ... = 0`` (transverse terms stand outside of its X-derivative).  X, Z across and T are the
slow variables; Y is the strain of a cell.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from sympy import Expr, Integer, Rational, Symbol, cancel, fraction, symbols, together

from longwave.derive import (
    LATTICES,
    Bond,
    Lattice,
    Reduction,
    Scaling,
    SlowVariable,
    Stencil,
    reduce,
)
from longwave.derive.lattice import spring
from longwave.derive.models.lattices import H2, H3, H4, L2, L3, L4, cubic, m1, m2
from longwave.derive.symbols import K2, K3, K4, c, eps, x, ybar

d, k3, b = (Symbol(name, real=True) for name in ("d", "k3", "b"))
S2 = Symbol("S2", positive=True)
tau, drift = Symbol("tau", real=True), Symbol("v", real=True)
C, S = symbols("C S", positive=True)
UNIT = {C: (1 - tau**2) / (1 + tau**2), S: 2 * tau / (1 + tau**2)}
"""C^2 + S^2 = 1, rationally."""

M = m1 + m2
SERIES = H2 * K2 / ((H2 + K2) * M)
MASSES = (m1**2 - m1 * m2 + m2**2) / M**2
TWO = 1 - 12 * m1 * m2 / M**2 * K2 * H2 / (K2 + H2) ** 2
INCLINED = K2 * C**2 + H2 * S**2

Terms = Mapping[str, Expr]


@dataclass(frozen=True)
class Row:
    """A known reduction of a lattice."""

    name: str
    kind: str
    lattice: Lattice
    scaling: Scaling
    squared: Expr
    terms: Terms

    def reduced(self) -> Reduction:
        """Return the derivation, as far as the equation."""
        return reduce(self.lattice, self.scaling, self.scaling.leading_order)

    def differences(self) -> Iterator[str]:
        """Return the symbolic differences from the derived coefficients, none if all are equal."""
        reduction = self.reduced()
        found = reduction.coefficients().terms
        squared = self.squared.subs(UNIT)
        if cancel((reduction.speed_squared - self.squared).subs(UNIT)) != 0:
            yield f"c^2 = {reduction.speed_squared}"
        if reduction.pde.kind != self.kind:
            yield reduction.pde.kind
        for name in {*found, *self.terms}:
            got = _with_speed(reduction, name)
            if not same((got - self.terms.get(name, Integer(0))).subs(UNIT), squared):
                yield f"{name}: {got}"


def _with_speed(reduction: Reduction, name: str) -> Expr:
    """Return the coefficient with c as a symbol."""
    polynomial = reduction.pde.polynomial + reduction.pde.transverse
    terms = {reduction.notation.monomial(m): v for m, v in polynomial.terms.items()}
    return terms[name].as_expr() if name in terms else Integer(0)


def same(difference: Expr, squared: Expr) -> bool:
    """Return whether an expression in c vanishes where c^2 is ``squared``."""
    odd_even = [Integer(0), Integer(0)]
    above = fraction(together(difference))[0]
    for (power,), value in above.as_poly(c).terms() if above.has(c) else [((0,), above)]:
        odd_even[power % 2] += value * squared ** (power // 2)
    return all(cancel(part) == 0 for part in odd_even)


def strain_chain(forces: Mapping[int, Expr]) -> Lattice:
    """Return a chain with springs of several ranges, in the strain between neighbours."""
    bonds = []
    for reach, force in forces.items():
        stretch = tuple(Stencil((i,)) for i in range(reach))
        ends = {1: 1, 1 - reach: -1, -reach: 1}
        ends[0] = ends.get(0, 0) - 1
        bonds.append(Bond(stretch, force, tuple(Stencil((i,), w) for i, w in ends.items())))
    return Lattice("chain", "chain in the strain", ("y",), (Integer(1),), tuple(bonds))


def with_values(lattice: Lattice, values: Mapping[Symbol, Expr]) -> Lattice:
    """Return the lattice with values in place of constants."""
    bonds = tuple(replace(bond, force=bond.force.subs(values)) for bond in lattice.bonds)
    return replace(lattice, bonds=bonds)


def _along(direction: tuple[Expr, Expr], across: tuple[Expr, Expr], moving: Expr) -> Scaling:
    return Scaling(0, (SlowVariable("X", 1, direction, c), SlowVariable("Z", 2, across, moving)))


ONE, NIL = Integer(1), Integer(0)
AXIS, OBLIQUE, DRIFTING = (
    _along((ONE, NIL), (NIL, ONE), NIL),
    _along((C, S), (-S, C), NIL),
    _along((C, S), (-S, C), drift),
)


def size(scaling: Scaling, amplitude: int) -> Scaling:
    """Return the ansatz with another power of the amplitude."""
    return replace(scaling, amplitude=amplitude)


STRAIN, NEXT = LATTICES["fput_strain"], LATTICES["next_nearest"]
DIMER, SQUARE = LATTICES["dimer"], LATTICES["square"]
ODD = {K3: NIL, L3: NIL, H3: NIL}
FLAT = {L2: -K2 / 16}
NEARLY = {K2: (4 * S2 - eps**2 * d) / 3, L2: (eps**2 * d - S2) / 12}
FAR_SQUARE = replace(
    SQUARE, bonds=(*SQUARE.bonds, spring(cubic(L2, L3, L4), ((0, 0), 0), ((2, 0), 0)))
)
SAME = {H2: K2, H3: K3, H4: K4}
BALANCED = {H3: -K3 * H2**3 / K2**3}
THIRD = c / 24
CUBIC = 3 * K4 / (2 * c)
FIFTH = -c / 180
FAR_QUADRATIC, FAR_CUBIC = (K3 + 8 * L3) / c, 3 * (K4 + 16 * L4) / (2 * c)
FAR_THIRD = (K2 + 16 * L2) / (24 * c)
ACROSS = H2 / (2 * c)
DAMPING, DASHPOT, SECOND = symbols("gamma eta theta", positive=True)
LOSSES = {"site": "eps^3*gamma", "bond": "eps*eta"}
SPRINGS = (2 * K3**2 / K2**5 - K4 / K2**4) + (2 * BALANCED[H3] ** 2 / H2**5 - H4 / H2**4)

ROWS = (
    Row(
        "1", "mKdV", with_values(STRAIN, {K3: NIL}), Scaling(), K2,
        {"Y^2 Y_X": CUBIC, "Y_XXX": THIRD},
    ),
    Row("2", "KdV", STRAIN, Scaling(2), K2, {"Y Y_X": K3 / c, "Y_XXX": THIRD}),
    Row(
        "3", "Gardner", with_values(STRAIN, {K3: eps * k3}), Scaling(), K2,
        {"Y Y_X": k3 / c, "Y^2 Y_X": CUBIC, "Y_XXX": THIRD},
    ),
    Row(
        "4a", "KdV", STRAIN, Scaling(2, background=((0, ybar),)),
        K2 + 2 * K3 * ybar + 3 * K4 * ybar**2,
        {"Y Y_X": (K3 + 3 * K4 * ybar) / c, "Y_XXX": THIRD},
    ),
    Row(
        "4b", "mKdV", STRAIN, Scaling(background=((0, -K3 / (3 * K4)),)), K2 - K3**2 / (3 * K4),
        {"Y^2 Y_X": CUBIC, "Y_XXX": THIRD},
    ),
    Row(
        "4c", "Gardner", with_values(STRAIN, {K3: NIL}), Scaling(background=((1, b),)), K2,
        {"Y_X": CUBIC * b**2, "Y Y_X": 2 * b * CUBIC, "Y^2 Y_X": CUBIC, "Y_XXX": THIRD},
    ),
    Row(
        "5a", "KdV", NEXT, Scaling(2), K2 + 4 * L2,
        {"Y Y_X": FAR_QUADRATIC, "Y_XXX": FAR_THIRD},
    ),
    Row(
        "5b", "mKdV", with_values(NEXT, ODD), Scaling(), K2 + 4 * L2,
        {"Y^2 Y_X": FAR_CUBIC, "Y_XXX": FAR_THIRD},
    ),
    Row(
        "5c", "fifth-order KdV", with_values(NEXT, FLAT), Scaling(4, time=5), 3 * K2 / 4,
        {"Y Y_X": FAR_QUADRATIC, "Y_5X": FIFTH},
    ),
    Row(
        "5d", "fifth-order mKdV", with_values(NEXT, {**FLAT, **ODD}), Scaling(2, time=5),
        3 * K2 / 4,
        {"Y^2 Y_X": FAR_CUBIC, "Y_5X": FIFTH},
    ),
    Row(
        "5e", "Kawahara", with_values(NEXT, NEARLY), Scaling(4, time=5), S2,
        {"Y Y_X": FAR_QUADRATIC, "Y_XXX": d / (24 * c), "Y_5X": FIFTH},
    ),
    Row(
        "5f", "modified Kawahara", with_values(NEXT, {**NEARLY, **ODD}), Scaling(2, time=5), S2,
        {"Y^2 Y_X": FAR_CUBIC, "Y_XXX": d / (24 * c), "Y_5X": FIFTH},
    ),
    Row(
        "6a", "mKdV", with_values(LATTICES["mass_dimer"], ODD), Scaling(0), K2 / (2 * M),
        {"Y^2 Y_X": 3 * c * K4 / (8 * K2), "Y_XXX": THIRD * MASSES},
    ),
    Row(
        "6b", "KdV", LATTICES["mass_dimer"], Scaling(1), K2 / (2 * M),
        {"Y Y_X": c * K3 / (2 * K2), "Y_XXX": THIRD * MASSES},
    ),
    Row(
        "6c", "mKdV", with_values(DIMER, ODD), Scaling(0), SERIES,
        {
            "Y^2 Y_X": 3 * c / 2 * (H2**4 * K4 + K2**4 * H4) / (H2 * K2 * (H2 + K2) ** 3),
            "Y_XXX": THIRD * TWO,
        },
    ),
    Row(
        "6d", "KdV", DIMER, Scaling(1), SERIES,
        {
            "Y Y_X": c * (H2**3 * K3 + K2**3 * H3) / (H2 * K2 * (H2 + K2) ** 2),
            "Y_XXX": THIRD * TWO,
        },
    ),
    Row(
        "6e", "mKdV", with_values(DIMER, BALANCED), Scaling(0), SERIES,
        {"Y^2 Y_X": -3 / (2 * M * c) * SPRINGS / (1 / K2 + 1 / H2) ** 4, "Y_XXX": THIRD * TWO},
    ),
    Row(
        "7a", "KP-II", SQUARE, size(AXIS, 1), K2,
        {"Y Y_X": K3 / c, "Y_XXX": THIRD, "Y_ZZ": ACROSS},
    ),
    Row(
        "7b", "generalised KP-II", with_values(SQUARE, {K3: NIL}), AXIS, K2,
        {"Y^2 Y_X": CUBIC, "Y_XXX": THIRD, "Y_ZZ": ACROSS},
    ),
    Row(
        "7c", "KP-I or KP-II", FAR_SQUARE, size(AXIS, 1), K2 + 4 * L2,
        {"Y Y_X": FAR_QUADRATIC, "Y_XXX": FAR_THIRD, "Y_ZZ": ACROSS},
    ),
    Row(
        "7d", "generalised KP-I or generalised KP-II", with_values(FAR_SQUARE, ODD), AXIS,
        K2 + 4 * L2,
        {"Y^2 Y_X": FAR_CUBIC, "Y_XXX": FAR_THIRD, "Y_ZZ": ACROSS},
    ),
    Row(
        "7c, KP-I", "KP-I", with_values(FAR_SQUARE, {L2: -K2 / 8}), size(AXIS, 1), K2 / 2,
        {"Y Y_X": FAR_QUADRATIC, "Y_XXX": -K2 / (24 * c), "Y_ZZ": ACROSS},
    ),
    Row(
        "7e", "KP-II", with_values(SQUARE, SAME), size(OBLIQUE, 1), K2,
        {"Y Y_X": K3 / c * (C**3 + S**3), "Y_XXX": THIRD * (C**4 + S**4), "Y_ZZ": c / 2},
    ),
    Row(
        "7f", "generalised KP-II", with_values(SQUARE, {**SAME, K3: NIL, H3: NIL}), OBLIQUE, K2,
        {"Y^2 Y_X": CUBIC * (C**4 + S**4), "Y_XXX": THIRD * (C**4 + S**4), "Y_ZZ": c / 2},
    ),
    Row(
        "7h", "KP-II", SQUARE, size(DRIFTING, 1), INCLINED,
        {
            "Y Y_X": (K3 * C**3 + H3 * S**3) / c,
            "Y_XXX": (K2 * C**4 + H2 * S**4) / (24 * c),
            "Y_ZZ": K2 * H2 / (2 * c**3),
        },
    ),
    Row(
        "7h, cubic", "generalised KP-II", with_values(SQUARE, ODD), DRIFTING, INCLINED,
        {
            "Y^2 Y_X": 3 * (K4 * C**4 + H4 * S**4) / (2 * c),
            "Y_XXX": (K2 * C**4 + H2 * S**4) / (24 * c),
            "Y_ZZ": K2 * H2 / (2 * c**3),
        },
    ),
    Row(
        "1, losses", "damped mKdV-Burgers", with_values(STRAIN, {K3: NIL}).with_losses(**LOSSES),
        Scaling(), K2,
        {"Y^2 Y_X": CUBIC, "Y_XXX": THIRD, "Y": DAMPING / 2, "Y_XX": -DASHPOT / 2},
    ),
    Row(
        "3, losses", "damped Gardner-Burgers",
        with_values(STRAIN, {K3: eps * k3}).with_losses(**LOSSES), Scaling(), K2,
        {
            "Y Y_X": k3 / c, "Y^2 Y_X": CUBIC, "Y_XXX": THIRD,
            "Y": DAMPING / 2, "Y_XX": -DASHPOT / 2,
        },
    ),
    Row(
        "5a, dashpots", "KdV-Burgers", NEXT.with_losses(bond={1: "eps*eta", 2: "eps*theta"}),
        Scaling(2), K2 + 4 * L2,
        {"Y Y_X": FAR_QUADRATIC, "Y_XXX": FAR_THIRD, "Y_XX": -(DASHPOT + 4 * SECOND) / 2},
    ),
    Row(
        "5e, losses", "damped Kawahara-Burgers",
        with_values(NEXT, NEARLY).with_losses(site="eps^5*gamma", bond={1: "eps^3*eta"}),
        Scaling(4, time=5), S2,
        {
            "Y Y_X": FAR_QUADRATIC, "Y_XXX": d / (24 * c), "Y_5X": FIFTH,
            "Y": DAMPING / 2, "Y_XX": -DASHPOT / 2,
        },
    ),
    Row(
        "6b, one mass", "damped KdV", LATTICES["mass_dimer"].with_losses({"v": "eps^3*gamma"}),
        Scaling(1), K2 / (2 * M),
        {"Y Y_X": c * K3 / (2 * K2), "Y_XXX": THIRD * MASSES, "Y": DAMPING / (2 * M)},
    ),
    Row(
        "6d, losses", "damped KdV-Burgers", DIMER.with_losses(**LOSSES), Scaling(1), SERIES,
        {
            "Y Y_X": c * (H2**3 * K3 + K2**3 * H3) / (H2 * K2 * (H2 + K2) ** 2),
            "Y_XXX": THIRD * TWO,
            "Y": DAMPING / M,
            "Y_XX": -DASHPOT * (H2**2 + K2**2) / (2 * M * (H2 + K2) ** 2),
        },
    ),
    Row(
        "7a, losses", "damped KP-II-Burgers", SQUARE.with_losses(**LOSSES), size(AXIS, 1), K2,
        {
            "Y Y_X": K3 / c, "Y_XXX": THIRD, "Y_ZZ": ACROSS,
            "Y": DAMPING / 2, "Y_XX": -DASHPOT / 2,
        },
    ),
    Row(
        "Burgers", "Burgers", LATTICES["alpha_fput"].with_losses(bond="eta"), Scaling(0, time=2),
        K2, {"Y Y_X": K3 / c, "Y_XX": -DASHPOT / 2},
    ),
)  # fmt: skip
"""The table's rows; `of_range` builds those of springs of any range."""


def of_range(reaches: tuple[int, ...], *, odd: bool) -> Row:
    """Return the row of springs of several ranges, whose coefficients are sums over these."""
    named = {r: symbols(f"P{r} Q{r} R{r}", real=True) for r in reaches}
    forces = {r: p * x + (0 if odd else q) * x**2 + s * x**3 for r, (p, q, s) in named.items()}

    def total(power: int, place: int) -> Expr:
        return sum((r**power * Rational(1) * named[r][place] for r in reaches), NIL)

    return Row(
        f"range {max(reaches)}{', cubic' if odd else ''}",
        "mKdV" if odd else "KdV",
        strain_chain(forces),
        Scaling(1 if odd else 2),
        total(2, 0),
        {
            "Y_XXX": total(4, 0) / (24 * c),
            **({"Y^2 Y_X": 3 * total(4, 2) / (2 * c)} if odd else {"Y Y_X": total(3, 1) / c}),
        },
    )


def all_rows() -> tuple[Row, ...]:
    """Return the rows of the table, and rows of springs up to the fifth neighbour."""
    ranges = ((1, 2, 3), (1, 2, 3, 4, 5), (2, 3))
    return (*ROWS, *(of_range(r, odd=odd) for r in ranges for odd in (False, True)))
