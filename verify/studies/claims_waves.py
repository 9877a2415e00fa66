"""The paper's statements about the waves themselves: peaks, degrees, localisation."""

from functools import cache

import numpy as np
import sympy as sp

from derive import mkdv_normal_form
from solutions import Wave, closed_form, rational
from verify.proof.rational_proofs import RationalFacts, rational_facts
from verify.studies.claims_record import Claim, Measurement, ruling

ORDERS = range(2, 9)
ROGUE_MODULI = (0.1, 0.3, 0.5, 0.7, 0.9, 0.99)
LATE = 1e4
"""The slow time at which the rational waves are looked at again."""

SEARCH = 401
"""Points along each axis of a search."""


@cache
def facts(order: int) -> RationalFacts:
    """The exact facts about the rational solution of that order."""
    return rational_facts(order)


def peaks() -> Claim:
    """The value 2j + 1 at the origin, exactly."""
    found = tuple(Measurement(f"$Y_{j}$", float(facts(j).peak)) for j in ORDERS)
    return Claim(
        "peaks",
        "$Y_2$ and $Y_3$ have the maximum 5 and 7, $Y_j$ in general $2j+1$, at the origin",
        found,
        ruling(*(facts(j).peak == 2 * j + 1 for j in ORDERS)),
        f"nothing: exact, for $j$ from {ORDERS[0]} to {ORDERS[-1]}",
    )


def degrees() -> Claim:
    """Two powers more in the denominator than in the numerator, over the background."""
    excess = {j: _excess(j) for j in (2, 3)}
    found = tuple(
        Measurement(f"$Y_{j}$: degree {facts(j).degree} over {facts(j).degree - excess[j]}, by", e)
        for j, e in excess.items()
    )
    return Claim(
        "degrees",
        "The denominator has two powers more than the numerator",
        found,
        ruling(*(e == 2 for e in excess.values())),
        "nothing: exact, in $X$, for the wave less its background",
    )


def _excess(order: int) -> int:
    """How much faster the denominator grows in xi than the numerator of U - background."""
    form = closed_form(f"rational_{order}")
    x = form.equation.xi
    above, below = sp.fraction(sp.cancel(form.expression - form.background))
    return int(sp.degree(below, x) - sp.degree(above, x))


def localised_in_space() -> Claim:
    """The same limit on both sides at every time."""
    found = tuple(Measurement(f"$Y_{j}$, background", float(facts(j).background)) for j in (2, 3))
    return Claim(
        "localised_in_space",
        "The rational waves are localised on the backgrounds $+1$ and $-1$: in space",
        found,
        ruling(facts(2).background == 1, facts(3).background == -1),
        "nothing: exact, at every fixed time",
    )


def localised_in_time() -> Claim:
    """The largest distance from the background long after the peak."""
    found = tuple(
        Measurement(f"$Y_{j}$, largest distance at $T={LATE:g}$", _late_amplitude(j))
        for j in (2, 3)
    )
    return Claim(
        "localised_in_time",
        "The rational waves are localised (rogue waves): in time too",
        found,
        ruling(*(item.value < 0.1 for item in found)),
        "nothing: extrema at distance 4 from the background persist and separate like $t^{1/3}$",
    )


def _late_amplitude(order: int) -> float:
    """max |Y - background| at the time LATE, searched where the extrema have gone."""
    wave = Wave(closed_form(f"rational_{order}"), mkdv_normal_form(K2=4, K4=1))
    a, b = (float(getattr(wave.normal_form, name)) for name in ("a", "b"))
    tau = b * LATE
    reach = 4.0 * (12.0 * tau) ** (1.0 / 3.0)
    x = np.linspace(-reach, reach, 100 * SEARCH)
    distance = wave((x + 6.0 * tau) / a, LATE).Y - (wave.constant_background or 0.0)
    return float(np.max(np.abs(distance)))


def rogue_maximum() -> Claim:
    """No value of the cn rogue wave exceeds that at the origin."""
    found, holds = [], []
    for k in ROGUE_MODULI:
        peak, elsewhere = _rogue_search(k)
        found.append(Measurement(f"$k={k}$: at the origin, in units of $k$", peak / k))
        holds.append(elsewhere <= peak * (1 + 1e-12))
    return Claim(
        "rogue_maximum",
        "The cn rogue wave has its global maximum at $(X,T)=(0,0)$",
        tuple(found),
        ruling(*holds),
        f"$k$; a search over {SEARCH} by {SEARCH} points of 8 wavelengths and $|tau|$ to 40, and "
        "closer to the origin, finds nothing larger",
    )


def _rogue_search(k: float) -> tuple[float, float]:
    """The value at the origin, and the largest modulus found."""
    wave = Wave(closed_form("rogue_cn"), mkdv_normal_form(K2=4, K4=1), k=k)
    a, b = (float(getattr(wave.normal_form, name)) for name in ("a", "b"))
    far = 4.0 * (wave.wavelength or 1.0)
    line = np.linspace(-1.0, 1.0, SEARCH)
    largest = 0.0
    for x, t in ((far, 40.0 / b), (1.0 / a, 1.0 / b)):
        X, T = np.meshgrid(x * line, t * line)
        largest = max(largest, float(np.max(np.abs(wave(X, T).Y))))
    return float(wave(0.0, 0.0).Y), largest


def higher_orders() -> Claim:
    """Higher orders exist, with larger peaks."""
    j = ORDERS[-1]
    wave = Wave(rational(j), mkdv_normal_form(K2=4, K4=1))
    return Claim(
        "higher_orders",
        "Higher-order rational solutions have larger maximum amplitudes",
        (Measurement(f"$Y_{j}$ at the origin", float(wave(0.0, 0.0).Y)),),
        ruling(all(facts(j).peak < facts(j + 1).peak for j in ORDERS[:-1])),
        "nothing: exact",
    )
