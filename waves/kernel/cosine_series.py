"""Even periodic functions f_0 + 2 (f_1 cos x + f_2 cos 2x + ...) as lists of balls [f_0, f_1, ...].

The norm |f_0| + 2 (|f_1| nu + |f_2| nu^2 + ...) with nu >= 1 bounds the supremum, and that of a
product is at most the product of the norms.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from flint import acb, arb, arb_poly

Series = list[arb]


def product(f: Sequence[arb], g: Sequence[arb]) -> Series:
    """Return the product of two functions."""
    top = len(f) + len(g) - 2
    full = _laurent(f) * _laurent(g)
    return [full[top + j] for j in range(top + 1)]


def _laurent(f: Sequence[arb]) -> arb_poly:
    return arb_poly([*reversed(f[1:]), *f])


def polynomial_of(coefficients: Sequence[arb], f: Sequence[arb]) -> Series:
    """Return c_0 + c_1 f + c_2 f^2 + ... for the coefficients [c_0, c_1, ...]."""
    result: Series = [arb(0)]
    for coefficient in reversed(coefficients):
        result = product(result, f)
        result[0] += coefficient
    return result


def derivative(coefficients: Sequence[arb], order: int) -> Series:
    """Return the coefficients of a polynomial's derivative of this ``order``."""
    result = list(coefficients)
    for _ in range(order):
        result = [i * c for i, c in enumerate(result)][1:] or [arb(0)]
    return result


def polynomial_bound(coefficients: Sequence[arb], size: arb) -> arb:
    """Return a bound of |polynomial| with these coefficients, for arguments up to ``size``."""
    total = arb(0)
    for coefficient in reversed(coefficients):
        total = total * size + abs(coefficient)
    return upper(total)


def value_at_zero(f: Sequence[arb]) -> arb:
    """Return f(0)."""
    return f[0] + 2 * sum(f[1:], arb(0))


def norm(f: Sequence[arb], nu: arb) -> arb:
    """Return an upper bound of the norm of f with weight ``nu``."""
    total, weight = arb(0), arb(2)
    for coefficient in reversed(f[1:]):
        total = total * nu + abs(coefficient)
    return upper(abs(f[0]) + weight * nu * total)


def upper(value: arb) -> arb:
    """Return the upper end of a ball, as an exact ball."""
    return value.upper()


def largest(values: Iterable[arb]) -> arb:
    """Return an upper bound of nonnegative values; not finite if one of them is not."""
    result = arb(0)
    for value in values:
        if not value.is_finite():
            return arb.nan()
        result = result.max(value)
    return upper(result)


def least(bounds: Iterable[arb]) -> arb:
    """Return the least of lower bounds of nonnegative numbers; 0 if one is not above 0."""
    result = arb.pos_inf()
    for bound in bounds:
        if not bound > 0:
            return arb(0)
        result = result.min(bound)
    return result.lower()


STEPS = 4096
"""Number of points of a period at which the supremum of a function is sought."""


def supremum(f: Sequence[arb]) -> tuple[arb, arb]:
    """Return bounds from below and above of sup |f|, from the values at equal steps.

    Where |f| is largest, f' = 0: it exceeds the value at the next point by at most (step/2)^2/2
    times the supremum of |f''|.
    """
    sizes = [abs(value) for value in values_at_steps(f, STEPS)]
    curvature = sum((2 * j * j * abs(c) for j, c in enumerate(f)), arb(0))
    half_step = arb.pi() / STEPS
    lowest = arb(0)
    for size in sizes:
        lowest = lowest.max(size.lower())
    return lowest.lower(), upper(largest(sizes) + half_step * half_step * curvature / 2)


def values_at_steps(f: Sequence[arb], count: int) -> list[arb]:
    """Return f at ``count`` equal steps of a period; ``count`` is at least twice len(f)."""
    padded = [*f, *[arb(0)] * (count - 2 * len(f) + 1), *reversed(f[1:])]
    return [value.real for value in acb.dft([acb(c) for c in padded])]


def shifted_sum(g: Sequence[arb], j: int, k: int) -> arb:
    """Return g_{j-k} + g_{j+k}, the entry of the multiplication by g on cosines."""
    return entry(g, j - k) + entry(g, j + k)


def entry(g: Sequence[arb], j: int) -> arb:
    """Return g_|j|, the coefficient for an index of either sign; 0 beyond the list."""
    return g[abs(j)] if abs(j) < len(g) else arb(0)
