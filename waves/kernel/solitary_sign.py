r"""Sign of a proved solitary wave.

If all K_m >= 0, the kernels of T_m T_n/Delta are sums of products of boxes: K > 0. Let N_m >= 0 for
y >= 0, and |N_m(y)| <= s |y| for -low <= y < 0 with s ||K*|| < 1. A wave with y_m >= -low has the
negative parts y^- <= K*(g^-) and g^- <= s y^-, so ||y^-|| <= s ||K*|| ||y^-|| and y^- = 0. Then
g >= 0 is not 0, and f > 0. The same holds for -f, with -N(-y).
"""

from __future__ import annotations

from flint import acb, arb

from .cosine_series import Series, largest, norm, supremum, upper
from .force_text import Force
from .limits import CertificateError
from .solitary_numbers import SolitaryNumbers

PIECES = 64
"""Number of pieces of the range of strains on which N'' is bounded."""

MOST_TERMS = 10


def proved_sign(numbers: SolitaryNumbers) -> int:
    """Return 1 if f > 0 is proved for the wave, -1 if f < 0 is, else 0."""
    centre = numbers.centre
    stiffness = [s for _, s in centre.line.stiffness]
    if not (all(s >= 0 for s in stiffness) and any(s > 0 for s in stiffness)):
        return 0
    sign = 1 if numbers.crest > 0 else -1
    try:
        proved = all(
            _has_sign(numbers, spring.force, [sign * c for c in law.stretch], sign)
            for spring, law in zip(centre.nonlinear, centre.laws, strict=True)
        )
    except CertificateError:  # the force leaves its domain on the pieces
        return 0
    return sign if proved else 0


def _has_sign(numbers: SolitaryNumbers, force: Force, stretch: Series, sign: int) -> bool:
    low = largest([_depth(stretch) + numbers.reach, numbers.outer])
    third = abs(2 * force.taylor(acb(arb(0, low)), 3)[2])
    if not third * low / 2 * numbers.centre.norm_of_kernel(1) < 1:
        return False
    return _pushes(force, sign, upper(norm(stretch, arb(1)) + numbers.reach))


def _depth(f: Series) -> arb:
    """Return an upper bound, not below 0, of -f."""
    most = norm(f, arb(1))
    return upper((supremum([most - f[0], *(-c for c in f[1:])])[1] - most).max(arb(0)))


def _pushes(force: Force, sign: int, top: arb) -> bool:
    """Return whether s N(s y) >= 0 is proved for 0 <= y <= ``top``, s = ``sign``.

    N and N' are bounded from below by the bounds of N'' on the pieces before.
    """
    step, value, slope = upper(top / PIECES), arb(0), arb(0)
    for i in range(PIECES):
        piece = acb(sign * (i * step).union((i + 1) * step))
        third = (sign * 2 * force.taylor(piece, 3)[2].real).lower()
        if i == 0 and _begins_upwards(force, sign, piece):
            third = third.max(arb(0))
        after = value + slope * step + third * step * step / 2
        if not (after >= 0 and (third <= 0 or slope >= 0)):
            return False
        value, slope = after.lower(), (slope + third * step).lower()
    return True


def _begins_upwards(force: Force, sign: int, piece: acb) -> bool:
    """Return whether the first derivative of N that is not 0 at rest proves s N'' >= 0."""
    at_rest = force.taylor(acb(0), MOST_TERMS)
    order = next((i for i in range(2, MOST_TERMS) if not at_rest[i].is_zero()), 0)
    if not order:
        return False
    leading = force.taylor(piece, order + 1)[order].real
    return bool(sign ** (order + 1) * leading > 0)
