"""Taylor coefficients of special functions in balls."""

import pytest
from flint import acb, arb, ctx

from longwave.verify.kernel.axioms import CYLINDER
from longwave.verify.proof import taylor
from longwave.verify.proof.text_prover import prove
from longwave.verify.verdict import Outcome


@pytest.mark.parametrize(
    "name", ["sn", "cn", "dn", "epsilon", "zeta", "theta", "eta", "exp", "log", "atan", "asin",
             "acosh", "sin", "cosh", "power", "erf", "bessel_j", "bessel_y", "bessel_i", "bessel_k",
             "weierstrass_p", "weierstrass_p_prime", "jacobi_theta_1", "f"]
)  # fmt: skip
def test_taylor_coefficients_continue_a_function(name: str) -> None:
    """The series about z, evaluated at z + h, equals the function there up to h**12."""
    with ctx.workprec(200):
        elliptic = taylor.Elliptic(acb(0.3))
    series = {
        **{n: getattr(elliptic, n) for n in ("sn", "cn", "dn", "epsilon", "zeta", "theta", "eta")},
        **{n: taylor.periodic(n) for n in ("sin", "cosh")},
        **{n: taylor.inverse(n) for n in ("asin", "atan", "acosh")},
        "power": taylor.power(taylor.Fraction(2, 3)),
        **{n: taylor.special(n) for n in ("exp", "log", "erf")},
        **{n: taylor.bessel(n, acb(0.75)) for n in CYLINDER},
        "weierstrass_p": taylor.weierstrass(acb(2), acb(1), 0),
        "weierstrass_p_prime": taylor.weierstrass(acb(2), acb(1), 1),
        "jacobi_theta_1": taylor.free("jacobi_theta_1", 2, acb(0.25)),
        "f": taylor.free("f", 1),
    }[name]
    with ctx.workprec(200):
        z = acb(1.4 if name == "acosh" else 0.4)
        h = acb(arb(1) / 1024)
        found = sum((c * h**n for n, c in enumerate(series(z, 12))), acb(0))
        size = abs(series(z, 0)[0]) + 1
        assert abs(found - series(z + h, 0)[0]) < 1e-28 * size


@pytest.mark.parametrize("order", [10, 12])
def test_high_derivatives_are_not_taken_for_nought(order: int) -> None:
    """Catches: FLINT's series cut at 10 terms, which refuted derivatives of u'' = x u."""

    def slope(times: int) -> str:
        return f"diff(u, {', '.join(['x'] * times)})"

    derived = f"{slope(order)} - x*{slope(order - 2)} - {order - 2}*{slope(order - 3)}"
    assert prove(derived, "u = airy_ai(x)").outcome is Outcome.PROVED
