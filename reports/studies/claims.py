"""The paper's quantitative and comparative statements, with the numbers measured for them.

To add a statement, add one function with the decorator `claim`. Its texts hold mathematics
between dollars, in plain names ($eps = 0.05$).
"""

import enum
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache, wraps
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import sympy as sp

from longwave.derive import mkdv_normal_form
from longwave.reports.studies.measured_runs import PARTS, RK4_STEP, SPLIT, MeasuredRuns, rk4_name
from longwave.scenes.starts.background_growth import USUAL_TOLERANCE, trust_in
from longwave.solutions import Wave, closed_form, rational
from longwave.verify.proof.rational_proofs import RationalFacts, rational_facts


class Ruling(enum.StrEnum):
    """Verdict on a statement by the measured numbers."""

    CONFIRMED = "confirmed"
    NOT_CONFIRMED = "not confirmed"
    DEPENDS = "depends"


class Measurement(NamedTuple):
    """A measured number: its name, value and discretisation error (0 if it is exact)."""

    of: str
    value: float
    error: float = 0.0


@dataclass(frozen=True)
class Claim:
    """One statement of the paper.

    ``depends_on`` names the parameters on which the verdict rests, and how words that the paper
    leaves open were interpreted.
    """

    name: str
    statement: str
    measurements: tuple[Measurement, ...]
    ruling: Ruling
    depends_on: str


def ruling(*holds: bool) -> Ruling:
    """Return CONFIRMED if all conditions hold, NOT_CONFIRMED if none does, else DEPENDS.

    >>> str(ruling(True, False))
    'depends'
    """
    if all(holds):
        return Ruling.CONFIRMED
    return Ruling.DEPENDS if any(holds) else Ruling.NOT_CONFIRMED


ClaimEvidence = tuple[Iterable[Measurement], Iterable[bool]]
"""Numbers measured for a statement, and whether each condition of the statement holds."""

CLAIMS: list[Callable[[MeasuredRuns], Claim]] = []
"""Functions that each evaluate one statement of the paper, in the order of declaration."""


def claim(
    statement: str, depends_on: str
) -> Callable[[Callable[[MeasuredRuns], ClaimEvidence]], Callable[[MeasuredRuns], Claim]]:
    """Register the decorated function to measure ``statement``; its name becomes the claim's."""

    def declare(
        measure: Callable[[MeasuredRuns], ClaimEvidence],
    ) -> Callable[[MeasuredRuns], Claim]:
        @wraps(measure)
        def evaluated(evidence: MeasuredRuns) -> Claim:
            measurements, holds = measure(evidence)
            name = measure.__name__
            return Claim(name, statement, tuple(measurements), ruling(*holds), depends_on)

        CLAIMS.append(evaluated)
        return evaluated

    return declare


ORDERS = range(2, 9)
"""Orders j of the rational waves Y_j whose `facts` are computed exactly."""

ROGUE_MODULI = (0.1, 0.3, 0.5, 0.7, 0.9, 0.99)
"""Moduli k at which the maximum of the cn rogue wave is searched for."""

LATE_TIME = 1e4
"""Slow time, long after the peak, at which the rational waves are evaluated."""

SEARCH_POINTS = 401
"""Points along each axis in a search for a maximum."""


@cache
def facts(order: int) -> RationalFacts:
    """Return the exact facts about the rational solution of that order."""
    return rational_facts(order)


@claim(
    "$Y_2$ and $Y_3$ have the maximum 5 and 7, $Y_j$ in general $2j+1$, at the origin",
    f"nothing: exact, for $j$ from {ORDERS[0]} to {ORDERS[-1]}",
)
def peaks(_: MeasuredRuns) -> ClaimEvidence:
    """Return the exact maximum of the rational wave of each order, which should be 2j + 1."""
    found = tuple(Measurement(f"$Y_{order}$", float(facts(order).peak)) for order in ORDERS)
    return found, (facts(order).peak == 2 * order + 1 for order in ORDERS)


