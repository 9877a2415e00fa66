"""A wave that moves along the lattice: its initial data, where it is, and how large it becomes.

A plan must know before any step where the wave is. It is looked for on the whole line, not on the
compared sites alone: outwards from where its phases vanish, on a grid whose spacing grows with the
distance. A domain that holds the bounds holds the wave at all times, so nothing of it can come back
round a ring or be cut off by a window.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache, partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.lattice.state import Sites
from longwave.solutions import NumericWave, WaveValues, kept_data, kept_wave

if TYPE_CHECKING:
    from longwave.lattice.model import Model
    from longwave.solutions import ClosedForm, Wave

Array = NDArray[np.float64]

FARTHEST = 2.0**53
"""Sites are told apart by doubles."""


def build_wave(
    wave: "str | ClosedForm", constants: "Model", values: Mapping[str, float | str]
) -> NumericWave:
    """The wave of a closed form, or of the one of that name, on a lattice, with numbers in.

    Raises ValueError for a parameter outside its domain, K3 != 0 and K4 of the wrong sign for the
    wave's equation.
    """
    if not isinstance(wave, str):
        return _make_wave(wave, constants, values)
    make = partial(_make_named_wave, wave, constants, values)
    return kept_wave(__name__, f"{wave} {constants} {sorted(values.items())}", make)


def _make_named_wave(name: str, constants: "Model", values: Mapping[str, float | str]) -> "Wave":
    from longwave.solutions import closed_form

    return _make_wave(closed_form(name, values), constants, values)


def _make_wave(form: "ClosedForm", constants: "Model", values: Mapping[str, float | str]) -> "Wave":
    from longwave import derive
    from longwave.scenes.starts.lattice_derivation import exact_parameters
    from longwave.solutions import Wave

    if constants.K3 != 0:
        raise ValueError(
            f"K3 must be 0 for an mKdV wave, got {constants.K3:g} "
            "(order eps^4 of the reduction reads K3 (Y^2)_XX = 0)"
        )
    if form.equation.normal == "mKdV" and constants.K4 * form.equation.s <= 0:
        sign = ">" if form.equation.s > 0 else "<"
        raise ValueError(
            f"K4 must satisfy K4 {sign} 0 for {form.name}, got {constants.K4:g} "
            f"(it solves the {form.equation.name} equation)"
        )
    exact = exact_parameters(tuple(values.items()))
    return Wave(form, derive.mkdv_normal_form(constants.K2, constants.K4), **exact)


Polynomial = list[tuple[float, list[tuple[str, int]]]]
"""Terms: a coefficient, and the factors with their powers."""


@cache
def _initial_velocity() -> Polynomial:
    """dy/dt of the ansatz as a polynomial in Y_X, Y_T, c and eps."""
    return kept_data(__name__, "initial velocity", _derived_velocity)


def _derived_velocity() -> Polynomial:
    from longwave import derive

    found = []
    for term in derive.initial_velocity().as_ordered_terms():
        coefficient, factors = term.as_coeff_mul()
        powers = (factor.as_base_exp() for factor in factors)
        found.append((float(coefficient), [(base.name, int(power)) for base, power in powers]))
    return found


def _value(polynomial: Polynomial, values: Mapping[str, "Array | float"]) -> Array:
    """Its value, term by term and factor by factor from the left."""
    terms = [
        math.prod((values[name] ** power for name, power in factors), start=coefficient)
        for coefficient, factors in polynomial
    ]
    total = sum(terms[1:], start=terms[0])
    return np.asarray(total, dtype=np.float64)


@dataclass(frozen=True)
class MovingWave:
    """A wave on the lattice from ``times[0]`` on, compared within ``compared`` sites of c t.

    The later ``times`` are those that count, in order. Raises ValueError if they are not in order.
    """

    wave: NumericWave
    constants: "Model"
    eps: float
    times: tuple[float, ...]
    compared: int

    def __post_init__(self) -> None:
        if len(self.times) < 2 or sorted(self.times) != list(self.times):
            raise ValueError(f"times must increase from t0 on, got {self.times} (sort them)")

    @property
    def t0(self) -> float:
        """The time of the initial data."""
        return self.times[0]

    @property
    def end(self) -> float:
        """The last time."""
        return self.times[-1]

    @property
    def duration(self) -> float:
        """The time from the first to the last."""
        return self.end - self.t0

    @cached_property
    def speed(self) -> float:
        """The speed c of long waves."""
        return self.constants.sound_speed()

    @property
    def level(self) -> float:
        """Strain of the constant background, 0 on a periodic one."""
        return self.eps * (self.wave.constant_background or 0.0)

    def frame(self, t: float) -> int:
        """The site nearest to c t, the middle of what is compared; ValueError if too far."""
        place = self.speed * t + 0.5
        if not abs(place) < FARTHEST:
            raise ValueError(f"t must leave c t within 2^53 sites, got t = {t:g}")
        return math.floor(place)

    def compared_sites(self, t: float) -> Sites:
        """The sites within ``compared`` of c t."""
        return self.frame(t) + np.arange(-self.compared, self.compared + 1)

    def initial_data(self, sites: ArrayLike) -> tuple[Array, Array]:
        """Strain y_n = eps Y and velocity s_n of the ansatz at the sites (any real), at time t0."""
        return self._data(self.wave.at(sites, self.t0, self.eps), self.speed)

    def rigid_offsets(self, speed: float, sites: Sites, t: float) -> Array:
        """Sites at time t, from the place that began at c t0 and moves at ``speed``."""
        begin = self.speed * self.t0
        return np.asarray((sites - begin) - speed * (t - self.t0), dtype=np.float64)

    def rigid_data(self, speed: float, offsets: ArrayLike) -> tuple[Array, Array]:
        """Strain and velocity of the initial strain that moves rigidly at ``speed``.

        Far from the crest, on a constant background, this is what the lattice itself does with the
        wave's algebraic tail, which is long and weak; ``speed`` is the sound speed there,
        ``offsets`` are as `rigid_offsets` gives them.
        """
        X = self.eps * np.asarray(offsets, dtype=np.float64)
        value = self.wave(X, self.eps**3 * self.t0)
        return self._data(value._replace(Y_T=np.zeros_like(X)), speed)

    def _data(self, value: WaveValues, c: float) -> tuple[Array, Array]:
        """Strain and velocity of the ansatz at speed c where the wave has the given values."""
        return self.eps * value.Y, _value(
            _initial_velocity(), {"Y_X": value.Y_X, "Y_T": value.Y_T, "c": c, "eps": self.eps}
        )


TIMES = 17
"""Equidistant times at which the wave is looked at, beside the snapshots (as many at most)."""

DISTANCES = np.concatenate([np.linspace(0.0, 1.0, 21)[:-1], np.geomspace(1.0, 1e5, 360)])
"""Distances from the zero of a phase, in units of the wave's variable xi; they grow by 3.2 %."""

