"""Every closed form solves its equation, equals its stable form and tends to its far fields."""

import subprocess
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from longwave.solutions import CATALOGUE, ClosedForm, closed_form, rational
from longwave.solutions.forms.breather_sn import inverse_width, speed
from longwave.solutions.symbols import alpha, k, tau, xi
from tests.families import family

FORMS = (*CATALOGUE.of("mKdV"), rational(4, free=[5, 7]))
TINY = 1e-40


def residual(ctx: Any, s: int, U: Any, x: float, t: float) -> float:
    """Return the equation's residual by mpmath's differences, which use no derivative rule."""
    U_x = ctx.diff(lambda z: U(z, t), x)
    U_xxx = ctx.diff(lambda z: U(z, t), x, 3)
    return float(abs(ctx.diff(lambda z: U(x, z), t) + 6 * s * U(x, t) ** 2 * U_x + U_xxx))


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.name)
def test_canonical_form_solves_its_equation(
    form: ClosedForm, draw: Any, ctx: Any, in_mp: Any, rng: np.random.Generator
) -> None:
    U = in_mp(form, form.expression, draw(form))
    x, t = ctx.mpf(float(rng.normal())), ctx.mpf(float(rng.normal()))
    assert residual(ctx, form.equation.s, U, x, t) < TINY


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.name)
def test_stable_form_is_the_canonical_one(
    form: ClosedForm, draw: Any, in_mp: Any, rng: np.random.Generator
) -> None:
    values = draw(form)
    canonical = in_mp(form, form.expression, values)
    stable = in_mp(form, form.stable, values)
    for x, t in rng.normal(scale=4, size=(4, 2)):
        assert abs(canonical(x, t) - stable(x, t)) < TINY


@pytest.mark.parametrize("name", ["soliton_dn", "rogue_cn", "breather_sn"])
@pytest.mark.parametrize("wrong", [1 / sp.Rational(99, 100), -1])
def test_a_changed_coefficient_is_detected(
    name: str, wrong: sp.Expr, draw: Any, ctx: Any, in_mp: Any
) -> None:
    form = closed_form(name)
    mutant = form.background + wrong * (form.expression - form.background)
    U = in_mp(form, mutant, draw(form))
    assert residual(ctx, form.equation.s, U, ctx.mpf("0.3"), ctx.mpf("0.2")) > 1e-6


def test_modulus_taken_for_parameter_is_detected(draw: Any, ctx: Any, in_mp: Any) -> None:
    form = closed_form("wave_dn")
    mutant = form.expression.subs(k**2, k)
    U = in_mp(form, mutant.subs(2 - k, 2 - k**2), draw(form))
    assert residual(ctx, 1, U, ctx.mpf("0.3"), ctx.mpf("0.2")) > 1e-6


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.name)
@pytest.mark.parametrize(("side", "sign"), [("left", -1), ("right", 1)])
def test_far_field_is_approached(
    form: ClosedForm, side: str, sign: int, draw: Any, in_mp: Any
) -> None:
    values = draw(form) | ({"k": 0.6} if form.period is not None else {})
    if "alpha" in values:
        values["alpha"] = 0.8
    wave = in_mp(form, form.expression, values)
    far = in_mp(form, getattr(form.far_fields, side), values)
    near, distant = (abs(wave(sign * x, 0.1) - far(sign * x, 0.1)) for x in (40, 40_000))
    assert distant < 1e-3
    assert distant < near / 30 or near < TINY


@pytest.mark.parametrize(
    ("name", "peak"), [("soliton_dn", "2 + sqrt(1-k^2)"), ("rogue_cn", "3k"), ("rational_2", "5")]
)
def test_value_at_the_origin(name: str, peak: str, in_mp: Any) -> None:
    form = closed_form(name)
    values = {"k": 0.6} if form.parameters else {}
    expected = {"2 + sqrt(1-k^2)": 2.8, "3k": 1.8, "5": 5.0}[peak]
    assert float(in_mp(form, form.expression, values)(0, 0)) == pytest.approx(expected, abs=1e-14)


def test_breather_at_half_the_quarter_period(ctx: Any) -> None:
    """At alpha = K/2: kappa = k/2 and c = 3 - k**2."""
    values = {k: sp.Rational(3, 10), alpha: sp.elliptic_k(sp.Rational(9, 100)) / 2}
    assert sp.N(inverse_width.xreplace(values) - sp.Rational(3, 20), 40) == pytest.approx(0)
    assert sp.N(speed.xreplace(values) - 3 + sp.Rational(9, 100), 40) == pytest.approx(0)


def test_catalogue_names_are_unique_and_free_symbols_declared() -> None:
    names = [form.name for form in CATALOGUE]
    assert len(set(names)) == len(names)
    for form in CATALOGUE:
        declared = {*form.equation.variables, *form.equation.free_sign}
        declared |= {parameter.symbol for parameter in form.parameters}
        for expression in (form.expression, form.background, form.far_fields.left):
            assert expression.free_symbols <= declared


def test_unknown_name_lists_the_catalogue() -> None:
    with pytest.raises(ValueError, match=r"got 'peakon' \(one of rational_1, .*kink"):
        closed_form("peakon")
    with pytest.raises(
        ValueError, match=r"got 'rogue' \(did you mean rogue_cn, .* one of 38 names"
    ):
        closed_form("rogue")


def test_a_form_is_built_only_on_request() -> None:
    code = (
        "import sys; from longwave.solutions import CATALOGUE, closed_form; closed_form('kink');"
        "forms = 'longwave.solutions.forms.';"
        "print(len(CATALOGUE.names), *(m for m in sys.modules if m.startswith(forms)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == [str(len(CATALOGUE)), "longwave.solutions.forms.solitons"]


@pytest.mark.parametrize("name", CATALOGUE.names)
def test_each_form_has_the_name_and_equation_it_is_found_under(name: str) -> None:
    form = closed_form(name)
    assert form.name == name
    assert form is closed_form(name)
    assert form in CATALOGUE.of(form.equation.normal)


def test_a_formula_given_as_a_function_is_made_at_first_use() -> None:
    calls = []

    def formula() -> sp.Expr:
        calls.append("made")
        return sp.tanh(xi + 2 * tau)

    form = replace(closed_form("kink"), expression=formula)
    assert calls == []
    assert form.expression == form.stable == sp.tanh(xi + 2 * tau)
    assert calls == ["made"]


@pytest.mark.parametrize("form", family(CATALOGUE, slow=("rogue_cn",)))
def test_a_form_shows_itself_in_one_line_and_in_notebooks(form: ClosedForm) -> None:
    assert form.name in repr(form)
    assert "\n" not in repr(form)
    latex = form._repr_latex_()
    assert (latex is None) == (len(sp.latex(form.expression)) > 5000)
    assert latex is None or (latex.startswith("$") and latex.endswith("$"))