@claim(
    "The denominator has two powers more than the numerator",
    "nothing: exact, in $X$, for the wave less its background",
)
def degrees(_: MeasuredRuns) -> ClaimEvidence:
    """Return how far the denominator's degree exceeds the numerator's; the claim is 2.

    The fractions are the rational waves Y_2 and Y_3 minus their backgrounds.
    """
    excess = {j: _excess(j) for j in (2, 3)}
    measurements = tuple(
        Measurement(f"$Y_{j}$: degree {facts(j).degree} over {facts(j).degree - excess[j]}, by", e)
        for j, e in excess.items()
    )
    return measurements, (e == 2 for e in excess.values())


def _excess(j: int) -> int:
    """Return the denominator's minus the numerator's degree in xi of rational wave ``j``.

    The background is subtracted from the wave first.
    """
    form = closed_form(f"rational_{j}")
    x = form.equation.xi
    above, below = sp.fraction(sp.cancel(form.expression - form.background))
    return int(sp.degree(below, x) - sp.degree(above, x))


@claim(
    "The rational waves are localised on the backgrounds $+1$ and $-1$: in space",
    "nothing: exact, at every fixed time",
)
def localised_in_space(_: MeasuredRuns) -> ClaimEvidence:
    """Return the far-field limits of the rational waves Y_2 and Y_3, which should be 1 and -1."""
    backgrounds = {j: facts(j).background for j in (2, 3)}
    measurements = [Measurement(f"$Y_{j}$, background", float(b)) for j, b in backgrounds.items()]
    return measurements, [backgrounds[2] == 1, backgrounds[3] == -1]


@claim(
    "The rational waves are localised (rogue waves): in time too",
    "nothing: extrema at distance 4 from the background persist and separate like $t^{1/3}$",
)
def localised_in_time(_: MeasuredRuns) -> ClaimEvidence:
    """Return the largest |Y - background| of the rational waves at `LATE_TIME`."""
    words = f"largest distance at $T={LATE_TIME:g}$"
    measurements = [Measurement(f"$Y_{j}$, {words}", _late_amplitude(j)) for j in (2, 3)]
    return measurements, (item.value < 0.1 for item in measurements)


def _late_amplitude(order: int) -> float:
    """Return max |Y - background| at `LATE_TIME`, searched where the extrema have moved."""
    wave = Wave(closed_form(f"rational_{order}"), mkdv_normal_form(K2=4, K4=1))
    a, b = (float(getattr(wave.normal_form, name)) for name in ("a", "b"))
    tau = b * LATE_TIME
    half_width = 4.0 * (12.0 * tau) ** (1.0 / 3.0)
    x = np.linspace(-half_width, half_width, 100 * SEARCH_POINTS)
    distance = wave((x + 6.0 * tau) / a, LATE_TIME).Y - (wave.constant_background or 0.0)
    return float(np.max(np.abs(distance)))


@claim("Higher-order rational solutions have larger maximum amplitudes", "nothing: exact")
def higher_orders(_: MeasuredRuns) -> ClaimEvidence:
    """Return the peak of the rational wave of highest order; peaks must grow with the order."""
    highest = ORDERS[-1]
    wave = Wave(rational(highest), mkdv_normal_form(K2=4, K4=1))
    peak = Measurement(f"$Y_{highest}$ at the origin", float(wave(0.0, 0.0).Y))
    return [peak], [all(facts(j).peak < facts(j + 1).peak for j in ORDERS[:-1])]


@claim(
    "The cn rogue wave has its global maximum at $(X,T)=(0,0)$",
    f"$k$; a search over {SEARCH_POINTS} by {SEARCH_POINTS} points of 8 wavelengths and $|tau|$ to "
    "40, and closer to the origin, finds nothing larger",
)
def rogue_maximum(_: MeasuredRuns) -> ClaimEvidence:
    """Return the cn rogue wave at the origin for each modulus; |Y| must not exceed this value."""
    measurements, holds = [], []
    for k in ROGUE_MODULI:
        peak, elsewhere = _rogue_search(k)
        measurements.append(Measurement(f"$k={k}$: at the origin, in units of $k$", peak / k))
        holds.append(elsewhere <= peak * (1 + 1e-12))
    return measurements, holds


