"""The SymPy functions: derivatives, values, parity, evalf, printing."""

import pytest
from mpmath import MPContext
from sympy import (
    Derivative,
    E,
    Function,
    I,
    Rational,
    S,
    conjugate,
    cos,
    elliptic_e,
    elliptic_k,
    lambdify,
    latex,
    pi,
    sech,
    sin,
    sqrt,
    symbols,
    tanh,
)

from longwave.solutions.functions import (
    jacobi_cn,
    jacobi_dn,
    jacobi_epsilon,
    jacobi_eta,
    jacobi_sn,
    jacobi_theta,
    jacobi_zeta,
)
from longwave.solutions.functions.jacobi import ParameterDerivativeError
from longwave.solutions.functions.multiprecision import MpmathFormula

FUNCTIONS = (
    jacobi_sn,
    jacobi_cn,
    jacobi_dn,
    jacobi_epsilon,
    jacobi_zeta,
    jacobi_eta,
    jacobi_theta,
)
POINTS = (
    (Rational(7, 5), Rational(2, 7)),
    (Rational(-123, 10), Rational(9999, 10000)),
    (Rational(3, 4) + I / 5, Rational(1, 2)),
)
z, m = symbols("z m")
k = symbols("k", positive=True)


@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize("point", POINTS)
def test_derivative_is_the_limit_of_differences(
    function: type[Function], point: tuple[S, S]
) -> None:
    """A wrong derivative rule (k for m, a sign) fails at 20 digits."""
    at, parameter = point
    h = Rational(1, 10**15)
    difference = (function(at + h, parameter) - function(at - h, parameter)) / (2 * h)
    exact = function(z, m).diff(z).subs({z: at, m: parameter})
    assert abs((difference - exact).n(30)) < 1e-25


@pytest.mark.parametrize("function", FUNCTIONS)
def test_derivative_in_the_parameter_is_refused(function: type[Function]) -> None:
    with pytest.raises(ParameterDerivativeError, match=r"must be 1 .*got 2 .*keep m constant"):
        function(z, m).fdiff(2)
    assert function(z, m).diff(m).has(Derivative)


def test_values_at_the_origin() -> None:
    assert [f(0, m) for f in FUNCTIONS[:6]] == [0, 1, 1, 0, 0, 0]
    expected = sqrt(2 * sqrt(S(2) / 3) * elliptic_k(Rational(1, 3)) / pi)
    assert abs((jacobi_theta(0, Rational(1, 3)) - expected).n(30)) < 1e-29


def test_elementary_limits() -> None:
    assert [f(z, 0) for f in FUNCTIONS] == [sin(z), cos(z), 1, z, 0, 0, 1]
    assert [f(z, 1) for f in FUNCTIONS[:5]] == [tanh(z), sech(z), sech(z), tanh(z), tanh(z)]
    with pytest.raises(ValueError, match="m must satisfy m != 1"):
        jacobi_theta(2, 1).n()


@pytest.mark.parametrize("function", FUNCTIONS)
def test_parity(function: type[Function]) -> None:
    sign = -1 if function in (jacobi_sn, jacobi_epsilon, jacobi_zeta, jacobi_eta) else 1
    assert function(-z, m) == sign * function(z, m)
    assert function(2 - z, m) in (function(2 - z, m), sign * function(z - 2, m))


@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize("digits", [15, 50, 120])
def test_evalf_gives_the_digits_asked_for(function: type[Function], digits: int) -> None:
    """Large arguments and m near 1 must cost no digits."""
    for at, parameter in (
        (S(10) ** 7 / 3, Rational(1, 3)),
        (E, 1 - Rational(1, 10**12)),
        (pi / 7, Rational(1, 10**14)),
        (S(1) / 3 + I, 1 - Rational(1, 10**6)),
    ):
        value = function(at, parameter)
        error = abs((value.n(digits) - value.n(digits + 40)) / value.n(20))
        assert error < S(10) ** (1 - digits)


def test_algebraic_relations_hold_to_fifty_digits() -> None:
    at, parameter = Rational(13, 9), Rational(3, 5)
    sn, cn, dn, epsilon, zeta, eta, theta = (f(at, parameter) for f in FUNCTIONS)
    relations = (
        sn**2 + cn**2 - 1,
        dn**2 + parameter * sn**2 - 1,
        eta - sqrt(sqrt(parameter)) * sn * theta,
        epsilon - zeta - at * elliptic_e(parameter) / elliptic_k(parameter),
    )
    assert all(abs(r.n(50, maxn=200, chop=True)) < 1e-50 for r in relations)


def test_latex_says_which_parameter_it_prints() -> None:
    assert latex(jacobi_sn(z, k**2)) == r"\operatorname{sn}\left(z; k\right)"
    assert latex(jacobi_dn(z, m)) == r"\operatorname{dn}\left(z \mid m\right)"
    assert latex(jacobi_theta(z, k**2) ** 3) == r"\Theta^{3}\left(z; k\right)"


def test_numpy_printing_finds_the_functions_by_itself() -> None:
    for function in FUNCTIONS:
        compiled = lambdify((z, m), function(z, m), "numpy")
        exact = function(Rational(5, 4), Rational(3, 8)).n(20)
        assert abs(compiled(1.25, 0.375) - float(exact)) < 1e-15


def test_a_formula_keeps_the_digits_of_its_context() -> None:
    ctx = MPContext()
    ctx.dps = 60
    expression = Rational(1, 3) * sqrt(z) * jacobi_zeta(z, k**2) * elliptic_k(k**2) * tanh(z)
    (value,) = MpmathFormula.of([z, k], [expression])(ctx, ctx.mpf(2), ctx.mpf(3) / 5)
    exact = expression.subs({z: 2, k: Rational(3, 5)}).n(60)
    assert abs(value - ctx.convert(exact._to_mpmath(220))) < ctx.mpf(10) ** -57


def test_reality_and_conjugation() -> None:
    x = symbols("x", real=True)
    assert jacobi_sn(x, k**2).is_real
    assert jacobi_theta(x, Rational(1, 2)).is_real
    assert jacobi_theta(x, k).is_real is None
    assert conjugate(jacobi_cn(z, m)) == jacobi_cn(conjugate(z), conjugate(m))
