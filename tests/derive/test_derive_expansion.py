"""The expansion against the lattice itself, at 60 digits and by plane waves."""

from collections.abc import Callable
from typing import Any

import mpmath
import pytest
import sympy as sp

from longwave.derive import LATTICES, Scaling, reduce
from longwave.derive.algebra.jets import DifferentialPolynomial
from longwave.derive.expansion import expand
from longwave.derive.symbols import K2, K3, K4, T, X, c

Constants = dict[sp.Symbol, sp.Rational]

FPUT = LATTICES["fput_strain"]
CONSTANTS = {
    K2: sp.Rational(7, 3),
    K3: sp.Rational(5, 4),
    K4: sp.Rational(-3, 7),
    c: sp.Rational(9, 5),
}
PROFILE = sp.sin(X + T / 3) + sp.exp(X / 2 - T / 5) / 3


@pytest.fixture(scope="module")
def mp() -> Any:
    context = mpmath.mp.clone()
    context.dps = 60
    return context


def functions(mp: Any) -> list[Any]:
    """Names for lambdify, all of the private context; Rationals keep their digits."""
    names = ("sin", "exp", "cosh", "sqrt", "mpf")
    return [{name: getattr(mp, name) for name in names}, "mpmath"]


def values_of(mp: Any, constants: Constants) -> dict[str, Any]:
    return {str(symbol): mp.mpf(value.p) / value.q for symbol, value in constants.items()}


def lattice_residual(
    mp: Any, wave: Callable[..., Any], eps: Any, constants: Constants, n: int = 0, t: int = 0
) -> Any:
    """y'' - D[K2 y + K3 y^2 + K4 y^3] by differentiating in lattice time."""
    v = values_of(mp, constants)

    def strain(site: int, time: Any) -> Any:
        return eps * wave(eps * (site - v["c"] * time), eps**3 * time)

    def force(site: int) -> Any:
        y = strain(site, t)
        return v["K2"] * y + v["K3"] * y**2 + v["K4"] * y**3

    acceleration = mp.diff(lambda time: strain(n, time), t, 2)
    return acceleration - force(n + 1) + 2 * force(n) - force(n - 1)


def evaluate(
    mp: Any,
    polynomial: DifferentialPolynomial,
    profile: sp.Expr,
    at: tuple[int, int],
    constants: Constants,
) -> Any:
    """A differential polynomial on a SymPy profile at (X, T) = at."""
    total = mp.mpf(0)
    for monomial, value in polynomial.terms.items():
        term = value.as_expr().subs(constants)
        for d_X, d_T in monomial:
            term *= profile.diff(X, d_X, T, d_T).subs({X: at[0], T: at[1]})
        total += mp.mpf(sp.N(term, 60)._mpf_)
    return total


@pytest.mark.parametrize("limit", [5, 6, 7])
def test_manufactured_wave_leaves_the_next_order(mp: Any, limit: int) -> None:
    """No condition holds, every order is alive: the rest falls as eps^(limit+1)."""
    wave = sp.lambdify((X, T), PROFILE, modules=functions(mp))
    parts = expand(FPUT, Scaling(), limit).residual().parts
    known = {o: evaluate(mp, p, PROFILE, (0, 0), CONSTANTS) for o, p in parts.items()}
    rests = []
    for eps in (mp.mpf("1e-3"), mp.mpf("1e-4")):
        total = sum(value * eps**order for order, value in known.items())
        rests.append(abs(lattice_residual(mp, wave, eps, CONSTANTS) - total))
    exponent = mp.log(rests[0] / rests[1]) / mp.log(10)
    assert abs(exponent - (limit + 1)) < 0.01


def test_soliton_leaves_the_remainder(mp: Any) -> None:
    """An exact mKdV soliton in the lattice: residual/eps^7 tends to R7, error eps^2."""
    reduction = reduce(FPUT)
    constants = {K2: sp.Integer(4), K3: sp.Integer(0), K4: sp.Integer(1), c: sp.Integer(2)}
    form = reduction.normal_form(K2=4, K4=1)
    kappa = sp.Rational(6, 5)
    phase = kappa * (form.a * X + sp.Rational(1, 3)) - kappa**3 * form.b * T
    profile = kappa / sp.cosh(phase)
    expected = evaluate(mp, reduction.remainders[7], profile, (0, 0), constants)
    wave = sp.lambdify((X, T), profile, modules=functions(mp))
    errors = []
    for eps in (mp.mpf("1e-2"), mp.mpf("1e-3")):
        errors.append(lattice_residual(mp, wave, eps, constants) / eps**7 - expected)
    assert abs(expected) > 1e-3
    assert abs(mp.log(abs(errors[0] / errors[1])) / mp.log(10) - 2) < 0.01


def test_plane_wave_determinant_equals_the_linear_part() -> None:
    """4 K2 sin^2(k/2) - omega^2 with k = eps kappa, expanded by SymPy alone."""
    eps, kappa, Omega = sp.symbols("eps kappa Omega")
    limit = 9
    omega = c * eps * kappa + eps**3 * Omega
    exact = sp.series(4 * K2 * sp.sin(eps * kappa / 2) ** 2 - omega**2, eps, 0, limit).removeO()
    total = sp.Integer(0)
    for order, part in expand(FPUT, Scaling(), limit).residual().parts.items():
        for monomial, value in part.terms.items():
            if len(monomial) == 1 and order <= limit:
                [(d_X, d_T)] = monomial
                factor = (sp.I * kappa) ** d_X * (-sp.I * Omega) ** d_T
                total += value.as_expr() * factor * eps ** (order - 1)
    assert sp.expand(total - exact) == 0
