"""Accuracy of the evaluation: worst errors of Y, Y_X, Y_T over the stated domain.

``all_cases`` has the ends of every parameter's domain at ordinary constants, and cases drawn from
the whole domain: k and every other bounded parameter down to 1e-8 from one end and 1e-12 from the
other, amplitudes from 1e-3 to 1e3, K2 and |K4| from 1e-4 to 1e4, eps from 1e-3 to 1/2, sites to
1e8, four of them at the corners of K2 and K4; rational solutions up to order 8 with and without
free shifts. Waves of equations other than mKdV use the scales of the same lattice, with reversed
time and h = -K4.

Points are (site, time, eps), as in a lattice run: crests, the smallest values of each of the
three, zeros of Y_T to the last bit of the site, steep slopes, far tails and random ones. Errors
are in units of max(1, |value|). The reference is mpmath at 60 digits: it evaluates the canonical
expression, with differences for derivatives, and doubles its digits until two results agree.
"""

import random
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from longwave.derive import NormalForm, mkdv_normal_form
from longwave.solutions import CATALOGUE, ClosedForm, Wave, closed_form, rational
from longwave.support.known_names import one_of
from longwave.support.processes import Job, Key

Array = NDArray[np.float64]


def _rationals(text: str) -> tuple[sp.Rational, ...]:
    return tuple(map(sp.Rational, text.split()))


_SOLITONS = {
    "breather p q X_0": "1e-8 1 1/3; 1/2 2 1/3; 2 2 0; 2 1/2 0; 1/2 1e-8 1/3; 3 40 0",
    "double_pole A X_0": "1e-8 1/3; 1 1/3; 2 0; 40 0",
    "two_soliton A_1 A_2 X_0": "1 1e-8 1/3; 2 1/2 1/3; 1 0.99999999 0; 1 0.999999999999 0; "
    "2 0.999999999999 0; 40 39 0",
    "soliton_background U_0 kappa": "1 1e-8; -1 1e-8; 0 2; -1 2; 1 2; -1e-8 1; -40 3; 3 40",
    "kink_antikink A kappa": "1 1e-8; 1 1; 2 3; 1 1.999999999998; 2 3.999999999999999999999996; "
    "40 41",
    "kdv_soliton kappa": "1e-3; 1; 1000",
    "kdv_two_soliton kappa_1 kappa_2 X_0": "1 1e-8 1/3; 2 1/2 1/3; 1 0.99999999 0; "
    "1 0.999999999999 0; 2 0.999999999999 0; 40 39 0",
    "gardner_soliton kappa": "1e-8; 1; 40",
    "gardner_negative_soliton kappa": "1e-8; 1; 40",
    "gardner_table_soliton kappa": "1e-8; 1/2; 0.99999999; 0.999999999999",
    "kdv_burgers_shock U_0": "0; -1/25; 40",
    "mkdv_burgers_shock kappa": "1e-8; 1/6; 1; 40",
    "kp_line_soliton kappa q": "1e-3 0; 1 1/3; 1 -40; 40 3",
    "kp_lump kappa q": "1e-3 0; 1 0; 1 1/3; 40 -3; 1000 0",
    "nls_plane A q": "1 0; 2 1/3; 40 -40",
    "nls_bright A v": "1 0; 1e-3 1; 2 1/3; 40 40",
    "nls_dark kappa v": "1 0; 1e-3 1; 2 1/3; 40 -40",
    "nls_akhmediev a": "1e-8; 1/8; 1/4; 0.49999999; 0.4999999999995",
    "nls_kuznetsov_ma a": "0.5000000000005; 0.50000001; 1; 40; 1000",
}
"""Wave and names of its parameters -> cases separated by ";", for waves without a modulus. Values
are at the ends of the domains, and between."""

SOLITON_VALUES: dict[str, tuple[tuple[tuple[str, sp.Rational], ...], ...]] = {
    name: tuple(tuple(zip(names, _rationals(row), strict=True)) for row in rows.split(";"))
    for (name, *names), rows in ((head.split(), rows) for head, rows in _SOLITONS.items())
}
"""Wave -> its cases in `_SOLITONS`; a case is a tuple of (parameter name, exact value) pairs."""