LEVEL = 0.01
"""Deviation from the far field below which there is no wave, in units of the tolerance."""

CREST_SHARE = 0.05
"""The same in units of the largest deviation, for waves that decay like a power."""

POWER = 0.05
"""What is left of the deviation at twice the distance, at least, where it decays like a power."""

DRIFT_SHARE = 0.1
"""The lattice's wave may run this share of its drift against c t ahead of the closed form."""


@dataclass(frozen=True)
class WaveBounds:
    """Sites relative to c t that hold wave and compared sites, from ``low`` to ``high``.

    ``strain`` holds the smallest and the largest strain of the wave at any time.
    """

    low: float
    high: float
    strain: Array

    @property
    def width(self) -> float:
        """Number of sites between the ends."""
        return self.high - self.low

    @property
    def middle(self) -> float:
        """Half-way between the ends."""
        return 0.5 * (self.low + self.high)

    @property
    def reach(self) -> int:
        """The farther end's distance from c t."""
        return int(np.ceil(max(-self.low, self.high)))


def find_bounds(moving: MovingWave, tolerance: float) -> WaveBounds:
    """The bounds of compared sites and wave at all times from the first to the last.

    The wave is where y/eps deviates from its far fields by more than a share of ``tolerance``, or,
    if it decays like a power, by more than a share of its largest deviation: the rest is a matter
    of the domain's size.
    """
    ends, strain = _wave_at_all_times(
        moving.constants, moving.wave, moving.eps, moving.times, tolerance
    )
    edge = float(moving.compared)
    return WaveBounds(min(-edge, ends[0]), max(edge, ends[1]), strain)


