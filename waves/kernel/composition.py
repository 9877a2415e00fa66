"""Force laws of an even periodic strain: their cosine series and bounds, with proved remainders."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from flint import acb, acb_poly, arb

from .cosine_series import Series, norm, polynomial_bound, polynomial_of, upper, values_at_steps
from .force_text import Force
from .limits import CertificateError, require_size

ARCS = 192
"""Number of arcs that cover the circle |z| = rho."""


CUT = 1e-33
"""Norm below which the highest coefficients of V'(f) and V''(f) are moved to the remainders."""


@dataclass(frozen=True)
class Strip:
    """Annulus 1/rho <= |z| <= rho on which an analytic force is bounded, with its neighbourhood.

    A strain has the values f_0 + sum f_j (z^j + z^-j). The force is analytic, and bounded on the
    circle, for values within ``margin`` of these; ``samples`` points give its cosine series.
    """

    rho: arb
    margin: arb
    samples: int


@dataclass(frozen=True)
class Composed:
    """Cosine series of V'(f) and V''(f), norms of their remainders, bound of V'''(f + h)."""

    force: Series
    force_rest: arb
    stiffness: Series
    stiffness_rest: arb
    third: arb


def composed(force: Force, f: Sequence[arb], nu: arb, reach: arb, strip: Strip | None) -> Composed:
    """Compose a force with a strain f, in norms with weight ``nu``.

    The bound of V'''(f + h) holds for all h of norm at most ``reach``.

    Raises CertificateError if the force is not analytic on the strip.
    """
    if force.polynomial is not None:
        third = polynomial_bound(force.derivative(2), norm(f, nu) + reach)
        values, slopes = (polynomial_of(force.derivative(order), f) for order in (0, 1))
        return Composed(*trimmed(values, nu, CUT), *trimmed(slopes, nu, CUT), third)
    if strip is None:
        raise CertificateError("an analytic force needs a strip")
    return _analytic(force, f, nu, reach, strip)


def trimmed(f: Series, nu: arb, cut: float) -> tuple[Series, arb]:
    """Drop the highest coefficients, of norm below ``cut``; return the others and a norm bound."""
    rest, top = arb(0), len(f)
    while top > 1:
        more = rest + 2 * abs(f[top - 1]) * nu ** (top - 1)
        if not more < cut:
            break
        rest, top = upper(more), top - 1
    return f[:top], rest


def _analytic(force: Force, f: Sequence[arb], nu: arb, reach: arb, strip: Strip) -> Composed:
    rho, margin, count = strip.rho, strip.margin, strip.samples
    if not (rho > nu and margin > reach and count > 2 * len(f)):
        raise CertificateError("strip must have rho > nu, margin > radius bound, enough samples")
    require_size(4 * count * force.size)
    bounds = _bounds_on_circle(force, f, strip)
    points = values_at_steps(f, count)[: count // 2 + 1]  # the others have the same values
    half = [force.taylor(acb(value), 2) for value in points]
    samples = [*half, *reversed(half[1 : (count + 1) // 2])]
    ratio = nu / rho
    series = []
    for order in (0, 1):
        modes = acb.dft([values[order] for values in samples])
        aliasing = 2 * bounds[order] / (1 - rho**-count)
        known = [
            modes[j].real / count + arb(0, upper(aliasing * rho ** (j - count)))
            for j in range(count // 2)
        ]
        known, rest = trimmed(known, nu, CUT)
        rest += 2 * bounds[order] * ratio ** (count // 2) / (1 - ratio)
        series.append((known, upper(rest)))
    third = bounds[2] * (rho + nu) / (rho - nu) / (1 - reach / margin)
    return Composed(*series[0], *series[1], upper(third))


def _bounds_on_circle(force: Force, f: Sequence[arb], strip: Strip) -> tuple[arb, arb, arb]:
    """Return bounds of V' and V'' at the strain on the circle, and of V''' within the margin."""
    values = list(_values_on_circle(f, strip.rho))
    _require_analytic(force, values, strip.margin)
    bounds = [arb(0)] * 3
    for value in values:
        jet = force.taylor(value, 2)
        wide = force.taylor(_widened(value, strip.margin), 3)
        for order, size in enumerate((jet[0], jet[1], 2 * wide[2])):
            bounds[order] = bounds[order].max(abs(size).upper())
    if not all(bound.is_finite() for bound in bounds):
        raise CertificateError("force leaves its domain on the strip")
    return bounds[0], bounds[1], bounds[2]


def _values_on_circle(f: Sequence[arb], rho: arb) -> Iterator[acb]:
    """Yield balls that cover the strain's values on the circle |z| = rho."""
    slope = sum((j * abs(c) * (rho**j + rho**-j) for j, c in enumerate(f)), arb(0))
    error, half = arb(0, upper(slope * arb.pi() / ARCS)), acb_poly(list(f))
    for arc in range(ARCS // 2 + 1):  # the other half has the conjugate values
        z = acb(rho) * acb(arb(0), 2 * arb.pi() * arc / ARCS).exp()
        yield half(z) + half(1 / z) - f[0] + acb(error, error)


def _widened(value: acb, margin: arb) -> acb:
    return value + acb(arb(0, upper(margin)), arb(0, upper(margin)))


PIECES = 8
"""Number of pieces of each side of the rectangle around a strain's values on the strip."""


def _require_analytic(force: Force, values: Sequence[acb], margin: arb) -> None:
    """Raise CertificateError unless the force is analytic on a rectangle around all values.

    Real and imaginary part of the strain are harmonic, so the rectangle around the values on the
    circle contains those on the annulus.
    """
    low, high, side = values[0].real.lower(), values[0].real.upper(), arb(0)
    for value in values:
        low, high = low.min(value.real.lower()), high.max(value.real.upper())
        side = side.max(abs(value.imag).upper())
    low, high, side = low - margin, high + margin, side + margin
    for i in range(PIECES):
        for j in range(PIECES):
            part = acb(_piece(low, high, i), _piece(-side, side, j))
            if not all(c.is_finite() for c in force.taylor(part, 1)):
                raise CertificateError("force leaves its domain on the strip")


def _piece(low: arb, high: arb, index: int) -> arb:
    width = (high - low) / PIECES
    return (low + index * width).union(low + (index + 1) * width)
