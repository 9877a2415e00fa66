"""Rational solutions of every order in double-double."""

import time
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from flint import fmpq

from longwave.solutions import Wave, closed_form, rational
from longwave.solutions.forms.tau_polynomials import rational_tau
from longwave.solutions.run.linear_phase import LinearPhase
from longwave.solutions.run.rational_evaluator import RationalEvaluator
from tests.families import family


@pytest.mark.parametrize("order", [1, 2, 3])
def test_agrees_with_the_printed_forms(order: int, normal_forms: Any) -> None:
    X, T = np.meshgrid(np.linspace(-40, 40, 301), [-2.0, 0.0, 0.4])
    form = closed_form(f"rational_{order}")
    printed = Wave(replace(form, evaluator=None), normal_forms[1])
    for one, other in zip(printed(X, T), Wave(form, normal_forms[1])(X, T), strict=True):
        assert np.allclose(one, other, rtol=1e-15, atol=1e-15)


@pytest.mark.parametrize(
    ("order", "free"), family([(4, ()), (4, (5,)), (6, (5, 7, 11)), (8, ())], slow=("6",))
)
def test_against_sixty_digits(order: int, free: tuple[int, ...], normal_forms: Any) -> None:
    shifts = {f"tau_{index}": Fraction(-7, index) for index in free}
    wave = Wave(rational(order, free), normal_forms[1], **shifts)
    crest = -((12 * 1530) ** (1 / 3)) / float(wave.normal_form.a) + 60_000
    for X, T in ((0.0, 0.0), (0.7, 0.03), (-2.5, 0.1), (crest, 1e4), (1e6, -1e4), (-1e6, 0.0)):
        for found, exact in zip(wave(X, T), wave.mp(X, T, 60), strict=True):
            assert abs(float(found) - exact) < 1e-15 * max(1, abs(exact))


def test_points_may_share_a_time_or_not(normal_forms: Any, rng: np.random.Generator) -> None:
    """More points than a block and than a chunk, in any order."""
    wave = Wave(rational(5), normal_forms[1])
    X, T = rng.normal(scale=3, size=(2, 5000))
    together = wave(X, np.round(T))
    for i in (0, 127, 128, 4095, 4096, 4999):
        alone = wave(X[i], np.round(T[i]))
        assert [part[i] for part in together] == [float(part) for part in alone]


def test_no_overflow_at_order_ten_and_far_away(normal_forms: Any) -> None:
    wave = Wave(rational(10), normal_forms[1])
    X = np.array([0.0, 1e-300, 1.0, 1e6, -1e9])
    for T in (0.0, 1e4, -1e9):
        assert all(np.all(np.isfinite(part)) for part in wave(X, T))
    assert float(wave(0.0, 0.0).Y) == 21.0
    assert float(wave(-1e9, 0.0).Y) == 1.0


@pytest.mark.parametrize("order", [2, 5])
def test_bounds_cover_the_error(order: int) -> None:
    """Catches: bounds made of coefficients with their signs, which may be negative."""
    family = rational_tau(order)
    xi, tau = (part.ravel() for part in np.meshgrid(np.linspace(-9, 9, 25), [-2.5, -0.3, 0.7, 3.0]))
    phases = [LinearPhase(1, -6, 0), LinearPhase(0, 1, 0)]
    found = RationalEvaluator(family, {})(phases, xi, tau)
    assert np.all(found[:, 2] > 0.0)
    A, B = family.A, family.B
    for i, (x, t) in enumerate(zip(map(Fraction, xi), map(Fraction, tau), strict=True)):
        at = [fmpq(*value.as_integer_ratio()) for value in (x - 6 * t, t)]
        a, b, a_x, b_x = (f(*at) for f in (A, B, A.derivative("x"), B.derivative("x")))
        exact = (-1) ** order * (1 - 2 * (a * b_x - a_x * b) / (a * a + b * b))
        error = fmpq(*found[0, 0, i].as_integer_ratio()) - exact
        error += fmpq(*found[0, 1, i].as_integer_ratio())
        assert abs(error) <= fmpq(*found[0, 2, i].as_integer_ratio()) < fmpq(1, 10**24)


def test_order_eight_is_ready_at_once(normal_forms: Any) -> None:
    """Construction and first values took 10 s through SymPy; about 0.3 s now."""
    Wave(rational(2), normal_forms[1])(0.0, 0.0)
    start = time.process_time()
    assert float(Wave(rational(8), normal_forms[1])(0.0, 0.0).Y) == 17.0
    assert time.process_time() - start < 3