MODULI = _rationals("1e-8 1/100 1/2 9/10 99/100 0.9999 0.99999999 0.999999999999")
ALPHA_OVER_K = _rationals("1e-8 1/2 0.99999999")
AMPLITUDES = _rationals("1/1000 1/10 1 3/2 10 40 1000")
LARGEST_ORDER = 8
SHIFTS = _rationals("-7/3 11/2")

TIMES = (0, 2960, 800_000, 80_000_000, -80_000_000)
"""Lattice times t of the points; at eps = 1/20 they are T = 0, 0.37, 100, 1e4 and -1e4."""

DRAWN = 24
"""Default number of random cases for each wave."""

FARTHEST_SITE = 1e8
SMALLEST, BELOW_ONE = 1e-8, 1e-12
LEAST, LARGEST = 1e-3, 1e3
WEAKEST, STRONGEST = 1e-4, 1e4
FINEST, COARSEST = 1e-3, 0.5

CORNERS: tuple[tuple[sp.Rational, sp.Rational, sp.Rational], ...] = tuple(
    (sp.Rational(str(K2)), sp.Rational(str(K4)), sp.Rational(str(eps)))
    for K2, K4, eps in (
        (WEAKEST, STRONGEST, COARSEST),
        (STRONGEST, WEAKEST, FINEST),
        (WEAKEST, WEAKEST, COARSEST),
        (STRONGEST, STRONGEST, COARSEST),
    )
)
"""Extreme combinations (K2, K4, eps); with the first, phases reach 1e19 and more at late times."""

USUAL_EPS = sp.Rational(1, 20)

Values = tuple[tuple[str, sp.Expr], ...]


@cache
def _rational(order: int, *free: int) -> ClosedForm:
    return rational(order, free)


@dataclass(frozen=True)
class WaveCase:
    """A wave, by name (``rational_j`` for any j), with exact parameter values.

    ``K4`` is an absolute value: its sign is that of the wave's equation.
    """

    name: str
    parameters: Values = ()
    K2: sp.Rational | None = None
    K4: sp.Rational = sp.S.One
    eps: sp.Rational = USUAL_EPS
    times: tuple[float, ...] = TIMES

    @property
    def form(self) -> ClosedForm:
        """Closed form of the wave; a rational solution has only the shifts that the case sets."""
        if self.name in CATALOGUE.names:
            return closed_form(self.name)
        order = int(self.name.removeprefix("rational_"))
        return _rational(order, *(int(name.removeprefix("tau_")) for name, _ in self.parameters))

    @property
    def normal_form(self) -> NormalForm:
        """Normal form; by default K2 = 4 for the focusing waves and K2 = 1 for the others."""
        equation, sign = self.form.equation, self.sign
        K2 = (4 if sign > 0 else 1) if self.K2 is None else self.K2
        normal_form = mkdv_normal_form(K2=K2, K4=sign * self.K4)
        if equation.normal == "mKdV":
            return normal_form
        transverse_scale = normal_form.a if equation.has_across else sp.S.Zero
        further = equation.normal, -self.K4, transverse_scale, equation.r
        return NormalForm(normal_form.a, -normal_form.b, sp.Integer(sign), normal_form.c, *further)

    @property
    def sign(self) -> int:
        """Sign of K4, which is that of the equation; 1 if the equation allows both."""
        return 1 if self.form.equation.free_sign else int(self.form.equation.s)

    def wave(self) -> Wave:
        """Return the wave with the case's numbers."""
        return Wave(self.form, self.normal_form, **dict(self.parameters))

    def __str__(self) -> str:
        settings = self.parameters
        if self.K2 is not None:
            settings += (("K2", self.K2), ("K4", self.sign * self.K4), ("eps", self.eps))
        return ", ".join(f"{name} = {_short(value)}" for name, value in settings)


