"""Ball arithmetic: functions compared with mpmath, jets with SymPy's derivatives."""

import pytest
import sympy as sp

from longwave.solutions.functions import (
    jacobi_cn,
    jacobi_dn,
    jacobi_epsilon,
    jacobi_eta,
    jacobi_sn,
    jacobi_theta,
    jacobi_zeta,
)
from longwave.verify.proof.balls import ball_value, residual_ball
from longwave.verify.proof.domains import settled_domains
from longwave.verify.proof.samples import sample

x, t, m = sp.symbols("x t m", real=True)

JACOBI = [
    jacobi_sn(x, m),
    jacobi_cn(x, m),
    jacobi_dn(x, m),
    jacobi_epsilon(x, m),
    jacobi_zeta(x, m),
    jacobi_theta(x, m),
    jacobi_eta(x, m),
]
FORMULAS = [
    *JACOBI,
    sp.exp(x * t) / (1 + x**2),
    sp.atan(x * t) * sp.log(2 + x),
    sp.sqrt(1 + x**2 + t) * sp.tanh(x - t),
    (3 + x) ** sp.Rational(-2, 3) * sp.cos(x + 2 * t),
    sp.re(sp.exp(sp.I * x) / (1 + sp.I * t)),
]


@pytest.mark.parametrize("formula", JACOBI, ids=lambda f: f.func.__name__)
@pytest.mark.parametrize("place", ["13/10", "-71/10", "1000"])
@pytest.mark.parametrize("parameter", ["3/10", "999/1000", "-2"])
def test_a_ball_contains_the_value(formula: sp.Expr, place: str, parameter: str) -> None:
    point = {x: sp.Rational(place), m: sp.Rational(parameter)}
    ball = ball_value(formula, point, 300)
    expected = sp.N(formula.xreplace(point), 40)
    got = sp.Float(ball.real.mid().str(45, radius=False), 45)
    assert abs(got - sp.re(expected)) < 1e-36 * max(1, abs(expected))


@pytest.mark.parametrize("formula", FORMULAS, ids=str)
def test_a_jet_is_made_of_the_derivatives(formula: sp.Expr) -> None:
    """Checks that u_xxt + u_x - (its value for the formula) has a narrow ball around 0."""
    u = sp.Function("u")(x, t)
    equation = u.diff(x, 2, t) + u.diff(x)
    (point,) = sample(settled_domains({x, t, m}, {m: sp.Interval.open(0, 1)}), 1)
    ball = residual_ball(equation, u, formula, point, 300)
    exact = sp.diff(formula, x, 2, t) + sp.diff(formula, x)
    expected = sp.N(exact.doit().xreplace(point), 40)
    assert abs(sp.Float(ball.real.mid().str(45, radius=False), 45) - sp.re(expected)) < 1e-33


def test_an_unknown_function_is_an_error() -> None:
    with pytest.raises(ValueError, match="must have ball arithmetic, got gamma"):
        ball_value(sp.gamma(x), {x: sp.Rational(1, 2)}, 100)


def test_the_incomplete_elliptic_integral_is_not_the_complete_one() -> None:
    """Catches: E(z | m) evaluated as E(z), which refuted E(z + pi | m) = E(z | m) + 2 E(m)."""
    with pytest.raises(ValueError, match="must have ball arithmetic, got elliptic_e"):
        ball_value(sp.elliptic_e(x, m), {x: sp.Rational(1, 2), m: sp.Rational(1, 3)}, 100)
