"""Rules of the generators, tested by identities and equations that use each of them."""

import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from longwave.solutions.functions import (
    jacobi_cn,
    jacobi_dn,
    jacobi_epsilon,
    jacobi_eta,
    jacobi_sn,
    jacobi_theta,
    jacobi_zeta,
)
from longwave.verify.proof import prove, prove_equal
from longwave.verify.verdict import Outcome

x, t = sp.symbols("x t", real=True)
a, b, k, q = sp.symbols("a b k q", positive=True)
m = k**2
u = sp.Function("u")(x, t)

MKDV = u.diff(t) + 6 * u**2 * u.diff(x) + u.diff(x, 3)
KDV = u.diff(t) + 6 * u * u.diff(x) + u.diff(x, 3)
BURGERS = u.diff(t) + u * u.diff(x) - u.diff(x, 2)
MODULUS = {k: sp.Interval.open(0, 1)}
GAMMA = jacobi_theta(a, m) / jacobi_theta(0, m)

IDENTITIES = {
    "tanh": (sp.tanh(x) ** 2 + sp.sech(x) ** 2, sp.S.One),
    "cos": (sp.cos(2 * x), 1 - 2 * sp.sin(x) ** 2),
    "tan": (sp.tan(x + t), (sp.tan(x) + sp.tan(t)) / (1 - sp.tan(x) * sp.tan(t))),
    "exp of log": (sp.exp(x / 2 + sp.log(1 + x**2)), (1 + x**2) * sp.exp(x / 2)),
    "sn doubled": (
        jacobi_sn(2 * x, m),
        2 * jacobi_sn(x, m) * jacobi_cn(x, m) * jacobi_dn(x, m) / (1 - m * jacobi_sn(x, m) ** 4),
    ),
    "quarter period": (
        jacobi_sn(x + sp.elliptic_k(m), m),
        jacobi_cn(x, m) / jacobi_dn(x, m),
    ),
    "zeta": (
        jacobi_zeta(x + a, m),
        jacobi_zeta(x, m)
        + jacobi_zeta(a, m)
        - m * jacobi_sn(x, m) * jacobi_sn(a, m) * jacobi_sn(x + a, m),
    ),
    "epsilon and zeta": (
        jacobi_epsilon(x, m) - x * sp.elliptic_e(m) / sp.elliptic_k(m),
        jacobi_zeta(x, m),
    ),
    "eta": (jacobi_eta(x, m), sp.sqrt(k) * jacobi_sn(x, m) * jacobi_theta(x, m)),
    "theta product": (
        jacobi_theta(x + a, m) * jacobi_theta(x - a, m),
        GAMMA**2 * jacobi_theta(x, m) ** 2 * (1 - m * jacobi_sn(x, m) ** 2 * jacobi_sn(a, m) ** 2),
    ),
    "roots": (sp.sqrt(6 * a) * sp.sqrt(b), sp.sqrt(2) * sp.sqrt(3) * sp.sqrt(a * b)),
    "root of a quotient": (sp.sqrt(a / (1 + b)), sp.sqrt(a) / sp.sqrt(1 + b)),
    "complementary modulus": (sp.sqrt(1 - k**2) ** 3, sp.sqrt(1 - k**2) * (1 - k) * (1 + k)),
    "conjugate": (sp.re(sp.exp(sp.I * x)), sp.cos(x)),
    "modulus squared": (sp.Abs(x + sp.I * t) ** 2, x**2 + t**2),
}


@pytest.mark.parametrize("name", IDENTITIES)
def test_an_identity_is_proved_and_its_change_refuted(name: str) -> None:
    left, right = IDENTITIES[name]
    assert prove_equal(left, right, [x, t], domains=MODULUS).outcome is Outcome.PROVED
    changed = prove_equal(left, right * sp.Rational(101, 100), [x, t], domains=MODULUS)
    assert changed.outcome is Outcome.REFUTED


SOLUTIONS = {
    "KdV cnoidal wave": (KDV, 2 * m * jacobi_cn(x - (8 * m - 4) * t, m) ** 2),
    "KdV soliton": (KDV, 2 * a**2 * sp.sech(a * (x - 4 * a**2 * t)) ** 2),
    "Burgers": (BURGERS, 2 * a * (1 - sp.tanh(a * (x - 2 * a * t)))),
    "Burgers, logarithm": (
        BURGERS,
        -2 * sp.diff(sp.log(1 + sp.exp(a * x + a**2 * t) + sp.exp(-b * x + b**2 * t)), x),
    ),
    "mKdV breather": (
        MKDV,
        2
        * sp.diff(
            sp.atan(
                (b / a)
                * sp.sin(a * (x + (a**2 - 3 * b**2) * t))
                / sp.cosh(b * (x + (3 * a**2 - b**2) * t))
            ),
            x,
        ),
    ),
}


@pytest.mark.parametrize("name", SOLUTIONS)
def test_a_solution_of_its_equation_is_proved(name: str) -> None:
    equation, solution = SOLUTIONS[name]
    assert prove(equation, solution).outcome is Outcome.PROVED


@pytest.mark.parametrize("name", SOLUTIONS)
def test_the_same_formula_in_another_equation_is_refuted(name: str) -> None:
    equation, solution = SOLUTIONS[name]
    assert prove(equation + u, solution).outcome is Outcome.REFUTED


def test_two_moduli_live_in_one_formula() -> None:
    product = jacobi_sn(x, m) * jacobi_dn(x + t, q**2)
    slope = sp.Derivative(u, x) - sp.diff(product, x)
    assert prove(slope, product).outcome is Outcome.PROVED


def test_the_wrong_derivative_of_dn_is_refuted() -> None:
    """Catches: -k sn cn for -k**2 sn cn, an error of Sage and FriCAS."""
    wrong = u.diff(x) + k * jacobi_sn(x, m) * jacobi_cn(x, m)
    assert prove(wrong, jacobi_dn(x, m)).outcome is Outcome.REFUTED


ATOMS = [x, t, k, jacobi_sn(x, m), jacobi_dn(x - k * t, m), sp.exp(x), sp.tanh(x + t), sp.sqrt(3)]


@given(
    terms=st.lists(
        st.tuples(st.integers(-5, 5), st.sampled_from(ATOMS), st.sampled_from(ATOMS)),
        min_size=1,
        max_size=4,
    ),
    power=st.integers(1, 2),
)
@settings(max_examples=25, deadline=None)
def test_derivatives_agree_with_sympy(
    terms: list[tuple[int, sp.Expr, sp.Expr]], power: int
) -> None:
    f = sp.Add(*(n * left * right for n, left, right in terms)) ** power
    equation = sp.Derivative(u, x, t) - sp.diff(f, x, t) + u - f
    assert prove(equation, f).outcome is Outcome.PROVED
