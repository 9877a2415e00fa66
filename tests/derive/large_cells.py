"""Cells whose derivations are long: of two fields with roots in their forces, and of four."""

from collections.abc import Callable

from sympy import Expr, Integer, Rational, Symbol

from longwave.derive import LATTICES, Envelope, Reduction, envelope
from longwave.derive.balances import best_balance
from longwave.derive.lattice import Lattice, spring
from longwave.derive.models.lattices import cubic
from longwave.derive.symbols import K2, K3, K4

MASSES = tuple(Symbol(f"m{i}", positive=True) for i in range(1, 5))
PAIR = {"m1": 1, "m2": 3}
FOUR = {"m1": 1, "m2": 2, "m3": 3, "m4": 5}
SPRING = {"K2": 1, "K3": Rational(1, 3), "K4": Rational(1, 5)}


def row(masses: tuple[Expr, ...], forces: tuple[Expr, ...]) -> Lattice:
    """Return a chain with cells of several masses, each with its spring to the next one."""
    count = len(masses)
    ends = [((0,), field) for field in range(count)] + [((1,), 0)]
    bonds = tuple(spring(force, ends[i], ends[i + 1]) for i, force in enumerate(forces))
    return Lattice("row", f"{count} masses in a row", tuple("uvwr"[:count]), masses, bonds)


def hertz_dimer() -> Lattice:
    """Return a chain of two alternating beads under the precompression d."""
    return row(MASSES[:2], (LATTICES["granular"].bonds[0].force,) * 2)


def four_masses() -> Lattice:
    """Return a chain of four alternating masses and equal springs."""
    return row(MASSES, (cubic(K2, K3, K4),) * 4)


def four_springs() -> Lattice:
    """Return a chain of four alternating masses and springs, all with their own constants."""
    names = ([f"{letter}{power}" for power in (2, 3, 4)] for letter in "KHLJ")
    forces = [
        cubic(Symbol(first, positive=True), *(Symbol(name, real=True) for name in others))
        for first, *others in names
    ]
    return row(MASSES, tuple(forces))


def hertz_numbers() -> Envelope:
    """Return the optical envelope of a Hertz dimer in numbers, whose forces have sqrt(2/3)."""
    return envelope(hertz_dimer().with_values({"A": 1, "d": "2/3"}), 1, "optical", **PAIR)


def hertz_symbols() -> Envelope:
    """Return the optical envelope of a Hertz dimer in symbols, at any wavenumber."""
    return envelope(hertz_dimer(), branch="optical")


def four_numbers() -> Envelope:
    """Return the envelope of four alternating masses, all in numbers."""
    return envelope(four_masses(), 1, **FOUR, **SPRING)


def four_constants() -> Envelope:
    """Return the envelope of four alternating masses with symbols for the spring's constants."""
    return envelope(four_masses(), 1, **FOUR)


def long_waves() -> Reduction:
    """Return the reduction of four masses and four springs, all in symbols."""
    return best_balance(four_springs(), Integer(0), 2)


CASES: dict[str, Callable[[], Envelope | Reduction]] = {
    "envelope of a Hertz dimer, numbers": hertz_numbers,
    "envelope of a Hertz dimer, symbols": hertz_symbols,
    "envelope of four masses, numbers": four_numbers,
    "envelope of four masses, symbols for springs": four_constants,
    "long waves of four masses and four springs": long_waves,
}
