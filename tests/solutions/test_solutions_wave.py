"""Double-precision evaluation against mpmath at 60 digits."""

import subprocess
import sys
import warnings
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest

from longwave.solutions import CATALOGUE, ClosedForm, Wave, closed_form, rational

FORMS = (*CATALOGUE.of("mKdV"), rational(4), rational(3, free=[5]))
TOLERANCE = 1e-13


def error(values: Any, reference: Any) -> float:
    """Return the worst error of Y, Y_X, Y_T in units of max(1, |value|)."""
    pairs = zip(values, reference, strict=True)
    return max(float(abs(v - r) / max(1, abs(r))) for v, r in pairs)


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.name)
def test_value_and_derivatives(
    form: ClosedForm, draw: Any, normal_forms: Any, rng: np.random.Generator
) -> None:
    for scale_X, scale_T in ((2, 0.3), (50, 20), (1e6, 1e4)):
        wave = Wave(form, normal_forms[form.equation.s], **draw(form))
        X, T = float(rng.normal(scale=scale_X)), float(rng.normal(scale=scale_T))
        assert error(wave(X, T), wave.mp(X, T, 60)) < TOLERANCE


@pytest.mark.parametrize("name", ["soliton_dn", "breather_sn", "rogue_cn", "wave_sn"])
@pytest.mark.parametrize("modulus", [0.01, 0.5, 0.99])
def test_extreme_moduli(name: str, modulus: float, normal_forms: Any) -> None:
    form = closed_form(name)
    extra = {"alpha": 0.01, "X_0": 0.3} if name == "breather_sn" else {}
    wave = Wave(form, normal_forms[form.equation.s], k=modulus, **extra)
    for X, T in ((0.0, 0.0), (1.7, -0.3), (-913.5, 77.0)):
        assert error(wave(X, T), wave.mp(X, T, 60)) < TOLERANCE


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.name)
def test_site_and_time_lose_no_digit(form: ClosedForm, draw: Any, normal_forms: Any) -> None:
    """At n = 2e7, t = 1e7 a rounded X would be off by 1e-10."""
    wave = Wave(form, normal_forms[form.equation.s], **draw(form))
    n, t, eps = 20_000_003.0, 10_000_001.0, 0.05
    speed = int(wave.normal_form.c)
    X = Fraction(1, 20) * (int(n) - speed * int(t))
    T = Fraction(1, 8000) * int(t)
    assert error(wave.at(n, t, eps), wave.mp(X, T, 60)) < TOLERANCE


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.name)
def test_no_warning_no_nan_anywhere(form: ClosedForm, draw: Any, normal_forms: Any) -> None:
    wave = Wave(form, normal_forms[form.equation.s], **draw(form))
    X = np.concatenate([-np.geomspace(1e6, 1e-300, 300), [0.0], np.geomspace(1e-300, 1e6, 300)])
    with warnings.catch_warnings(), np.errstate(all="raise"):
        warnings.simplefilter("error")
        for T in (-1e4, 0.0, 1e4):
            assert all(np.all(np.isfinite(part)) for part in wave(X, T))


def test_shapes_broadcast_and_blocks_join(normal_forms: Any) -> None:
    wave = Wave(closed_form("soliton_dn"), normal_forms[1], k=0.7)
    X, T = np.linspace(-30, 30, 9001), np.array([[0.0], [0.1]])
    values = wave(X, T)
    assert values.Y.shape == values.Y_X.shape == values.Y_T.shape == (2, 9001)
    assert values.Y[1, 5000] == wave(X[5000], 0.1).Y
    assert np.shape(wave(0.0, 0.0).Y) == ()


def test_background_far_field_and_wavelength(normal_forms: Any) -> None:
    wave = Wave(closed_form("breather_sn"), normal_forms[-1], k=0.5, alpha=0.8)
    assert wave.wavelength == pytest.approx(4 * float(mpmath.ellipk(0.25)) / np.sqrt(6))
    assert wave.constant_background is None
    T, length = 0.2, wave.wavelength
    background = wave.background(np.array([0.3, 0.3 + length]), T)
    assert background.Y[0] == pytest.approx(background.Y[1], abs=1e-14)
    assert background.Y_T[0] == pytest.approx(background.Y_T[1], abs=1e-14)
    for side, X in (("left", -200.0), ("right", 200.0)):
        far, value = wave.far_field(X, T, side), wave(X, T)
        assert far == pytest.approx(value, abs=1e-13)
    assert abs(wave.far_field(0.3, T, "left").Y - wave.far_field(0.3, T, "right").Y) > 0.1


