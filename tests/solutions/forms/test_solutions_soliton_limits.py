"""Solitons and breathers at the ends of their domains tend to the waves named there."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from longwave.solutions import Wave, closed_form

TINY = Fraction(1, 10**8)
X, T = np.meshgrid(np.linspace(-6.0, 6.0, 61), [-0.7, 0.0, 1.3])


def wave(normal_forms: Any, name: str, **parameters: object) -> Wave:
    form = closed_form(name)
    return Wave(form, normal_forms[form.equation.s], **parameters)


def gap(one: Wave, other: Wave, shift: float = 0.0) -> float:
    """Return the largest difference of Y, Y_X, Y_T; ``shift`` (of xi) moves ``other`` right."""
    moved = X - shift / float(other.normal_form.a)
    pairs = zip(one(X, T), other(moved, T), strict=True)
    return max(float(np.max(np.abs(a - b))) for a, b in pairs)


def test_breather_tends_to_the_double_pole_soliton(normal_forms: Any) -> None:
    """The breather's X_0 shifts its envelope, the double pole's its other phase."""
    limit = wave(normal_forms, "double_pole", A=1)
    assert gap(wave(normal_forms, "breather", p=TINY, q=1), limit) < 1e-13
    assert gap(wave(normal_forms, "breather", p=0.3, q=1), limit) > 1e-3


def test_breather_of_small_amplitude_vanishes(normal_forms: Any) -> None:
    assert np.max(np.abs(wave(normal_forms, "breather", p=1, q=TINY)(X, T).Y)) < 3e-8


@pytest.mark.parametrize(("weaker", "centre"), [(TINY, 0.0), (1 - TINY, -np.log(2.0))])
def test_two_solitons_tend_to_one(weaker: Any, centre: float, normal_forms: Any) -> None:
    """Its equal is left behind far away: what remains is 2 d/dxi arctan(2 exp(theta))."""
    soliton = wave(normal_forms, "soliton_sech", A=1)
    assert gap(wave(normal_forms, "two_soliton", A_1=1, A_2=weaker), soliton, centre) < 1e-7
    assert gap(wave(normal_forms, "two_soliton", A_1=1, A_2=0.5), soliton, centre) > 1e-2


@pytest.mark.parametrize("T_far", [-300.0, 300.0])
def test_two_solitons_far_apart_have_their_own_heights(T_far: float, normal_forms: Any) -> None:
    both = wave(normal_forms, "two_soliton", A_1=2, A_2=1)
    n = np.linspace(0.0, 1.6 * float(both.normal_form.b) * T_far, 400_001)
    Y = both(n * 3 / float(both.normal_form.a), T_far).Y
    peaks = Y[1:-1][(Y[1:-1] > Y[:-2]) & (Y[1:-1] > Y[2:])]
    assert sorted(peaks) == pytest.approx([1.0, 2.0], abs=1e-5)


def test_soliton_on_a_constant_tends_to_the_lorentzian(normal_forms: Any) -> None:
    lorentzian = wave(normal_forms, "rational_1")
    near = wave(normal_forms, "soliton_background", U_0=-1, kappa=TINY)
    assert gap(near, lorentzian) < 1e-13
    far = wave(normal_forms, "soliton_background", U_0=-1, kappa=0.3)
    assert gap(far, lorentzian) > 1e-3


def test_soliton_on_zero_is_the_sech_soliton(normal_forms: Any) -> None:
    soliton = wave(normal_forms, "soliton_sech", A=1.3)
    assert gap(wave(normal_forms, "soliton_background", U_0=0, kappa=1.3), soliton) < 1e-14


@pytest.mark.parametrize("name", ["soliton_background", "kink_antikink"])
def test_a_weak_soliton_leaves_the_constant(name: str, normal_forms: Any) -> None:
    level = {"soliton_background": "U_0", "kink_antikink": "A"}[name]
    values = wave(normal_forms, name, **{level: 1, "kappa": TINY})(X, T)
    assert np.max(np.abs(values.Y - 1)) < 1e-15
    assert np.max(np.abs(values.Y_X)) < 1e-15


def test_wide_dark_soliton_is_a_kink_and_an_antikink(normal_forms: Any) -> None:
    """At kappa = 2A/(1 + delta) each flank is the kink, moved by half the table's width."""
    delta = Fraction(1, 10**10)
    table = wave(normal_forms, "kink_antikink", A=1, kappa=2 / (1 + delta))
    assert float(table(0.0, 0.0).Y) == pytest.approx(-1, abs=1e-4)
    kink = wave(normal_forms, "kink", A=1)
    half_width = float(np.log(2 / float(delta))) / 4
    a = float(table.normal_form.a)
    near = np.linspace(-1.0, 1.0, 41)
    for side in (1, -1):
        flank = table(near + side * half_width / a, 0.0).Y
        assert np.allclose(flank, side * kink(near, 0.0).Y, rtol=0, atol=1e-4)


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("breather", {"p": 0, "q": 1}, "p = 0 is the double-pole soliton"),
        ("two_soliton", {"A_1": 1, "A_2": 1}, "A_2 = A_1 is the sech soliton"),
        ("kink_antikink", {"A": 1, "kappa": 2}, r"kappa = 2\*A is a kink and an antikink"),
    ],
)
def test_the_limit_itself_is_named(
    name: str, values: dict[str, Any], message: str, normal_forms: Any
) -> None:
    with pytest.raises(ValueError, match=message):
        wave(normal_forms, name, **values)
