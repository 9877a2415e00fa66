"""Derivations of large cells, against formulas found by hand, identities and equal beads."""

from typing import Any

import pytest
from sympy import Rational, Symbol, simplify, sqrt

from longwave.derive import LATTICES, checks_of_envelope, envelope
from tests.derive.large_cells import (
    FOUR,
    MASSES,
    SPRING,
    four_constants,
    four_numbers,
    four_springs,
    hertz_dimer,
    hertz_numbers,
    hertz_symbols,
    long_waves,
)


def test_the_envelope_of_a_hertz_dimer_holds_in_numbers_and_in_symbols() -> None:
    """Catches: a factor that is left above and below the line, a root taken for another."""
    numbers, symbols = hertz_numbers(), hertz_symbols()
    for found in (numbers, symbols):
        assert all(check.passed for check in checks_of_envelope(found))
    values: Any = {"A": 1, "d": Rational(2, 3), "m1": 1, "m2": 3}
    expected = symbols.coefficients(1, **values)
    assert numbers.coefficients(m1=1, m2=3) == expected
    stiffness = float(3 * sqrt(Rational(2, 3)) / 2)
    squared = expected.omega**2 / stiffness
    assert abs(3 * squared**2 - 8 * squared + 2 - 2 * 0.5403023058681398) < 1e-14
    assert [str(s) for s, _ in hertz_dimer().expanded(4).definitions] == [
        f"F{power}a" for power in range(5)
    ]


def test_equal_beads_in_turn_are_the_granular_chain() -> None:
    """Catches: a wrong force on the second bead; cells of two count wavenumber and space double."""
    values: Any = {"A": 2, "d": Rational(1, 2)}
    chain = envelope(LATTICES["granular"]).coefficients(Rational(1, 2), **values)
    cells = envelope(hertz_dimer()).coefficients(1, m1=1, m2=1, **values)
    powers = {"omega": 0, "v": 1, "p": 2, "q": 0, "a3": 3, "a1": 1, "a2": 1, "second": 0}
    for name, power in powers.items():
        assert abs(getattr(cells, name) * 2**power - getattr(chain, name)) < 1e-12, name


@pytest.mark.slow
def test_the_envelope_of_four_masses_holds_in_numbers_and_in_symbols() -> None:
    """Catches: a cofactor with the wrong sign, a constant that is lost on the way."""
    numbers = four_numbers()
    assert all(check.passed for check in checks_of_envelope(numbers))
    values: Any = {**FOUR, **SPRING}
    assert numbers.coefficients(**values) == four_constants().coefficients(**values)


@pytest.mark.slow
def test_long_waves_of_four_masses_and_springs_are_those_of_their_static_law() -> None:
    """c^2 = 1/(S M) and c'(0) = Q/(S^3 M c) by hand: S = sum 1/K, M = sum m, Q = sum K3/K^3."""
    found = long_waves()
    laws = [bond.coefficients() for bond in four_springs().bonds]
    S = sum(1 / law[-2] for law in laws)
    Q = sum(law[-3] / law[-2] ** 3 for law in laws)
    M = sum(MASSES)
    assert simplify(found.speed_squared - 1 / (S * M)) == 0
    values = {str(s): Rational(3 + i, 2 + i % 3) for i, s in enumerate(four_springs().constants)}
    at = {Symbol(name): value for name, value in values.items()}

    def number(value: Any) -> Any:
        return value.subs({s: at[Symbol(str(s))] for s in value.free_symbols})

    numbers = found.coefficients(**values)
    assert simplify(numbers.terms["Y Y_X"] - number(Q / (S**3 * M)) / numbers.c) == 0
