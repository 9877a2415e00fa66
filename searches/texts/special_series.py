"""Taylor coefficients of Bessel's, Weierstrass' and theta functions, for the judge alone.

None is computed as in the prover or the checker: Bessel functions by those of other orders,
Weierstrass' function by Jacobi's.
"""

from __future__ import annotations

from itertools import permutations
from math import comb, factorial

from flint import acb, acb_poly, arb, ctx


def is_off_cut(name: str, v: acb, z: acb) -> bool:
    """Whether a Bessel function of order ``v`` is analytic at ``z``."""
    entire = name in ("bessel_j", "bessel_i") and v.unique_fmpz() is not None
    return bool(entire or not z.imag.contains(0) or z.real > 0)


def bessel(name: str, v: acb, z: acb, order: int) -> list[acb]:
    """A Bessel function: the n-th derivative is a sum of those of the orders v - n to v + n."""
    turn, sign = (-1 if name == "bessel_k" else 1), (-1 if name in ("bessel_j", "bessel_y") else 1)
    values = {n: getattr(z, name)(v + n) for n in range(-order, order + 1)}
    found = []
    for n in range(order + 1):
        parts = (sign**i * comb(n, i) * values[2 * i - n] for i in range(n + 1))
        found.append(sum(parts, acb(0)) * turn**n / (2**n * factorial(n)))
    return found


def weierstrass(name: str, at: acb, g2: acb, g3: acb, order: int) -> list[acb]:
    """p = e3 + w**2/sn(w z)**2 with w**2 = e1 - e3, further by the differential equation."""
    near = arb(2) ** (-3 * ctx.prec // 4)
    for e1, e2, e3 in permutations(acb_poly([-g3, -g2, 0, 4]).roots(near)):
        m, gap = (e2 - e3) / (e1 - e3), e1 - e3
        if all(not z.imag.contains(0) or z.real > 0 for z in (m, 1 - m, gap)):
            break
    w = gap.sqrt()
    quarter = m.elliptic_k()
    tau, place = acb(0, 1) * (1 - m).elliptic_k() / quarter, w * at / (2 * quarter)
    one, two, three, four = acb.modular_theta(place, tau)
    _, two0, three0, four0 = acb.modular_theta(acb(0), tau)
    s, c = three0 * one / (two0 * four), four0 * two / (two0 * four)
    d = four0 * three / (three0 * four)
    p = [e3 + (w / s) ** 2, -2 * w**3 * c * d / s**3]
    for n in range(order):
        products = sum((p[i] * p[n - i] for i in range(n + 1)), acb(0))
        p.append((6 * products - (g2 / 2 if n == 0 else 0)) / ((n + 1) * (n + 2)))
    return p[:-1] if name == "weierstrass_p" else [n * c for n, c in enumerate(p)][1:]


def theta(place: int, z: acb, logarithm: acb, order: int) -> list[acb]:
    """The derivatives in z of a theta function, given the logarithm of its nome."""
    tau, pi = logarithm / (acb(0, 1) * acb.pi()), acb.pi()
    return [(z / pi).modular_theta(tau, n)[place] / pi**n for n in range(order + 1)]
