"""Waves of KdV, Gardner, Kawahara, KP and NLS: values, jets, antiderivatives, what is refused."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp

from longwave.derive import NormalForm, mkdv_normal_form
from longwave.derive.normal_form import NORMAL_EQUATIONS
from longwave.solutions import CATALOGUE, ClosedForm, Wave, closed_form, data_store, kept_wave
from longwave.solutions.equation import KP, NLS, Equation
from longwave.solutions.symbols import s, tau, xi, zeta
from longwave.support.compiled.kernel_folder import CacheFolder
from tests.families import WAVES, family

OTHERS = [form for form in CATALOGUE if form not in CATALOGUE.of("mKdV")]
TOLERANCE = 1e-13
ODD = tuple(map(sp.Rational, ("6/5", "-3/10", "-7/2", "4/5", "1/8")))
"""a, b, h, e and drift of a normal form without anything simple in it."""

others = pytest.mark.parametrize("form", OTHERS, ids=lambda form: form.name)


def build_wave(form: ClosedForm, sign: int | None = None, **parameters: Any) -> Wave:
    """Return a wave in a normal form with no simple coefficient."""
    equation = form.equation
    a, b, h, e, drift = ODD
    if sign is None:
        sign = 1 if equation.free_sign else int(equation.s)
    across = e if equation.has_across else sp.S.Zero
    normal_form = NormalForm(a, b, sign, 2, equation.normal, h, across, equation.r, drift)
    return Wave(form, normal_form, **parameters)


def keyword(wave: Wave, name: str, value: Any) -> dict[str, Any]:
    """Return the transverse coordinate if the wave takes one."""
    return {name: value} if wave.numbers.is_planar else {}


def error(found: Any, exact: Any) -> float:
    """Return the worst error of real and imaginary parts, in units of max(1, |part|)."""
    pairs = [
        (part(value), part(reference))
        for value, reference in zip(found, exact, strict=True)
        for part in (lambda z: z.real, lambda z: z.imag)
    ]
    return max(float(abs(v - r) / max(1, abs(r))) for v, r in pairs)


@others
def test_values_and_derivatives(form: ClosedForm, draw: Any, rng: np.random.Generator) -> None:
    for scale in (1.0, 40.0, 1e6):
        wave = build_wave(form, **draw(form))
        X, T, Z = (float(value) for value in rng.normal(scale=scale, size=3))
        across = keyword(wave, "Z", Z)
        found = wave(X, T, **across)
        assert error(found, wave.mp(X, T, 40, **across)) < TOLERANCE
        assert len(found) == 3 + wave.numbers.is_planar


@pytest.mark.parametrize("form", [*CATALOGUE], ids=lambda form: form.name)
def test_the_value_alone_has_the_bits_of_that_with_derivatives(
    form: ClosedForm, draw: Any, rng: np.random.Generator
) -> None:
    """Catches: code that a value needs, or a row of a complex or planar wave, left out."""
    wave = build_wave(form, **draw(form))
    n, t = np.append(rng.normal(scale=30.0, size=60), [-4e4, 4e4]), 3.25
    across = keyword(wave, "m", 2.0)
    whole = {
        "wave": wave.at(n, t, 0.3, **across),
        "background": wave.background_at(n, t, 0.3, **across),
        "left": wave.far_field_at(n, t, 0.3, "left", **across),
        "right": wave.far_field_at(n, t, 0.3, "right", **across),
    }
    for part, values in whole.items():
        assert np.array_equal(wave.value_at(n, t, 0.3, part, **across), values.Y), part


@others
def test_sites_and_times_lose_no_digit(form: ClosedForm, draw: Any) -> None:
    """At n = 2e7, t = 1e7 a rounded X would be off by 1e-10."""
    wave = build_wave(form, **draw(form))
    n, t, eps = 20_000_003.0, 10_000_001.0, 0.05
    across = keyword(wave, "m", 7_000_001.0)
    exact = wave.mp_at(n, t, eps, 40, **across)
    assert error(wave.at(n, t, eps, **across), exact) < TOLERANCE
    order = form.equation.order
    X, T = sp.Rational(1, 20) * int(n - 2 * t), sp.Rational(1, 20) ** order * int(t)
    slow = wave.mp(X, T, 40, **keyword(wave, "Z", sp.Rational(1, 400) * 7_000_001))
    assert error(exact, slow) < 1e-30


@others
def test_at_rest_where_parameters_may_be_left_out(form: ClosedForm, draw: Any) -> None:
    """A bright soliton of speed 0 divided by its wavenumber."""
    values = draw(form)
    for parameter in form.parameters:
        if parameter.default is not None:
            del values[parameter.name]
    wave = build_wave(form, **values)
    across = keyword(wave, "Z", 0.3)
    assert error(wave(0.7, -0.2, **across), wave.mp(0.7, -0.2, 40, **across)) < TOLERANCE


@others
def test_no_warning_no_nan_anywhere(form: ClosedForm, draw: Any) -> None:
    wave = build_wave(form, **draw(form))
    X = np.concatenate([-np.geomspace(1e6, 1e-300, 300), [0.0], np.geomspace(1e-300, 1e6, 300)])
    with np.errstate(all="raise"):
        for T in (-1e4, 0.0, 1e4):
            values = wave(X, T, **keyword(wave, "Z", 0.5))
            assert all(np.all(np.isfinite(part)) for part in values)


@others
def test_far_fields_and_backgrounds(form: ClosedForm, draw: Any) -> None:
    wave = build_wave(form, **draw(form))
    across = keyword(wave, "Z", 0.5)
    assert np.all(np.isfinite(wave.background(0.3, 0.1, **across).Y))
    for side, X in (("left", -1e8), ("right", 1e8)):
        far = wave.far_field(X, 0.1, side, **across)
        assert error(wave(X, 0.1, **across), far) < TOLERANCE
    if wave.wavelength:
        one, other = wave(np.array([0.4, 0.4 + wave.wavelength]), 0.2).Y
        assert one == pytest.approx(other, abs=1e-13)


@others
def test_jets_are_those_of_mpmath(form: ClosedForm, draw: Any) -> None:
    wave = build_wave(form, **draw(form))
    X, T = np.array([[-2.0, 0.0, 0.4], [1.1, 5.0, -30.0]]), 0.21
    across = keyword(wave, "Z", 0.3)
    found = wave.jets(X, T, 6, **across)
    assert found.shape == (7, 2, 3)
    largest = np.max(np.abs(found), axis=(1, 2))
    for value, exact, size in zip(
        found[:, 0, 2], wave.mp_jets(0.4, T, 6, 30, **across), largest, strict=True
    ):
        assert abs(complex(value) - complex(exact)) < 1e-13 * size
    for row, part in zip(found, wave(X, T, **across)[:2], strict=False):
        assert np.allclose(row, part, rtol=1e-13, atol=1e-15)


@pytest.mark.parametrize("name", family(CATALOGUE.of("mKdV").names, quick=WAVES))
def test_jets_of_mkdv_waves_too(name: str, draw: Any, normal_forms: Any) -> None:
    form = closed_form(name)
    wave = Wave(form, normal_forms[form.equation.s], **draw(form))
    found = wave.jets(0.3, 0.1, 4)
    exact = [float(value) for value in wave.mp_jets(0.3, 0.1, 4, 30)]
    assert found == pytest.approx(exact, rel=1e-12, abs=1e-12)


def test_jets_far_away_and_at_zeros_are_not_left_to_mpmath(monkeypatch: Any) -> None:
    wave = build_wave(closed_form("kdv_soliton"), kappa=1)
    monkeypatch.setattr(wave, "_settle", lambda *_, **__: 1 / 0)
    assert np.all(wave.jets(1e5, 0.0, 8) == 0)
    assert abs(wave.jets(0.0, 0.0, 3)[3]) < 1e-25


def test_jets_where_double_double_is_not_enough() -> None:
    """A denominator of 1e-30 beside a phase of 1e15: mpmath settles what is uncertain."""
    wave = build_wave(closed_form("kdv_cnoidal"), k=1 - sp.Rational(1, 10**40))
    X = np.array([1e15, 2e15, 0.1])
    found = wave.jets(X, 0.0, 3)
    for column, x in enumerate(X.tolist()):
        exact = [float(value) for value in wave.mp_jets(x, 0, 3, 20)]
        assert found[:, column] == pytest.approx(exact, rel=1e-12, abs=1e-12)


def test_antiderivatives() -> None:
    wave = build_wave(closed_form("kdv_soliton"), kappa=sp.Rational(1, 2))
    a, _, h, *_ = map(float, ODD)
    X = np.array([[3.0, -40.0], [0.0, 4000.0]])
    exact = h / a * np.tanh(a * X / 2)
    assert wave.antiderivative(X, 0.0) == pytest.approx(exact, rel=1e-12, abs=1e-13)
    kink = build_wave(closed_form("gardner_kink"))
    places = np.array([-20.0, 3.0, 200.0])
    exact = h * (places / 2 - np.log(np.cosh(a * places / 2)) / a)
    assert kink.antiderivative(places, 0.0) == pytest.approx(exact, rel=1e-12)
    plane = build_wave(closed_form("nls_plane"), q=1)
    turned = h * (np.exp(1j * a * X) - 1) / (1j * a)
    assert plane.antiderivative(X, 0.0) == pytest.approx(turned, abs=1e-9)
    assert build_wave(closed_form("nls_plane")).antiderivative(2.0, 0.0) == pytest.approx(2 * h)
    with pytest.raises(ValueError, match="points must span at most"):
        wave.antiderivative(1e9, 0.0)


HEIGHTS = {
    "kdv_soliton": ({"kappa": 2}, 8.0),
    "gardner_negative_soliton": ({"kappa": 1e-9}, -2.0),
    "kp_line_soliton": ({"kappa": 2}, 8.0),
    "kp_lump": ({"kappa": 2}, 16.0),
    "nls_peregrine": ({"A": 2}, -6.0),
    "nls_rogue_2": ({}, 5.0),
    "nls_akhmediev": ({"a": sp.Rational(1, 8)}, -2.0),
    "nls_kuznetsov_ma": ({"a": 2}, -5.0),
    "nls_dark": ({}, 0.0),
}


@pytest.mark.parametrize("name", HEIGHTS)
def test_heights_at_the_origin(name: str) -> None:
    parameters, height = HEIGHTS[name]
    wave = build_wave(closed_form(name), **parameters)
    found = wave(0.0, 0.0, **keyword(wave, "Z", 0.0)).Y
    assert found == pytest.approx(float(ODD[2]) * height, abs=1e-12)


@pytest.mark.parametrize("sign", [1, -1])
def test_either_sign_where_the_form_says_so(sign: int) -> None:
    wave = build_wave(closed_form("kp_line_soliton"), sign, kappa=1, q=2)
    _, Y_X, Y_T, Y_Z = wave(0.2, 0.1, Z=0.4)
    speed = 4 + 3 * sign * 4
    a, b, _, e, drift = map(float, ODD)
    assert pytest.approx(2 * e / a) == Y_Z / Y_X
    assert pytest.approx(-drift - speed * b / a) == Y_T / Y_X
    assert (
        pytest.approx(float(ODD[2]) * np.exp(2j * sign * b * 0.5))
        == build_wave(closed_form("nls_plane"), sign)(0.0, 0.5).Y
    )


@pytest.mark.parametrize("name", ["nls_peregrine", "kp_lump", "kdv_cnoidal"])
def test_a_cached_wave_equals_a_new_one(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(data_store, "cache_folder", lambda *_: CacheFolder(tmp_path))
    values = {"kp_lump": {"kappa": 1}, "kdv_cnoidal": {"k": 0.5}}.get(name, {})
    exact = build_wave(closed_form(name), **values)

    def everything(wave: Any) -> list[Any]:
        X = np.linspace(-4, 4, 9)
        Z, m = keyword(wave, "Z", X), keyword(wave, "m", X)
        return [*wave(X, 0.1, **Z), *wave.at(X, 3.0, 0.1, **m), wave.jets(X, 0.1, 5, **Z)]

    for _ in range(2):
        cached = kept_wave(__name__, name, lambda: exact)
        for one, other in zip(everything(cached), everything(exact), strict=True):
            assert np.array_equal(one, other)


def test_invalid_arguments_are_refused() -> None:
    lump, soliton = closed_form("kp_lump"), build_wave(closed_form("kdv_soliton"), kappa=1)
    with pytest.raises(
        ValueError, match=r"must be of the KdV equation for kdv_soliton, got .*mKdV"
    ):
        Wave(closed_form("kdv_soliton"), mkdv_normal_form(1, 1), kappa=1)
    with pytest.raises(ValueError, match=r"s must be -1 for kp_lump, got 1 \(.*KP-I equation\)"):
        build_wave(lump, 1, kappa=1)
    with pytest.raises(ValueError, match="coordinate Z or m must be given for kp_lump, got none"):
        build_wave(lump, kappa=1)(0.0, 0.0)
    with pytest.raises(ValueError, match="must be left out for kdv_soliton, got one"):
        soliton(0.0, 0.0, Z=1.0)
    with pytest.raises(ValueError, match="must be left out for kdv_soliton"):
        soliton.mp(0, 0, Z=1)
    for highest in (-1, 21, 1.5, True, "2"):
        with pytest.raises(ValueError, match=r"highest must be a whole number from 0 to 20, got"):
            soliton.jets(0.0, 0.0, highest)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="position, time and transverse coordinate must broadcast"):
        build_wave(lump, kappa=1)(np.zeros(2), 0.0, Z=np.zeros(3))
    with pytest.raises(ValueError, match=r"a must satisfy 0 < a < 1/2, got 0\.5"):
        build_wave(closed_form("nls_akhmediev"), a=0.5)
    with pytest.raises(ValueError, match="normal must be an equation, got 'Burgers'"):
        Equation("Burgers", 1, "Burgers")


def written_out(text: str) -> sp.Expr:
    """Return a normal form's text as an expression in U(xi, zeta, tau)."""
    U = sp.Function("U")(xi, zeta, tau)
    inner = re.fullmatch(r"\((.*)\)_xi \+ (.*)", text)
    if inner:
        return sp.diff(written_out(inner[1]), xi) + written_out(inner[2])
    names = {"xi": xi, "zeta": zeta, "tau": tau}
    total = sp.S.Zero
    for sign, term in re.findall(r"(^|[+-] )([^+-]+)", text):
        product = sp.Integer(-1 if sign.startswith("-") else 1)
        for factor in term.split():
            if factor.startswith("U_"):
                times, letters = re.fullmatch(r"U_(\d*)(\D+)", factor).groups()  # type: ignore[union-attr]
                steps = re.findall("xi|zeta|tau", letters) * int(times or 1)
                product *= sp.diff(U, *(names[step] for step in steps))
            else:
                own = {"U": U, "U^2": U**2, "|U|^2": sp.Abs(U) ** 2, "i": sp.I, "s": s}
                product *= (
                    own.get(factor) or sp.Symbol(factor)
                    if factor.isalpha()
                    else own.get(factor, sp.Integer(factor) if factor.isdigit() else None)
                )
        total += product
    return total