def wave_names() -> list[str]:
    """Return the catalogue's names and those of the rational solutions of higher order."""
    higher = range(4, LARGEST_ORDER + 1)
    return list(CATALOGUE.names) + [f"rational_{order}" for order in higher]


def all_cases(name: str, drawn: int = DRAWN) -> Iterator[WaveCase]:
    """Yield the cases of one wave: ends of domains, then ``drawn`` random ones.

    >>> [str(case) for case in all_cases("kink")][:3]
    ['A = 0.001', 'A = 0.1', 'A = 1']

    Raises ValueError for a name that is no wave of this study.
    """
    if name not in wave_names():
        raise ValueError(f"name must be a wave, got {name!r} ({one_of(name, wave_names())})")
    parameters = [parameter.name for parameter in WaveCase(name).form.parameters]
    if name in SOLITON_VALUES:
        yield from (WaveCase(name, values) for values in SOLITON_VALUES[name])
    elif not parameters:
        yield WaveCase(name)
    elif "k" in parameters:
        yield from _with_modulus(name, "alpha" in parameters)
    else:
        yield from (WaveCase(name, (("A", value),)) for value in AMPLITUDES)
    if name.startswith("rational_") and (order := int(name.removeprefix("rational_"))) > 3:
        yield WaveCase(name, _shifts(order))
    yield from drawn_cases(name, drawn)


def drawn_cases(name: str, count: int, seed: int = 1) -> Iterator[WaveCase]:
    """Yield random cases of one wave from the whole domain, the second to fifth at ``CORNERS``.

    >>> [str(case) for case in drawn_cases("kink", 1)]
    ['A = 24.02, K2 = 0.8219, K4 = -73.21, eps = 0.006092']
    """
    rng = random.Random(f"{name} {seed}")
    for index in range(count):
        values = _random_values(name, rng)
        K2, K4 = (_logarithmic(rng, WEAKEST, STRONGEST) for _ in range(2))
        eps = _logarithmic(rng, FINEST, COARSEST)
        if 0 < index <= len(CORNERS):
            K2, K4, eps = CORNERS[index - 1]
        latest = FARTHEST_SITE / float(sp.sqrt(K2))
        random_time = rng.choice((-1, 1)) * float(_logarithmic(rng, 1e-6 * latest, latest))
        yield WaveCase(name, values, K2, K4, eps, (0, random_time, -latest))


def _random_values(name: str, rng: random.Random) -> Values:
    values: dict[sp.Symbol, sp.Expr] = {}
    for parameter in WaveCase(name).form.parameters:
        lower = parameter.lower.value if parameter.lower is not None else sp.S.Zero
        if parameter.upper is not None:
            value = parameter.upper.value.xreplace(values) * _between(rng)
        elif lower > 0:
            value = lower + _logarithmic(rng, SMALLEST, LARGEST)
        else:
            value = _logarithmic(rng, LEAST, LARGEST)
            value *= 1 if parameter.lower is not None else rng.choice((-1, 1))
        values[parameter.symbol] = value
    return tuple((symbol.name, value) for symbol, value in values.items())


def _between(rng: random.Random) -> sp.Rational:
    """Return a random number between 0 and 1: near 0, near 1 or uniform, equally often."""
    near_end = rng.choice((None, SMALLEST, BELOW_ONE))
    if near_end is None:
        return sp.Rational(rng.randrange(1, 10**6), 10**6)
    part = _logarithmic(rng, near_end, 0.5)
    return part if near_end == SMALLEST else 1 - part


def _logarithmic(rng: random.Random, low: float, high: float) -> sp.Rational:
    """Return a random rational number of six digits, uniform in its logarithm."""
    return sp.Rational(f"{low * (high / low) ** rng.random():.5e}")


def _with_modulus(name: str, with_alpha: bool) -> Iterator[WaveCase]:
    for modulus in MODULI:
        if not with_alpha:
            yield WaveCase(name, (("k", modulus),))
            continue
        for part in ALPHA_OVER_K:
            alpha = part * sp.elliptic_k(modulus**2)
            yield WaveCase(name, (("k", modulus), ("alpha", alpha), ("X_0", sp.Rational(1, 3))))


