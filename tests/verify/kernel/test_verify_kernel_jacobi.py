"""Values of the Jacobi functions against the integrals that define them."""

import pytest
from flint import acb, arb, ctx

from longwave.verify.kernel.function_values import Jacobi

M, Z = arb(0.25), acb(0.7)


@pytest.fixture(scope="module")
def jacobi() -> Jacobi:
    with ctx.workprec(200):
        return Jacobi(acb(M))


def near(left: acb, right: acb) -> bool:
    return bool(left.overlaps(right) and abs(left - right) < 1e-20)


def test_sn_inverts_the_elliptic_integral_of_the_first_kind(jacobi: Jacobi) -> None:
    with ctx.workprec(200):
        slope = lambda s, _: 1 / ((1 - s * s) * (1 - M * s * s)).sqrt()  # noqa: E731
        assert near(acb.integral(slope, acb(0), jacobi.sn(Z)), Z)


def test_cn_and_dn_are_roots_of_squares_that_sn_gives(jacobi: Jacobi) -> None:
    with ctx.workprec(200):
        sn, cn, dn = jacobi.sn(Z), jacobi.cn(Z), jacobi.dn(Z)
        assert near(cn, (1 - sn * sn).sqrt())
        assert near(dn, (1 - M * sn * sn).sqrt())
        assert near(jacobi.cn(3 * Z), -((1 - jacobi.sn(3 * Z) ** 2).sqrt()))


def test_epsilon_integrates_the_square_of_dn_and_zeta_is_the_rest_of_its_mean(
    jacobi: Jacobi,
) -> None:
    with ctx.workprec(200):
        epsilon = acb.integral(lambda s, _: jacobi.dn(s) ** 2, acb(0), Z)
        assert near(jacobi.epsilon(Z), epsilon)
        mean = acb(M).elliptic_e() / acb(M).elliptic_k()
        assert near(jacobi.zeta(Z), epsilon - mean * Z)


def test_theta_grows_by_zeta_from_the_value_of_jacobi_at_zero(jacobi: Jacobi) -> None:
    with ctx.workprec(200):
        growth = acb.integral(lambda s, _: jacobi.zeta(s), acb(0), Z).exp()
        start = (2 * acb(1 - M).sqrt() * acb(M).elliptic_k() / acb.pi()).sqrt()
        assert near(jacobi.theta(Z), start * growth)
        assert near(jacobi.eta(Z), acb(M).root(4) * jacobi.sn(Z) * start * growth)


@pytest.mark.parametrize("m", [acb(0), acb(1), acb(0.5, 0.5), acb(arb(1, 0.1))])
def test_a_parameter_is_real_and_not_an_end(m: acb) -> None:
    with pytest.raises(ValueError, match="elliptic parameters must be"):
        Jacobi(m)


def test_a_parameter_above_one_has_the_functions_of_its_reciprocal() -> None:
    """Catches: cn and dn, or the factors of the integral, in one another's places."""
    with ctx.workprec(200):
        above, z = Jacobi(acb(3)), acb(0.3)
        slope = lambda s, _: 1 / ((1 - s * s) * (1 - 3 * s * s)).sqrt()  # noqa: E731
        assert near(acb.integral(slope, acb(0), above.sn(z)), z)
        assert near(above.cn(z), (1 - above.sn(z) ** 2).sqrt())
        assert near(above.dn(z), (1 - 3 * above.sn(z) ** 2).sqrt())
        assert near(above.epsilon(z), acb.integral(lambda s, _: above.dn(s) ** 2, acb(0), z))
        for function in (above.zeta, above.theta, above.eta):
            with pytest.raises(ValueError, match="need m < 1"):
                function(z)