@lru_cache(maxsize=4)
def _wave_at_all_times(
    constants: "Model", wave: NumericWave, eps: float, times: tuple[float, ...], tolerance: float
) -> tuple[tuple[float, float], Array]:
    """The wave's ends, infinitely far inside out if nothing rises, and its extreme strains.

    Whatever is chosen about a scene asks for it: the engine, the scout and the runs themselves.
    """
    places = [_places(constants, wave, eps, t) for t in _watched(times)]
    supports = [_support(x, deviation, LEVEL * tolerance) for x, deviation, _ in places]
    ends = [support for support in supports if support is not None]
    low, high = np.inf, -np.inf
    if ends:
        lows, highs = np.array(ends).T
        low = float(lows.min()) - DRIFT_SHARE * float(np.ptp(lows))
        high = float(highs.max()) + DRIFT_SHARE * float(np.ptp(highs))
    strains = [eps * value for _, _, value in places]
    least = min(float(strain.min()) for strain in strains)
    extremes = np.array([least, max(float(strain.max()) for strain in strains)])
    extremes.flags.writeable = False
    return (low, high), extremes


def _watched(times: Sequence[float]) -> list[float]:
    """Equidistant times, some of those given, and the crest's."""
    t0, end = times[0], times[-1]
    crest = {0.0} if t0 < 0.0 < end else set()
    some = times[:: max(1, len(times) // TIMES)]
    return sorted({*np.linspace(t0, end, TIMES).tolist(), *some, *crest})


def _places(
    constants: "Model", wave: NumericWave, eps: float, t: float
) -> tuple[Array, Array, Array]:
    """Positions relative to c t in order, the deviation from the far fields there, and Y."""
    origin = constants.sound_speed() * t
    unit = 1.0 / (wave.numbers.a * eps)
    offsets = unit * np.concatenate([-DISTANCES[:0:-1], DISTANCES])
    zeros = wave.phase_zeros(t, eps) or [origin]
    x = np.unique(np.concatenate([zero - origin + offsets for zero in zeros]))
    value = wave.at(origin + x, t, eps).Y
    left, right = (wave.far_field_at(origin + x, t, eps, side).Y for side in ("left", "right"))
    deviation = np.minimum(np.abs(value - left), np.abs(value - right))
    return x, deviation, value


def _support(x: Array, deviation: Array, level: float) -> tuple[float, float] | None:
    """The ends of what rises above the level, None if nothing does."""
    largest = float(deviation.max())
    if largest <= level:
        return None
    inside = np.flatnonzero(deviation > level)
    first, last = int(inside[0]), int(inside[-1])
    if _decays_like_a_power(x, deviation, first) or _decays_like_a_power(x, deviation, last):
        inside = np.flatnonzero(deviation > max(level, CREST_SHARE * largest))
        first, last = int(inside[0]), int(inside[-1])
    step = 1 if last + 1 < x.size else 0
    return float(x[max(first - 1, 0)]), float(x[last + step])


def _decays_like_a_power(x: Array, deviation: Array, index: int) -> bool:
    """Whether what is beyond the end at ``index`` falls slowly."""
    crest = float(x[int(np.argmax(deviation))])
    if index in (0, x.size - 1):
        return True
    beyond = crest + 2.0 * (x[index] - crest)
    rest = x >= beyond if x[index] > crest else x <= beyond
    return not rest.any() or float(np.max(deviation[rest])) > POWER * float(deviation[index])
