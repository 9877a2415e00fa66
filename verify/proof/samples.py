"""Reproducible random rational points of domains: both signs, all sizes, near the ends."""

from __future__ import annotations

import random
from collections.abc import Mapping

import sympy as sp

from .domains import Domain, Domains, Point, in_order

DENOMINATORS = (1009, 2147483647, 65537, 1009)
"""Prime denominators of drawn values; no small integer times all values gives integers."""

SIZES = (1, 1, 1, 4, 4, sp.Rational(1, 30), 30, sp.Rational(1, 1000), 1000)
"""Scales of values drawn from an unbounded domain; most are moderate, where balls are narrow."""

MARGINS = (sp.Rational(1, 20),) * 3 + (sp.Rational(1, 1000), sp.Rational(1, 10**6))
"""Fractions of a bounded domain to leave out at each end; each drawn value uses one of them."""

NARROW_MARGIN, NARROW_PERIOD = sp.Rational(1, 10**31), 4
"""Margin of one symbol, used in every ``NARROW_PERIOD``-th of the later points."""

REJECTIONS = 1000
"""Successive points outside the domains after which these are taken to be empty."""

SIGN_PATTERNS = 5
"""Most symbols whose signs are combined in all ways by the first points."""


def sample(domains: Domains, count: int, seed: int = 0) -> tuple[Point, ...]:
    """Return ``count`` points: first moderate ones with all combinations of signs, then all sizes.

    Raises ValueError if too few points are found in the domains.
    """
    draw = random.Random(seed)
    ordered = in_order(domains)
    signed = [s for s in ordered if _has_both_signs(domains[s])][:SIGN_PATTERNS]
    points, number, rejected = list[Point](), 0, 0
    while len(points) < count and rejected < REJECTIONS:
        signs = {s: -1 if number >> place & 1 else 1 for place, s in enumerate(signed)}
        early = number < 2 ** len(signed)
        point: dict[sp.Symbol, sp.Rational] = {}
        edges = ordered if not early and number % NARROW_PERIOD == 0 else []
        edge = edges[number // NARROW_PERIOD % len(edges)] if edges else None
        for symbol in ordered:
            scale = sp.S.One if early else draw.choice(SIZES)
            margin = MARGINS[0] if early else draw.choice(MARGINS)
            sign = signs.get(symbol, 1) if early else draw.choice((1, -1))
            if symbol == edge:
                scale, margin, sign = NARROW_MARGIN, NARROW_MARGIN, 1
            point[symbol] = _value(domains[symbol], point, scale * sign, margin, draw)
        inside = all(domains[s].contains(value, point) for s, value in point.items())
        points += [point] * inside
        number, rejected = number + 1, 0 if inside else rejected + 1
    if len(points) < count:
        words = ", ".join(domain.text(symbol) for symbol, domain in domains.items())
        raise ValueError(f"domains must hold rational points, got {words} (none was found)")
    return tuple(points)


def _has_both_signs(domain: Domain) -> bool:
    low, high = domain.lower, domain.upper
    below = low == -sp.oo and (high == sp.oo or high.is_positive)
    return bool(below or (high == sp.oo and low.is_negative))


def _value(
    domain: Domain,
    known: Mapping[sp.Symbol, sp.Rational],
    scale: sp.Rational,
    margin: sp.Rational,
    draw: random.Random,
) -> sp.Rational:
    """Draw a value: at a random fraction of a bounded domain, else at a distance from its end."""
    lower, upper = (rational_near(end) for end in domain.ends(known))
    prime = draw.choice(DENOMINATORS)
    fraction = sp.Rational(draw.randint(1, prime - 1), prime)
    if lower is None:
        value = scale * fraction if upper is None else upper - _length(-upper, scale) * fraction
    elif upper is None:
        value = lower + _length(lower, scale) * fraction
    else:
        edge = margin * (upper - lower)
        value = lower + edge + (upper - lower - 2 * edge) * fraction
        if margin < MARGINS[0]:
            near = edge * (1 + fraction)
            value = draw.choice((value, lower + near, upper - near))
    if not domain.integer:
        return sp.Rational(value)
    return sp.Integer(draw.randint(-9, 9) + int(value) if abs(value) <= 9 else int(value))


def _length(end: sp.Rational, scale: sp.Rational) -> sp.Rational:
    """Return the largest distance from ``end`` to draw: |scale|, or 2 |end| to cross 0."""
    return abs(scale) if scale > 0 or end >= 0 else -2 * end


def rational_near(end: sp.Expr) -> sp.Rational | None:
    """Return a rational number closer to a real end than any margin; None if it is infinite."""
    if end in (sp.oo, -sp.oo):
        return None
    if end.is_Rational:
        return end
    number = sp.N(end, 20)
    if not number.is_Float:
        remedy = "state where what it contains makes it so"
        raise ValueError(f"ends of domains must be real, got {end} ({remedy})")
    return sp.Rational(str(number))
