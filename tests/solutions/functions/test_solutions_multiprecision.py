"""The mpmath implementations against Legendre's incomplete integrals and quadrature."""

import pytest
from mpmath import MPContext

from longwave.solutions.functions import multiprecision as mp

ctx = MPContext()
ctx.dps = 40


@pytest.mark.parametrize("m", ["1e-20", "0.3", "0.999999", "0.99999999999999999999999999999"])
@pytest.mark.parametrize("phi", ["-1.2", "0.4", "1.5"])
def test_amplitude_form(m: str, phi: str) -> None:
    """At u = F(phi, m): sn = sin phi, epsilon = E(phi, m); Carlson's integrals, no theta series."""
    parameter, angle = ctx.mpf(m), ctx.mpf(phi)
    u = ctx.ellipf(angle, parameter)
    dn = ctx.sqrt(1 - parameter * ctx.sin(angle) ** 2)
    assert ctx.almosteq(mp.sn(ctx, u, parameter), ctx.sin(angle), 1e-38)
    assert ctx.almosteq(mp.cn(ctx, u, parameter), ctx.cos(angle), 1e-37)
    assert ctx.almosteq(mp.dn(ctx, u, parameter), dn, 1e-37)
    assert ctx.almosteq(mp.epsilon(ctx, u, parameter), ctx.ellipe(angle, parameter), 1e-37)


def test_theta_series() -> None:
    """H and Theta are the paper's series in the nome, not normalised."""
    m, u = ctx.mpf(1) / 3, ctx.mpf(7) / 4
    K = ctx.ellipk(m)
    q, v = ctx.exp(-ctx.pi * ctx.ellipk(1 - m) / K), ctx.pi * u / (2 * K)
    eta = 2 * sum(
        (-1) ** n * q ** ((n + ctx.mpf(1) / 2) ** 2) * ctx.sin((2 * n + 1) * v) for n in range(9)
    )
    theta = 1 + 2 * sum((-1) ** n * q ** (n * n) * ctx.cos(2 * n * v) for n in range(1, 9))
    assert ctx.almosteq(mp.eta(ctx, u, m), eta, 1e-38)
    assert ctx.almosteq(mp.theta(ctx, u, m), theta, 1e-38)


def test_epsilon_is_the_integral_of_dn_squared_for_complex_arguments() -> None:
    m, end = ctx.mpf(2) / 5, ctx.mpc(1, "0.6")
    integral = ctx.quad(lambda s: mp.dn(ctx, s, m) ** 2, [0, end])
    assert abs(mp.epsilon(ctx, end, m) - integral) < 1e-30


def test_elementary_ends() -> None:
    assert mp.zeta(ctx, 2, 1) == ctx.tanh(2)
    assert mp.epsilon(ctx, 2, 0) == 2
    assert mp.sn(ctx, 0, "0.7") == 0
    with pytest.raises(ValueError, match="m must satisfy m != 1"):
        mp.eta(ctx, 1, 1)


def test_context_precision_is_left_alone() -> None:
    before = ctx.prec
    mp.epsilon(ctx, 10**9, "0.999999999999")
    assert ctx.prec == before
