"""Values of Weierstrass' function in ball arithmetic, of any invariants.

p(z) = 1/z**2 + sum of c_k z**(2 k - 2), k >= 2, with c_2 = g2/20, c_3 = g3/28 and, from k = 4 on,
(2 k + 1)(k - 3) c_k = 3 sum of c_i c_(k - i), 2 <= i <= k - 2.  If B**2 >= |g2|/60 and
B**3 >= |g3|/84 then |c_k| <= 3 B**k, by induction: of k - 3 products each is at most 9 B**k.
"""

from __future__ import annotations

from flint import acb, arb

TERMS = 80
"""Terms of the series, which is taken where B |z|**2 <= 1/16."""

LEAST = arb(2) ** -60
"""FLINT has no cube root of 0."""


def weierstrass(z: acb, g2: acb, g3: acb) -> tuple[acb, acb]:
    """p and its derivative at ``z``, by halving z and adding points of the cubic curve."""
    bound = _upper(abs(g2) / 60).sqrt() + _upper(abs(g3) / 84 + LEAST).root(3)
    halvings = 0
    while not bound * abs(z) ** 2 < arb(1) / 16 and halvings < 64:
        z, halvings = z / 2, halvings + 1
    p, slope = _series(z, g2, g3, _upper(bound))
    for _ in range(halvings):
        tangent = (6 * p * p - g2 / 2) / slope
        doubled = tangent * tangent / 4 - 2 * p
        p, slope = doubled, -slope - tangent * (doubled - p)
    return p, slope


def _series(z: acb, g2: acb, g3: acb, bound: arb) -> tuple[acb, acb]:
    """The terms of k < TERMS, and the rest of either series, which its first one bounds."""
    c = [acb(0), acb(0), g2 / 20, g3 / 28]
    for k in range(4, TERMS):
        products = sum((c[i] * c[k - i] for i in range(2, k - 1)), acb(0))
        c.append(3 * products / ((2 * k + 1) * (k - 3)))
    square = z * z
    p = 1 / square + sum((c[k] * square ** (k - 1) for k in range(2, TERMS)), acb(0))
    slope = sum(((2 * k - 2) * c[k] * square ** (k - 2) for k in range(2, TERMS)), acb(0)) * z
    slope -= 2 / (square * z)
    ratio = bound * _upper(abs(square))
    rest = 3 * bound * ratio ** (TERMS - 1) / (1 - ratio)
    return _blurred(p, rest), _blurred(slope, rest * 4 * TERMS / abs(z))


def _upper(value: arb) -> arb:
    """The upper end of a ball."""
    return arb(value.upper())


def _blurred(value: acb, error: arb) -> acb:
    radius = arb(0, error.upper())
    return value + acb(radius, radius)
