"""The normal form and the numbers that enter it."""

from decimal import Decimal
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sympy import (
    Float,
    I,
    MatrixSymbol,
    Rational,
    Symbol,
    nan,
    oo,
    sin,
    sqrt,
    symbols,
    true,
    zoo,
)

from longwave.derive import initial_velocity, mkdv_normal_form, mkdv_reduction
from longwave.derive.algebra.exact_numbers import exact, parse_rational
from longwave.derive.symbols import K2, K4, c, eps

nonzero = st.fractions(min_value=-50, max_value=50, max_denominator=40).filter(bool)


@settings(max_examples=25)
@given(nonzero.map(abs), nonzero)
def test_normal_form_maps_the_equation(stiffness: Any, cubic: Any) -> None:
    """Put Y = U(a X, b T) in the equation: its coefficients become 1, 6 s, 1."""
    form = mkdv_normal_form(stiffness, cubic)
    values = mkdv_reduction().coefficients(K2=stiffness, K4=cubic)
    assert values.dispersive * form.a**3 / form.b == 1
    assert (values.terms["Y^2 Y_X"] * form.a / form.b - 6 * form.s).simplify() == 0
    assert form.s == (1 if cubic > 0 else -1)
    assert form.c**2 == Rational(stiffness.numerator, stiffness.denominator)


def test_symbols_are_allowed() -> None:
    stiffness, cubic = symbols("p q", positive=True)
    form = mkdv_normal_form(stiffness, cubic)
    assert form.a == sqrt(6 * cubic / stiffness)
    assert form.s == 1
    swapped = mkdv_reduction().normal_form(K2=Symbol("K4", positive=True))
    assert swapped.c == sqrt(Symbol("K4", positive=True))


def test_derived_symbolic_form_is_the_known_one() -> None:
    assert mkdv_normal_form(K2, K4).a ** 2 == 6 * abs(K4) / K2


@pytest.mark.parametrize(
    "value",
    [
        0.1,
        "0.1",
        "1/10",
        Fraction(1, 10),
        Decimal("0.1"),
        np.float64(0.1),
        np.float32(0.1),
        Float(0.1),
        mpmath.mpf("0.1"),
        Rational(1, 10),
    ],
)
def test_every_spelling_of_a_tenth_is_a_tenth(value: Any) -> None:
    assert exact("K2", value) == Rational(1, 10)
    assert mkdv_normal_form(value, np.int64(1)) == mkdv_normal_form(Fraction(1, 10), 1)


@pytest.mark.parametrize(
    "value",
    [
        *(float("nan"), float("inf"), "nan", "", "1/0", "__import__", "1" * 5000, True, 1j, [1]),
        *(nan, oo, zoo, true, I, Symbol("p") + oo, I * Symbol("p"), MatrixSymbol("A", 2, 2)),
        *(Decimal("nan"), Decimal("1e99999"), mpmath.mpf("inf"), mpmath.mpc(1, 1), mpmath.mp.pi),
        *(np.True_, np.array([1.0]), np.complex128(1), np.datetime64(1, "s"), None),
    ],
    ids=repr,
)
def test_an_invalid_number_is_refused(value: Any) -> None:
    with pytest.raises(ValueError, match="K4 must"):
        mkdv_normal_form(4, value)


@pytest.mark.parametrize(
    "value",
    [Float(0.1) * sqrt(2), K2 + 0.5, sin(0.1 * K2), sqrt(K2 + Float(0.25)), K2 / (1 + 1e-30 * K4)],
    ids=str,
)
def test_a_float_anywhere_in_an_expression_is_refused(value: Any) -> None:
    with pytest.raises(ValueError, match=r"K2 must be exact, got .* with a float in it"):
        exact("K2", value)


def test_a_number_of_more_digits_than_a_float_keeps_them_or_is_refused() -> None:
    digits = "0.123456789012345678901234567891"
    assert exact("K2", Float(digits, 30)) == Rational(digits)
    precise = mpmath.MPContext()
    precise.dps = 50
    with pytest.raises(ValueError, match="K2 must be a finite real number"):
        exact("K2", precise.mpf(1) / 3)


def test_a_value_that_its_symbol_excludes_is_refused() -> None:
    """K2 is declared positive, and the reduction divides by it on that word."""
    with pytest.raises(
        ValueError, match=r"K2 must be positive, got -1 .the equation is derived for"
    ):
        mkdv_reduction().coefficients(K2=-1)


@pytest.mark.parametrize("text", ["1;2", "2**3", "1e9999", "0x10", "4 4", "١"])
def test_only_plain_rationals_are_read(text: str) -> None:
    with pytest.raises(ValueError, match="must be a rational number"):
        parse_rational("K2", text)


@pytest.mark.parametrize(
    ("stiffness", "cubic", "message"),
    [(0, 1, "K2 must satisfy K2 > 0, got 0"), (-1, 1, "got -1"), (1, 0, "K4 must satisfy K4 != 0")],
)
def test_constants_out_of_range_are_refused(stiffness: Any, cubic: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        mkdv_normal_form(stiffness, cubic)


def test_violated_condition_is_refused_with_its_reason() -> None:
    with pytest.raises(ValueError, match=r"K3 = 0, got K3 = 1 .*order eps\^4 reads K3 \(Y\^2\)_XX"):
        mkdv_reduction().coefficients(K2=4, K3=1, K4=1)


def test_unknown_constant_is_refused() -> None:
    with pytest.raises(ValueError, match="constants must be among K2, K3, K4, got 'K5'"):
        mkdv_reduction().coefficients(K5=1)


def test_initial_velocity_is_the_chain_rule() -> None:
    Y_X, Y_T = symbols("Y_X Y_T")
    assert initial_velocity() == eps**4 * Y_T - c * eps**2 * Y_X