def test_site_and_slow_variables_agree(normal_forms: Any) -> None:
    wave = Wave(closed_form("rogue_cn"), normal_forms[1], k=0.5)
    n, t, eps = np.arange(-40, 40), 31.0, 0.05
    X, T = eps * (n - 2 * t), eps**3 * t
    for at, slow in (
        (wave.at(n, t, eps), wave(X, T)),
        (wave.background_at(n, t, eps), wave.background(X, T)),
        (wave.far_field_at(n, t, eps, "left"), wave.far_field(X, T, "left")),
    ):
        assert np.allclose(at, slow, rtol=0, atol=1e-12)


@pytest.mark.parametrize(("name", "level"), [("rational_2", 1.0), ("rational_3", -1.0)])
def test_constant_background(name: str, level: float, normal_forms: Any) -> None:
    wave = Wave(closed_form(name), normal_forms[1])
    assert wave.constant_background == level
    assert wave.wavelength is None
    assert wave.background(np.arange(3.0), 0.0).Y.tolist() == [level] * 3


def test_kink_has_no_common_background(normal_forms: Any) -> None:
    wave = Wave(closed_form("kink"), normal_forms[-1], A=0.5)
    assert wave.constant_background is None
    assert wave.far_field(0.0, 0.0, "left").Y == -0.5


def test_wrong_sign_is_refused(normal_forms: Any) -> None:
    with pytest.raises(ValueError, match=r"K4 must satisfy K4 < 0 for kink, got K4 > 0"):
        Wave(closed_form("kink"), normal_forms[1], A=1)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_points_must_be_finite(bad: float, normal_forms: Any) -> None:
    wave = Wave(closed_form("kink"), normal_forms[-1], A=1)
    with pytest.raises(ValueError, match="position must be finite"):
        wave([0.0, bad], 0.0)
    with pytest.raises(ValueError, match="time must be finite"):
        wave.at(0, bad, 0.1)


@pytest.mark.parametrize("eps", [0.0, -0.1, float("nan")])
def test_eps_must_be_positive(eps: float, normal_forms: Any) -> None:
    wave = Wave(closed_form("kink"), normal_forms[-1], A=1)
    with pytest.raises(ValueError, match="eps must"):
        wave.at(0, 0.0, eps)


def test_side_must_be_named(normal_forms: Any) -> None:
    wave = Wave(closed_form("kink"), normal_forms[-1], A=1)
    with pytest.raises(ValueError, match="side must be 'left' or 'right', got 'up'"):
        wave.far_field(0.0, 0.0, "up")  # type: ignore[arg-type]


def test_a_wave_shows_itself_in_one_line_and_its_formula_in_notebooks(normal_forms: Any) -> None:
    wave = Wave(closed_form("wave_cn"), normal_forms[1], k=0.7)
    assert "wave_cn" in repr(wave)
    assert "7/10" in repr(wave)
    assert "\n" not in repr(wave)
    assert wave._repr_latex_() == wave.form._repr_latex_()
    assert r"\operatorname{cn}" in wave._repr_latex_()


def test_a_fork_evaluates_after_its_parent_has() -> None:
    """The threads of the parent are not in the fork: to wait for them was to wait for ever."""
    script = (
        "import os, signal, numpy as np;"
        "from longwave.solutions.points import evaluate_points as all_of;"
        "x = np.zeros(9000); all_of(lambda x: x[None], x);"
        "child = os.fork();"
        "child or (signal.alarm(20), all_of(lambda x: x[None], x), os._exit(0));"
        "raise SystemExit(os.waitpid(child, 0)[1])"
    )
    done = subprocess.run([sys.executable, "-W", "ignore", "-c", script], check=False)
    assert done.returncode == 0
