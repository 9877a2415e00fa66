"""The neighbouring limits named in the parameters' bounds, reached from inside the domain."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import sympy as sp

from longwave.solutions import Wave, closed_form
from longwave.solutions.symbols import xi

TINY = Fraction(1, 10**8)
NEAR_ONE = 1 - Fraction(1, 10**12)
X, T = np.meshgrid(np.linspace(-3.0, 3.0, 41), [-0.7, 0.0, 1.3])


def gap(wave: Wave, other: Wave, sign: float = 1.0) -> float:
    """Return the largest difference of Y, Y_X, Y_T."""
    pairs = zip(wave(X, T), other(X, T), strict=True)
    return max(float(np.max(np.abs(a - sign * b))) for a, b in pairs)


@pytest.mark.parametrize(
    ("name", "limit", "s"),
    [("wave_cn", "soliton_sech", 1), ("wave_dn", "soliton_sech", 1), ("wave_sn", "kink", -1)],
)
def test_bare_waves_tend_to_their_soliton(name: str, limit: str, s: int, normal_forms: Any) -> None:
    soliton = Wave(closed_form(limit), normal_forms[s], A=1)
    assert gap(Wave(closed_form(name), normal_forms[s], k=NEAR_ONE), soliton) < 1e-9
    assert gap(Wave(closed_form(name), normal_forms[s], k=0.9), soliton) > 1e-2


def test_small_amplitude_waves_are_sines(normal_forms: Any) -> None:
    for name, s, sine in (("wave_sn", -1, sp.sin), ("wave_cn", 1, sp.cos)):
        wave = Wave(closed_form(name), normal_forms[s], k=TINY)
        phase = float(wave.normal_form.a) * X + float(wave.normal_form.b) * T
        expected = 1e-8 * sp.lambdify(xi, sine(xi), "numpy")(phase)
        assert np.allclose(wave(X, T).Y, expected, rtol=1e-12, atol=1e-22)


def test_dn_soliton_tends_to_the_algebraic_soliton(normal_forms: Any) -> None:
    algebraic = Wave(closed_form("rational_1"), normal_forms[1])
    assert gap(Wave(closed_form("soliton_dn"), normal_forms[1], k=TINY), algebraic) < 1e-13
    assert gap(Wave(closed_form("soliton_dn"), normal_forms[1], k=0.1), algebraic) > 1e-3


def test_dn_soliton_tends_to_the_double_pole_soliton(normal_forms: Any) -> None:
    wave = Wave(closed_form("soliton_dn"), normal_forms[1], k=NEAR_ONE)
    assert gap(wave, Wave(closed_form("double_pole"), normal_forms[1], A=1)) < 1e-4


def test_cn_rogue_wave_peaks_at_three_k(normal_forms: Any) -> None:
    for modulus in (TINY, Fraction(1, 2), NEAR_ONE):
        wave = Wave(closed_form("rogue_cn"), normal_forms[1], k=modulus)
        assert float(wave(0.0, 0.0).Y) == pytest.approx(3 * float(modulus), rel=1e-15)


def test_dark_breather_tends_to_the_bare_wave(normal_forms: Any) -> None:
    k = Fraction(3, 5)
    bare = Wave(closed_form("wave_sn"), normal_forms[-1], k=k)
    quarter = sp.elliptic_k(sp.Rational(9, 25))
    for part, sign in ((sp.Rational(1, 10**8), 1.0), (1 - sp.Rational(1, 10**8), -1.0)):
        wave = Wave(closed_form("breather_sn"), normal_forms[-1], k=k, alpha=part * quarter)
        assert 0 < gap(wave, bare, sign) < 1e-6


@pytest.mark.parametrize(("modulus", "largest"), [(TINY, 1e-8), (NEAR_ONE, 1.0)])
def test_dark_breather_is_bounded_by_k(modulus: Any, largest: float, normal_forms: Any) -> None:
    wave = Wave(closed_form("breather_sn"), normal_forms[-1], k=modulus, alpha=1)
    assert np.max(np.abs(wave(X, T).Y)) <= largest
