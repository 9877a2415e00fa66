"""The arithmetic chosen, and that each choice holds the promised 1e-13."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from solutions import CATALOGUE, Wave, closed_form, rational

NEAR_ONE = 1 - Fraction(1, 10**12)


@pytest.mark.parametrize(
    ("name", "modulus", "precision"),
    [
        ("rogue_cn", 0.9, "double"),
        ("rogue_cn", 0.91, "double-double"),
        ("soliton_dn", 0.99, "double"),
        ("soliton_dn", NEAR_ONE, "double-double"),
        ("wave_cn", NEAR_ONE, "double"),
    ],
)
def test_choice(name: str, modulus: Any, precision: str, normal_forms: Any) -> None:
    assert Wave(closed_form(name), normal_forms[1], k=modulus).precision == precision


@pytest.mark.parametrize(
    ("name", "ordinary", "large"),
    [
        ("breather", {"p": 1, "q": 2}, {"p": 2.1, "q": 1}),
        ("double_pole", {"A": 2}, {"A": 2.1}),
        ("two_soliton", {"A_1": 2, "A_2": 1}, {"A_1": 3, "A_2": 1}),
        ("soliton_background", {"U_0": -1, "kappa": 2}, {"U_0": -1.1, "kappa": 1}),
        ("kink_antikink", {"A": 2, "kappa": 1}, {"A": 2.1, "kappa": 1}),
    ],
)
def test_large_amplitudes_need_pairs(
    name: str, ordinary: Any, large: Any, normal_forms: Any
) -> None:
    form = closed_form(name)
    found = [Wave(form, normal_forms[form.equation.s], **v).precision for v in (ordinary, large)]
    assert found == ["double", "double-double"]


def test_choice_can_be_overruled(normal_forms: Any) -> None:
    form = closed_form("rogue_cn")
    assert Wave(form, normal_forms[1], k=0.5, precision="double-double").precision != "double"
    with pytest.raises(ValueError, match="precision must be 'double' or 'double-double', got 'x'"):
        Wave(form, normal_forms[1], k=0.5, precision="x")


def test_higher_rational_solutions_need_pairs(normal_forms: Any) -> None:
    form = rational(5)
    assert Wave(form, normal_forms[1]).precision == "double-double"
    assert form.hard is not None
    assert "cancel" in form.hard.reason


@pytest.mark.parametrize(("name", "bound"), [("rogue_cn", 0.9), ("soliton_dn", 0.99)])
def test_double_holds_up_to_the_bound_and_not_far_beyond(
    name: str, bound: float, normal_forms: Any
) -> None:
    """Double against double-double at 4000 points; near k = 1 the condition number shows."""
    n, t, eps = np.linspace(-900.0, 900.0, 2001), np.array([[0.0], [-4000.0]]), 0.05
    worst = []
    for modulus in (bound, NEAR_ONE):
        wave = Wave(closed_form(name), normal_forms[1], k=modulus, precision="double")
        found, exact = wave.at(n, t, eps), wave.pairs_at(n, t, eps)
        errors = [
            abs(v - r[0]) / np.maximum(1, abs(r[0])) for v, r in zip(found, exact, strict=True)
        ]
        worst.append(np.max(errors))
    assert worst[0] < 5e-14
    assert worst[1] > 1e-12


@pytest.mark.parametrize("form", CATALOGUE, ids=lambda form: form.name)
def test_pairs_have_25_digits(form: Any, draw: Any, normal_forms: Any, ctx: Any) -> None:
    wave = Wave(form, normal_forms[form.equation.s], **draw(form))
    n, t = 37.0, 3.0
    X = Fraction(1, 4) * (int(n) - int(wave.normal_form.c) * int(t))
    exact = wave.mp(X, Fraction(1, 64) * int(t), 40)
    for found, wanted in zip(wave.pairs_at(n, t, 0.25), exact, strict=True):
        assert abs(ctx.mpf(float(found[0])) + float(found[1]) - wanted) < 1e-25


def test_pairs_agree_in_double(normal_forms: Any, rng: np.random.Generator) -> None:
    wave = Wave(closed_form("breather_sn"), normal_forms[-1], k=0.6, alpha=0.4)
    n = rng.normal(scale=100, size=(3, 700))
    for single, pair in zip(wave.at(n, 2.0, 0.1), wave.pairs_at(n, 2.0, 0.1), strict=True):
        assert pair.shape == (2, 3, 700)
        assert np.allclose(single, pair[0], rtol=0, atol=1e-14)