def _shifts(order: int) -> Values:
    free: Mapping[int, sp.Expr] = {5: SHIFTS[0], 2 * order - 1: SHIFTS[1]}
    return tuple((f"tau_{index}", value) for index, value in free.items())


def _short(value: sp.Expr) -> str:
    """Format a number with a few digits; a number near 1 is written as "1 - distance"."""
    near = 1 - value
    if value != 1 and abs(near) < sp.Rational(1, 1000):
        return f"1 - {float(near):.3g}"
    return f"{float(value):.4g}"


PROMISED_ERROR = 1e-13
"""Promised bound on the errors of Y, Y_X, Y_T, in units of max(1, |value|)."""

REFERENCE_DIGITS = 60
WIDTHS = (4.0, 60.0)
"""Half-widths, in units of xi, of the intervals around each centre that are searched for points."""

CASE_SECONDS = {False: 0.2, True: 2.0}
"""Whether the background is periodic (the reference values are then elliptic functions) ->
expected seconds of a case."""

GRID = 2001
BISECTIONS = 60


@dataclass(frozen=True)
class Accuracy:
    """Largest errors of a wave Y, of Y_X and Y_T; ``worst`` describes the point of the largest."""

    name: str
    points: int
    errors: tuple[float, float, float]
    worst: str

    @property
    def passed(self) -> bool:
        """Whether every error is within the promised bound; False for NaN."""
        return all(error <= PROMISED_ERROR for error in self.errors)

    def json(self) -> dict[str, object]:
        """Return the record as JSON data."""
        errors = dict(zip(("Y", "Y_X", "Y_T"), self.errors, strict=True))
        return {"wave": self.name, "points": self.points, "errors": errors, "worst": self.worst}


def measure_accuracy(
    case: WaveCase, times: Iterable[float] | None = None, per_time: int = 9, grid: int = GRID
) -> Accuracy:
    """Return the worst errors of one case at ``per_time`` points for each lattice time.

    The points are chosen among ``grid`` sites on each scale in `WIDTHS` around each centre.
    ``times`` default to those of the case.

    Raises FloatingPointError if NumPy meets an overflow, a division by zero or a NaN.
    """
    wave, eps = case.wave(), float(case.eps)
    rng = np.random.default_rng(1)
    worst, worst_point, count = np.zeros(3), "", 0
    with np.errstate(over="raise", divide="raise", invalid="raise"):
        for t in case.times if times is None else times:
            transverse_site = _random_transverse_site(wave, rng)
            for n in sample_sites(wave, t, eps, rng, grid, **transverse_site)[:per_time]:
                errors = errors_at(wave, n, t, eps, **transverse_site)
                if not np.max(errors) <= np.max(worst):
                    transverse = "".join(f", m = {m!r}" for m in transverse_site.values())
                    worst_point = f"{case} n = {n!r}, t = {t:.12g}{transverse}".strip()
                worst = np.maximum(worst, errors)
                count += 1
    return Accuracy(case.name, count, _three(worst), worst_point)


def _random_transverse_site(wave: Wave, rng: np.random.Generator) -> dict[str, float]:
    """Return a random site on the transverse axis, near or far; empty if the wave has none."""
    if not wave.numbers.is_planar:
        return {}
    return {"m": float(rng.normal(scale=rng.choice((1.0, 1e3, FARTHEST_SITE))))}