def _rogue_search(k: float) -> tuple[float, float]:
    """Return the value of the cn rogue wave at the origin, and its largest |Y| on search grids."""
    wave = Wave(closed_form("rogue_cn"), mkdv_normal_form(K2=4, K4=1), k=k)
    a, b = (float(getattr(wave.normal_form, name)) for name in ("a", "b"))
    half_width = 4.0 * (wave.wavelength or 1.0)
    line = np.linspace(-1.0, 1.0, SEARCH_POINTS)
    largest = 0.0
    for x, t in ((half_width, 40.0 / b), (1.0 / a, 1.0 / b)):
        X, T = np.meshgrid(x * line, t * line)
        largest = max(largest, float(np.max(np.abs(wave(X, T).Y))))
    return float(wave(0.0, 0.0).Y), largest


TWENTY_PERCENT = 0.2
"""Largest relative error of "good agreement", as the paper's words are interpreted."""

RUN_ORDERS = (2, 3)
EPSILONS = ("0.05", "0.075")
"""Values of eps of the rational waves that are run (orders `RUN_ORDERS`), as in scene names."""


@claim(
    "$Y_2$ fits reasonably well at $eps=0.05$",
    "the time step, the crest's place in its cell (here on site 0); 'reasonably' is read as "
    "below 20 %",
)
def second_order_crest(evidence: MeasuredRuns) -> ClaimEvidence:
    """Return the error of the rational wave Y_2 at t = 0: by an accurate scheme, and by RK4."""
    names = {"": "rational_2_eps_0.05", f"RK4, $dt={RK4_STEP}$, ": rk4_name(2)}
    errors = {words: evidence.relative_error(name, 0.0) for words, name in names.items()}
    measurements = [Measurement(f"{words}$t=0$", *error) for words, error in errors.items()]
    return measurements, [errors[""].value < TWENTY_PERCENT]


@claim(
    "The error is largest around the time of the largest amplitude ($t=0$)",
    "$t_0$, $eps$; 'around' is read as within 10 % of the time shown",
)
def peak_of_the_error(evidence: MeasuredRuns) -> ClaimEvidence:
    """Return each rational run's largest error and its time; split the error of the run `SPLIT`."""
    measurements, near = [], []
    for j in RUN_ORDERS:
        for eps in EPSILONS:
            name = f"rational_{j}_eps_{eps}"
            largest, time = evidence.largest_error(name)
            scene = evidence.scenes[name]
            near.append(abs(time) < 0.1 * (scene.end - scene.t0))
            measurements.append(Measurement(f"$Y_{j}$, $eps={eps}$, at $t={time:.0f}$", *largest))
    measurements += _split(evidence)
    return measurements, near


def _split(evidence: MeasuredRuns) -> list[Measurement]:
    """Return the crest's shift in the run `SPLIT` at its peak, and the parts of the run's error."""
    parts = evidence.split(SPLIT, 0.0)
    words = "$Y_2$, $eps=0.05$, $t=0$, the lattice's wave is shifted by sites"
    shares = (Measurement(f"there, part by {name}", *parts[name]) for name in PARTS)
    return [Measurement(words, *parts["shift"]), *shares]


@claim(
    "The error is higher, the higher the order",
    "the time: it may hold for the largest error and not at every moment",
)
def error_against_order(evidence: MeasuredRuns) -> ClaimEvidence:
    """Return the largest errors of Y_2 and Y_3, and how often the error of Y_3 is higher."""
    measurements, always = [], []
    for eps in EPSILONS:
        names = [f"rational_{j}_eps_{eps}" for j in RUN_ORDERS]
        second, third = (evidence.runs[name]["error_curve"].values for name in names)
        higher = second < third
        errors = [evidence.largest_error(name)[0] for name in names]
        always += [errors[0].value < errors[1].value, bool(higher.all())]
        measurements += [
            Measurement(f"$eps={eps}$, $Y_{j}$, largest", *error)
            for j, error in zip(RUN_ORDERS, errors, strict=True)
        ]
        own_error = sum(error.error for error in errors)
        undecided = max(float((abs(third - second) <= own_error).mean()), 1.0 / higher.size)
        words = f"$eps={eps}$, % of the times at which $Y_3$ is higher"
        measurements.append(Measurement(words, 100 * float(higher.mean()), 100 * undecided))
    return measurements, always