@pytest.mark.parametrize("name", sorted({form.equation.normal for form in CATALOGUE}))
def test_an_equation_is_the_one_that_reductions_are_taken_to(name: str) -> None:
    stated = written_out(NORMAL_EQUATIONS[name].text.removesuffix(" = 0"))
    for sign in (1, -1):
        U = sp.Function("U")(xi, zeta, tau)
        ours = Equation("any", sign, name, sign).residual(U)
        assert sp.expand(ours - stated.subs({s: sign, sp.Symbol("r"): sign})) == 0


def test_an_equation_shows_itself() -> None:
    assert KP._repr_latex_().count("s U") == NLS._repr_latex_().count("s |U") == 1
    latex = Equation("any", -1, "modified Kawahara", 1)._repr_latex_()
    assert r"U_\tau + 6 U^2 U_\xi - U_{\xi\xi\xi} - U_{5\xi} = 0" in latex


@pytest.mark.parametrize("name", CATALOGUE.of("KP").names)
def test_a_potential_has_the_wave_as_its_slope(name: str) -> None:
    """And its derivatives by T and Z are those of its numbers, in the lattice's scales."""
    form = closed_form(name)
    wave, X, h = build_wave(form, kappa=1, q=sp.Rational(1, 3)), np.linspace(-2.0, 2.0, 5), 1e-5
    _, W_X, W_T, W_Z = wave.potential(X, 0.3, Z=0.2)
    assert pytest.approx(wave(X, 0.3, Z=0.2).Y, abs=1e-13) == W_X
    later, earlier = (wave.potential(X, 0.3 + d, Z=0.2).Y for d in (h, -h))
    assert (later - earlier) / (2 * h) == pytest.approx(W_T, abs=1e-8)
    beyond, before = (wave.potential(X, 0.3, Z=0.2 + d).Y for d in (h, -h))
    assert (beyond - before) / (2 * h) == pytest.approx(W_Z, abs=1e-8)
    with pytest.raises(ValueError, match="form must be one with a potential"):
        build_wave(replace(form, potential=None), kappa=1).potential(0.0, 0.0, Z=0.0)