def sample_sites(
    wave: Wave, t: float, eps: float, rng: np.random.Generator, grid: int, **transverse_site: float
) -> list[float]:
    """Choose sites: zero of Y_T, smallest |Y_X| and |Y|, crest, steepest slope, random and far.

    The search uses a grid around every point where a phase of the wave vanishes.
    """
    rate = float(wave.normal_form.a) * eps
    centre = float(wave.normal_form.c) * t
    zeros = wave.phase_zeros(t, eps, **transverse_site)
    centres = [centre, *(zero for zero in zeros if abs(zero) <= 2 * FARTHEST_SITE)]
    sharpest = max(1.0, *(abs(float(value)) for value in wave.parameters.values()), 1.0)
    widths = [width / rate / scale for width in WIDTHS for scale in {1.0, sharpest}]
    offsets = np.concatenate([width * np.linspace(-1, 1, grid) for width in widths])
    sites = np.concatenate([centre_of_grid + offsets for centre_of_grid in centres])
    values = [np.abs(part) for part in wave.at(sites, t, eps, **transverse_site)]
    zero_of_rate = _last_zero(wave, t, eps, np.sort(sites), **transverse_site)
    value, slope, rate_of_change = values[:3]
    chosen = np.argmin(slope), np.argmax(rate_of_change), np.argmin(value), np.argmax(value)
    near = float(rng.choice(sites))
    scattered = near, float(round(near)), centre + float(rng.normal(scale=1e3 / rate))
    far = FARTHEST_SITE * (-1.0) ** rng.integers(2)
    return [zero_of_rate, *(float(sites[i]) for i in chosen), *scattered, float(far)]


def _last_zero(wave: Wave, t: float, eps: float, sites: Array, **transverse_site: float) -> float:
    """Return the site, to the last bit, where Y_T changes sign, or the smallest |Y_T| if none does.
    A complex Y_T is replaced by its real part."""
    rates = wave.at(sites, t, eps, **transverse_site).Y_T.real
    turns = np.flatnonzero(rates[1:] * np.sign(rates[:-1]) < 0)
    if turns.size == 0:
        return float(sites[np.argmin(abs(rates))])
    turn = turns[turns.size // 2]
    low, high, sign = float(sites[turn]), float(sites[turn + 1]), np.sign(rates[turn])
    for _ in range(BISECTIONS):
        middle = low + (high - low) / 2
        if np.sign(wave.at(middle, t, eps, **transverse_site).Y_T.real) == sign:
            low = middle
        else:
            high = middle
    return low


def errors_at(wave: Wave, n: float, t: float, eps: float, **transverse_site: float) -> Array:
    """Return the errors of Y, Y_X, Y_T at one site and time, in units of max(1, |value|).

    The error of Y_Z is included in that of Y_X. Real and imaginary part are compared separately.
    """
    exact = wave.mp_at(n, t, eps, REFERENCE_DIGITS, **transverse_site)
    computed = wave.at(n, t, eps, **transverse_site)
    errors = [_error(value, reference) for value, reference in zip(computed, exact, strict=True)]
    return np.array([errors[0], max(errors[1], *errors[3:], 0.0), errors[2]])


def _error(value: Any, exact: Any) -> float:
    pairs = ((float(value.real), exact.real), (float(value.imag), exact.imag))
    return max(float(abs(v - r) / max(1, abs(r))) for v, r in pairs)


def worst_of(results: Iterable[Accuracy]) -> Accuracy:
    """Merge the records of one wave into one record with the largest errors."""
    all_results = list(results)
    largest_error = max(all_results, key=lambda result: max(result.errors))
    errors = np.max([result.errors for result in all_results], axis=0)
    count = sum(result.points for result in all_results)
    return Accuracy(largest_error.name, count, _three(errors), largest_error.worst)


def _three(errors: Array) -> tuple[float, float, float]:
    return float(errors[0]), float(errors[1]), float(errors[2])


def accuracy_jobs(full: bool) -> dict[Key, Job]:
    """Return the jobs of every wave; the short report takes three cases of each at a few points."""
    jobs: dict[Key, Job] = {}
    for name in wave_names():
        cases = list(all_cases(name))
        if full:
            for case in cases:
                seconds = CASE_SECONDS[case.form.period is not None]
                jobs["accuracy", case] = Job(measure_accuracy, (case,), seconds)
        else:
            for case in dict.fromkeys((cases[0], cases[len(cases) // 2], cases[-1])):
                jobs["accuracy", case] = Job(measure_accuracy, (case, case.times[::3], 4, 401), 0.5)
    return jobs
