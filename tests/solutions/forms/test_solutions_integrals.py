"""The theta integrals in closed form equal the printed ones."""

from typing import Any

import pytest
import sympy as sp

from longwave.solutions.forms import rogue_cn, soliton_dn
from longwave.solutions.functions.multiprecision import MpmathFormula
from longwave.solutions.symbols import k

u = sp.Symbol("u", real=True)
UPPER_LIMITS = ["7.3", "-2.6"]


def quadrature(ctx: Any, integrand: sp.Expr, modulus: Any, upper: Any) -> Any:
    formula = MpmathFormula.of([u, k], [integrand])
    pieces = [upper * j / 6 for j in range(7)]
    return ctx.quad(lambda y: formula(ctx, y, modulus)[0], pieces)


@pytest.mark.parametrize("upper", UPPER_LIMITS)
@pytest.mark.parametrize("modulus", ["0.3", "0.9"])
def test_dn_integral(upper: str, modulus: str, ctx: Any) -> None:
    ctx.dps = 25
    value, K = ctx.mpf(upper), ctx.mpf(modulus)
    (closed,) = MpmathFormula.of([u, k], [soliton_dn.integral(u)])(ctx, value, K)
    assert abs(quadrature(ctx, soliton_dn.integrand(u), K, value) - closed) < 1e-20


@pytest.mark.parametrize("upper", UPPER_LIMITS)
@pytest.mark.parametrize("modulus", ["0.3", "0.9"])
def test_cn_integral(upper: str, modulus: str, ctx: Any) -> None:
    ctx.dps = 25
    value, K = ctx.mpf(upper), ctx.mpf(modulus)
    real, imaginary = MpmathFormula.of([u, k], rogue_cn.integral(u))(ctx, value, K)
    printed = quadrature(ctx, rogue_cn.integrand(u), K, value)
    assert abs(printed.real - real) < 1e-20
    assert abs(printed.imag - imaginary) < 1e-20
