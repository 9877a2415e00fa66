"""Parameters: domains, exact values, messages."""

import re
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import sympy as sp

from longwave.derive.algebra.exact_numbers import exact_number
from longwave.solutions import closed_form
from longwave.solutions.symbols import X_0, alpha, k

BREATHER = closed_form("breather_sn")
DN = closed_form("soliton_dn")


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        (
            "wave_cn",
            {"k": 1.2},
            "k must satisfy 0 < k < 1, got 1.2 (k = 1 is the sech soliton)",
        ),
        (
            "soliton_dn",
            {"k": 0},
            "k must satisfy 0 < k < 1, got 0 (k = 0 is the algebraic soliton rational_1)",
        ),
        ("soliton_dn", {"k": 1.0}, "k must satisfy 0 < k < 1, got 1.0 (k = 1 is the double-pole"),
        ("soliton_dn", {"k": float("nan")}, "k must be finite, got nan"),
        ("soliton_dn", {"k": float("inf")}, "k must be finite, got inf"),
        ("soliton_dn", {"k": "0.5"}, "k must be a real number, got '0.5' (write it without"),
        ("soliton_dn", {"k": 1j}, "k must be a real number, got 1j"),
        ("soliton_dn", {"k": True}, "k must be a real number, got True"),
        ("soliton_dn", {"k": k}, "k must be a number, got k (substitute its symbols first)"),
        ("soliton_dn", {}, "k must satisfy 0 < k < 1, got nothing"),
        (
            "soliton_dn",
            {"k": 0.5, "m": 1},
            "those of soliton_dn, got m (it takes k)",
        ),
        (
            "soliton_dn",
            {"k": 0.5, "m" * 4000: 1},
            f"those of soliton_dn, got {'m' * 60} (it takes k)",
        ),
        (
            "rational_2",
            {"k": 0.5},
            "those of rational_2, got k (it takes no parameters)",
        ),
        ("kink", {"A": -1}, "A must satisfy 0 < A, got -1 (A = 0 is the zero solution)"),
        ("breather_sn", {"alpha": 1.0}, "k must satisfy 0 < k < 1, got nothing"),
    ],
)
def test_messages(name: str, values: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        closed_form(name).check(values)


def test_alpha_is_bounded_by_the_quarter_period() -> None:
    message = (
        "alpha must satisfy 0 < alpha < elliptic_k(k**2) (elliptic_k(k**2) = 1.68575), got 1.7 "
        "(alpha = elliptic_k(k**2) is the bare snoidal wave reversed)"
    )
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        BREATHER.check({"k": 0.5, "alpha": 1.7})
    assert BREATHER.check({"k": 0.5, "alpha": 1.68575})[alpha] == sp.Rational(168575, 100000)


def test_quarter_period_itself_is_refused_exactly() -> None:
    quarter = sp.elliptic_k(sp.Rational(1, 4))
    with pytest.raises(ValueError, match="alpha must satisfy"):
        BREATHER.check({"k": 0.5, "alpha": quarter})
    assert BREATHER.check({"k": 0.5, "alpha": quarter / 2})[alpha] == quarter / 2


def test_default() -> None:
    assert BREATHER.check({"k": 0.5, "alpha": 0.5})[X_0] == 0


@pytest.mark.parametrize("value", [0.7, np.float64(0.7), Fraction(7, 10), Decimal("0.7")])
def test_exact_value_of_the_literal(value: object) -> None:
    assert DN.check({"k": value})[k] == sp.Rational(7, 10)


def test_integers_stay_integers() -> None:
    assert exact_number("n", np.int64(3)) == sp.Integer(3)