@claim(
    "The error of $Y_3$ does not exceed 20 % at $eps=0.05$",
    "the time step, of which the paper states none",
)
def twenty_percent(evidence: MeasuredRuns) -> ClaimEvidence:
    """Return the rational wave Y_3's largest error at eps = 0.05: by an accurate scheme, by RK4."""
    names = {"": "rational_3_eps_0.05", f"RK4, $dt={RK4_STEP}$, ": rk4_name(3)}
    errors = {words: evidence.largest_error(name)[0] for words, name in names.items()}
    measurements = [Measurement(f"{words}largest", *error) for words, error in errors.items()]
    return measurements, (error.value < TWENTY_PERCENT for error in errors.values())


@claim(
    "Very good agreement of $Y_3$, at $eps=0.05$ and also at $0.075$",
    "$eps$, and what 'very good' means; here read as below 20 %",
)
def third_order_agreement(evidence: MeasuredRuns) -> ClaimEvidence:
    """Return the largest error of the rational wave Y_3 at each of `EPSILONS`."""
    measurements, good = [], []
    for eps in EPSILONS:
        largest, time = evidence.largest_error(f"rational_3_eps_{eps}")
        measurements.append(Measurement(f"$eps={eps}$, largest, at $t={time:.0f}$", *largest))
        good.append(largest.value < TWENTY_PERCENT)
    return measurements, good


BREATHER_MODULI = ("0.5", "0.6", "0.7")
ROGUE, SOLITON = "rogue_cn_k_0.5", "soliton_dn_k_0.7"
"""Names of the scenes of the cn rogue wave and of the soliton on the dn background."""


@claim(
    "On the sn background the agreement is better for larger $k$",
    "$alpha$ (here $K/2$), the time step",
)
def breather_and_modulus(evidence: MeasuredRuns) -> ClaimEvidence:
    """Return the dark breather's largest error at each of three elliptic moduli k."""
    errors = {k: evidence.largest_error(f"breather_sn_k_{k}")[0] for k in BREATHER_MODULI}
    falls = all(a.value > b.value for a, b in pairwise(errors.values()))
    return (Measurement(f"$k={k}$, largest", *error) for k, error in errors.items()), [falls]


@claim("The dn soliton fits very well", "$|t| <= 100$; 'very well' is read as below 20 %")
def dn_fit(evidence: MeasuredRuns) -> ClaimEvidence:
    """Return the error of the soliton on the dn background at the last snapshot.

    It is divided by the height of the bare wave, and by that of the far field.
    """
    end = evidence.scenes[SOLITON].end
    variables = {"bare wave": "error", "far field": "error_far_field"}
    errors = {w: evidence.relative_error(SOLITON, end, name) for w, name in variables.items()}
    measurements = [Measurement(f"$t={end:g}$, over the {w}", *e) for w, e in errors.items()]
    return measurements, [errors["bare wave"].value < TWENTY_PERCENT]


@claim(
    "On the cn background the lattice's maximum of $y_n/eps$ is always below the wave's",
    "the time; at $t_0$ the two are equal",
)
def cn_maximum(evidence: MeasuredRuns) -> ClaimEvidence:
    """Return the largest strain of lattice and wave on the cn background at the later snapshots."""
    measurements, below = [], []
    for time in evidence.scenes[ROGUE].snapshots[1:]:
        lattice, wave = evidence.peaks(ROGUE, time)
        below.append(lattice.value + lattice.error < wave)
        measurements += [
            Measurement(f"$t={time:g}$, lattice", *lattice),
            Measurement(f"$t={time:g}$, wave", wave),
        ]
    return measurements, below


@claim(
    "The deviations on the cn background can result from its modulational instability, the "
    "good fits on sn and dn from their stability",
    "the time shown, 200 units: read as a growth of the fastest perturbation by more than 2",
)
def modulational_instability(evidence: MeasuredRuns) -> ClaimEvidence:
    """Return how much the fastest perturbation of each background grows in the figure's time."""
    measurements = []
    for name in (ROGUE, SOLITON, "breather_sn_k_0.7"):
        scene = evidence.scenes[name]
        growth = math.exp(trust_in(scene, USUAL_TOLERANCE).rate * (scene.end - scene.t0))
        measurements.append(Measurement(f"{name.split('_')[1]} background, growth", growth))
    return measurements, [measurements[0].value > 2.0]


def all_claims(evidence: MeasuredRuns) -> list[Claim]:
    """Return every statement of `CLAIMS` with the numbers measured for it in these runs."""
    return [check(evidence) for check in CLAIMS]
