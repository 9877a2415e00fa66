"""A wave that moves along the lattice: its initial data, where it is, and how large it becomes."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache, partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.lattice.state import Sites
from longwave.scenes.starts.wave_extent import extent, places_about, support_of, watched_times
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

    @property
    def name(self) -> str:
        """The closed form's."""
        return self.wave.numbers.name

    @property
    def scale(self) -> float:
        """The unit of errors."""
        return self.eps

    @cached_property
    def fastest(self) -> float:
        """The speed of sound on the constant background."""
        return self.constants.sound_speed(self.level)

    @property
    def background_speed(self) -> float | None:
        """The same, at which the far field runs; None on a periodic background."""
        return None if self.wave.constant_background is None else self.fastest

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

    def uniform(self, sites: Sites, t: float) -> float:
        """Nothing: strains move as a whole."""
        return 0.0

    def _data(self, value: WaveValues, c: float) -> tuple[Array, Array]:
        """Strain and velocity of the ansatz at speed c where the wave has the given values."""
        return self.eps * value.Y, _value(
            _initial_velocity(), {"Y_X": value.Y_X, "Y_T": value.Y_T, "c": c, "eps": self.eps}
        )


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
    """The bounds of compared sites and wave (`wave_extent`) at all times from first to last."""
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
    places = [_places(constants, wave, eps, t) for t in watched_times(times)]
    ends = extent([support_of(x, deviation, tolerance) for x, deviation, _ in places])
    strains = [eps * value for _, _, value in places]
    least = min(float(strain.min()) for strain in strains)
    extremes = np.array([least, max(float(strain.max()) for strain in strains)])
    extremes.flags.writeable = False
    return ends, extremes


def _places(
    constants: "Model", wave: NumericWave, eps: float, t: float
) -> tuple[Array, Array, Array]:
    """Positions relative to c t in order, the deviation from the far fields there, and Y."""
    origin = constants.sound_speed() * t
    zeros = wave.phase_zeros(t, eps) or [origin]
    x = places_about([zero - origin for zero in zeros], 1.0 / (wave.numbers.a * eps))
    value = wave.at(origin + x, t, eps).Y
    left, right = (wave.far_field_at(origin + x, t, eps, side).Y for side in ("left", "right"))
    deviation = np.minimum(np.abs(value - left), np.abs(value - right))
    return x, deviation, value
