"""Weierstrass' functions, theta functions of a nome and arbitrary functions in SymPy."""

import pytest
import sympy as sp
from sympy.core.function import ArgumentIndexError

from longwave.solutions.functions.jet_functions import THETA, jet_function
from longwave.solutions.functions.weierstrass import weierstrass_p, weierstrass_p_prime

x, t, g, h = sp.symbols("x t g h", real=True)
q = sp.Symbol("q", positive=True)


def test_weierstrass_function_satisfies_its_differential_equation() -> None:
    p = weierstrass_p(x, g, h)
    assert p.diff(x) == weierstrass_p_prime(x, g, h)
    assert p.diff(x, 3) == 12 * p * p.diff(x)
    assert weierstrass_p_prime(-x, g, h) == -p.diff(x)
    assert sp.conjugate(p) == p
    assert p.is_extended_real is True
    assert weierstrass_p(sp.I * x, g, h).is_extended_real is None
    assert sp.latex(weierstrass_p_prime(x, g, h) ** 2) == r"\wp'^{2}\left(x; g, h\right)"
    with pytest.raises(ArgumentIndexError):
        p.fdiff(2)


@pytest.mark.parametrize("name", list(THETA))
def test_a_theta_function_satisfies_the_heat_equation_and_has_its_parity(name: str) -> None:
    theta = jet_function(name)(x, sp.exp(-4 * t))
    assert sp.expand(theta.diff(t) - theta.diff(x, 2)) == 0
    assert jet_function(name)(-x, q) == THETA[name] * jet_function(name)(x, q)
    assert jet_function(name, 1)(-x, q) == -THETA[name] * jet_function(name, 1)(x, q)
    assert jet_function(name)(x, q).is_real is True
    assert jet_function(name)(x, -q).is_real is None


def test_the_derivatives_of_an_arbitrary_function_are_functions_of_their_own() -> None:
    f = jet_function("f")
    assert jet_function("f") is f
    assert f(x - 2 * t).diff(x, t) == -2 * jet_function("f", 2)(x - 2 * t)
    assert str(f(x).diff(x)) == "f'(x)"
    assert f(-x) != f(x)
    assert sp.conjugate(f(x)) == f(x)
    assert sp.conjugate(f(x + sp.I * t)) == f(x - sp.I * t)
    assert sp.latex(f(x).diff(x) ** 2) == r"\left[f'\left(x\right)\right]^{2}"
    assert sp.latex(jet_function("jacobi_theta_3")(x, q)) == r"\theta_{3}\left(x, q\right)"
