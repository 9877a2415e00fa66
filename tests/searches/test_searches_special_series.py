"""The judge's special functions beside the checker's, which are computed in another way."""

import pytest
from flint import acb, ctx

from longwave.verify.kernel.axioms import CYLINDER, FUNCTIONS
from longwave.verify.kernel.function_values import theta_ball
from longwave.verify.kernel.reading import THETA
from longwave.verify.proof import taylor
from searches.texts import special_series

BITS, ORDER = 200, 5
Z = (acb(0.75), acb(0.5, 0.25), acb(2.5, -1))


def agree(own: list[acb], other: list[acb]) -> bool:
    assert len(own) == len(other)
    return all(
        a.overlaps(b) and abs((a - b).abs_upper()) < 1e-30 * (1 + abs(a.abs_upper()))
        for a, b in zip(own, other, strict=True)
    )


@pytest.mark.parametrize("z", Z, ids=str)
@pytest.mark.parametrize("name", list(CYLINDER))
def test_bessels_functions(name: str, z: acb) -> None:
    with ctx.workprec(BITS):
        for v in (acb(0), acb(0.75), acb(-2.5), acb(3)):
            own = special_series.bessel(name, v, z, ORDER)
            assert own[0].overlaps(FUNCTIONS[name].ball(v, z))
            assert agree(own, taylor.bessel(name, v)(z, ORDER))


@pytest.mark.parametrize("z", Z, ids=str)
@pytest.mark.parametrize(("g2", "g3"), [(4, 1), (0, 1), (-3, 2), (2, 0), (-2, 0), (1, -5)])
def test_weierstrass_function(g2: int, g3: int, z: acb) -> None:
    with ctx.workprec(BITS):
        g, h = acb(g2), acb(g3)
        for slopes, name in enumerate(("weierstrass_p", "weierstrass_p_prime")):
            own = special_series.weierstrass(name, z, g, h, ORDER)
            assert agree(own, taylor.weierstrass(g, h, slopes)(z, ORDER))


@pytest.mark.parametrize("z", Z, ids=str)
@pytest.mark.parametrize("name", THETA)
def test_theta_functions(name: str, z: acb) -> None:
    with ctx.workprec(BITS):
        q = acb(0.375)
        own = special_series.theta(THETA.index(name), z, q.log(), ORDER)
        assert agree(own, [theta_ball(z, q, (name, n)) for n in range(ORDER + 1)])


def test_a_bessel_function_has_a_cut_unless_it_is_entire() -> None:
    assert special_series.is_off_cut("bessel_j", acb(2), acb(-1))
    assert special_series.is_off_cut("bessel_y", acb(2), acb(-1, 1))
    assert not special_series.is_off_cut("bessel_y", acb(2), acb(-1))
    assert not special_series.is_off_cut("bessel_i", acb(0.5), acb(-1))
