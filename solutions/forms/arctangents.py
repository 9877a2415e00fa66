"""Waves ``U = 2 d/dxi arctan(f)`` (K4 > 0): the breather, the double pole, two solitons."""

from collections.abc import Sequence

import sympy as sp

from longwave.solutions.equation import FOCUSING_MKDV
from longwave.solutions.record import Bound, ClosedForm, Reference, positive, real
from longwave.solutions.symbols import X_0, A, tau, xi

_A_1 = sp.Symbol("A_1", positive=True)
_A_2 = sp.Symbol("A_2", positive=True)

_phases = (_A_1 * (xi - _A_1**2 * tau), _A_2 * (xi - _A_2**2 * tau + X_0))
_repulsion = (_A_1 - _A_2) / (_A_1 + _A_2)

_f, _g, _r = sp.symbols("f g r", positive=True)


def _slope(tangent: sp.Expr) -> sp.Expr:
    """Return ``2 d/dxi arctan(tangent)``."""
    return 2 * sp.diff(sp.atan(tangent), xi)


def _bounded_slope(tangent: sp.Expr) -> sp.Expr:
    """Return `_slope` with every ``1/cosh`` as ``sech``, so that nothing grows exponentially."""
    bounded = tangent.replace(sp.cosh, lambda z: 1 / sp.sech(z))
    return 2 * sp.diff(bounded, xi) / (1 + bounded**2)


def breather() -> ClosedForm:
    """Return the breather on zero: a bound pair of a soliton and an antisoliton."""
    p, q = sp.symbols("p q", positive=True)
    carrier = p * (xi + (p**2 - 3 * q**2) * tau)
    envelope = q * (xi + (3 * p**2 - q**2) * tau + X_0)
    tangent = q * sp.sin(carrier) / (p * sp.cosh(envelope))
    return ClosedForm(
        name="breather",
        title="breather",
        expression=_slope(tangent),
        equation=FOCUSING_MKDV,
        parameters=(
            positive(p, "the double-pole soliton"),
            positive(q, "the zero solution"),
            real(X_0),
        ),
        reference=Reference("clarke2000generation", "standard mKdV"),
        stabilise=lambda: _bounded_slope(tangent),
    )


def double_pole() -> ClosedForm:
    """Return the double-pole soliton: a soliton and an antisoliton that separate like log|T|.

    M. Wadati and K. Ohkuma, Multiple-pole solutions of the modified Korteweg-de Vries equation,
    J. Phys. Soc. Jpn. 51 (1982) 2029.
    """
    tangent = A * (xi - 3 * A**2 * tau + X_0) / sp.cosh(A * (xi - A**2 * tau))
    return ClosedForm(
        name="double_pole",
        title="double-pole soliton",
        expression=_slope(tangent),
        equation=FOCUSING_MKDV,
        parameters=(positive(A, "the zero solution"), real(X_0)),
        reference=Reference("wadati1982multiple", "standard mKdV"),
        stabilise=lambda: _bounded_slope(tangent),
    )


def two_soliton() -> ClosedForm:
    """Return two sech solitons of different amplitudes, one overtaking the other.

    R. Hirota, Exact solution of the modified Korteweg-de Vries equation for multiple collisions of
    solitons, J. Phys. Soc. Jpn. 33 (1972) 1456.
    """
    return ClosedForm(
        name="two_soliton",
        title="two solitons",
        expression=_slope(_tangent(sp.exp(_phases[0]), sp.exp(_phases[1]), _repulsion)),
        equation=FOCUSING_MKDV,
        parameters=(
            positive(_A_1, "the zero solution"),
            positive(
                _A_2,
                "the sech soliton",
                Bound(_A_1, "the sech soliton, the other infinitely far away"),
            ),
            real(X_0),
        ),
        reference=Reference("hirota1972exact", "standard mKdV"),
        stabilise=_stable_solitons,
    )


def _tangent(f: sp.Expr, g: sp.Expr, r: sp.Expr) -> sp.Expr:
    return (f + g) / (1 - r**2 * f * g)


def _fraction() -> tuple[sp.Poly, sp.Poly]:
    """Return the wave's numerator and denominator; their symbols f and g stand for r f and r g."""
    tangent = _tangent(_f, _g, _r)
    slope = _A_1 * _f * sp.diff(tangent, _f) + _A_2 * _g * sp.diff(tangent, _g)
    wave = sp.cancel((2 * slope / (1 + tangent**2)).subs({_f: _f / _r, _g: _g / _r}))
    numerator, denominator = sp.fraction(wave)
    return sp.Poly(numerator, _f, _g), sp.Poly(denominator, _f, _g)


def _divide(polynomial: sp.Poly, tanhs: list[sp.Symbol], sechs: list[sp.Symbol]) -> sp.Expr:
    """Return ``4 polynomial/((1 + f**2) (1 + g**2))`` in tanh and sech: f, g are exponentials."""
    weights = [(1 - t, s, 1 + t) for t, s in zip(tanhs, sechs, strict=True)]
    return sp.expand(sum(c * weights[0][i] * weights[1][j] for (i, j), c in polynomial.terms()))


def without_cancellation(t: Sequence[sp.Symbol], s: Sequence[sp.Symbol]) -> sp.Expr:
    """Return ``gap = 1 - t_1 t_2`` without cancellation, from tanh ``t`` and sech ``s`` of phases.

    The step ``gap = (gap**2 + 1 - (t_1 t_2)**2)/2``, where ``1 - (t_1 t_2)**2`` is a sum of
    squares, squares the error of the gap; two steps leave none.
    """
    gap = 1 - t[0] * t[1]
    for _ in range(2):
        gap = (gap**2 + s[0] ** 2 + (s[1] * t[0]) ** 2) / 2
    return gap


def _stable_solitons() -> sp.Expr:
    """Return the wave in tanh and sech of phases shifted by ``log r``, over a positive divisor."""
    t, s = list(sp.symbols("t_1 t_2", real=True)), list(sp.symbols("s_1 s_2", positive=True))
    gap = sp.Symbol("gap", positive=True)
    numerator, denominator = (_divide(part, t, s) for part in _fraction())
    denominator = sp.expand(denominator.subs(t[0], (1 - gap) / t[1]))
    shifted = [phase + sp.log(_repulsion) for phase in _phases]
    values = dict(zip(t + s, [f(z) for f in (sp.tanh, sp.sech) for z in shifted], strict=True))
    wave = numerator / sp.collect(denominator, gap, sp.factor)
    return wave.subs(gap, without_cancellation(t, s)).subs(_r, _repulsion).xreplace(values)
