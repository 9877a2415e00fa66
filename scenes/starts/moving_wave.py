"""A wave that moves along the lattice: its initial data, where it is, and how large it becomes."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache, partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.seam import FADING_DEPTH, Fading, negate_at_seam
from longwave.lattice.state import Sites, State
from longwave.scenes.starts.initial_cells import InitialCells
from longwave.scenes.starts.lattice_wave import LatticeWave, nearest_cell
from longwave.scenes.starts.wave_extent import extent, places_about, support_of, watched_times
from longwave.solutions import NumericWave, Side, kept_data, kept_wave

if TYPE_CHECKING:
    from longwave.lattice.model import Model
    from longwave.scenes.description.scene import Scene
    from longwave.solutions import ClosedForm, Wave

Array = NDArray[np.float64]

FAR_FIELDS: tuple[Side, ...] = ("left", "right")

FLAT = 1e-9
"""A wave has ended where it deviates from its far fields by less, in units of eps."""


@lru_cache(maxsize=8)
def moving_wave(scene: "Scene") -> "MovingWave":
    """Return the scene's wave on the paper's chain; ValueError for what it does not admit.

    What asks for the wave alone finds it in ``moving_wave(scene).wave``.
    """
    numbers = {
        name: value if isinstance(value, str) else float(value) for name, value in scene.parameters
    }
    wave = build_wave(scene.wave, scene.model, numbers)
    return MovingWave(wave, scene.model, scene.eps, (scene.t0, *scene.snapshots), scene.compared)


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


KINK = 40.0
"""Room for a kink at either end of a ring, in units of its width."""


@dataclass(frozen=True)
class MovingWave(LatticeWave):
    """A closed form on the chain of strains from ``times[0]`` on, at sites to the last digit.

    It is compared within ``compared`` sites of c t, at the later ``times``, in order.  Raises
    ValueError if they are not in order.
    """

    order, power, slow = "leading", 1, 3
    watches_strains = True

    wave: NumericWave
    constants: "Model"
    eps: float
    times: tuple[float, ...]
    compared: int
    lattice: NumericLattice = field(init=False, repr=False, compare=False)
    speed: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if len(self.times) < 2 or sorted(self.times) != list(self.times):
            raise ValueError(f"times must increase from t0 on, got {self.times} (sort them)")
        object.__setattr__(self, "lattice", self.constants.lattice)
        object.__setattr__(self, "speed", self.constants.sound_speed())

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

    @property
    def level(self) -> float:
        """Strain of the constant background, 0 on a periodic one."""
        return self.eps * (self.wave.constant_background or 0.0)

    @property
    def name(self) -> str:
        """The closed form's."""
        return self.wave.numbers.name

    def amplifies_rounding(self, t: float) -> bool:
        """Whether the background is periodic."""
        return self.wave.wavelength is not None

    @property
    def has_energy(self) -> bool:
        """It has one, of the chain whose bonds are strained so."""
        return True

    @property
    def far_speed(self) -> float | None:
        """The speed of sound on a constant background; None on another."""
        is_constant = self.wave.constant_background is not None
        return self.constants.sound_speed(self.level) if is_constant else None

    @property
    def far_fastest(self) -> float:
        """The same: long waves are the fastest."""
        return self.constants.sound_speed(self.level)

    @property
    def far_rates(self) -> tuple[Array, Array]:
        """None: strains are constant far from the wave."""
        return np.zeros(1), np.zeros(1)

    def frame(self, t: float) -> int:
        """The site nearest to c t, the middle of what is compared; ValueError if too far."""
        return nearest_cell(self.speed, t)

    def compared_sites(self, t: float) -> Sites:
        """The sites within ``compared`` of c t."""
        return self.frame(t) + np.arange(-self.compared, self.compared + 1)

    def state(self, cells: ArrayLike, t: float) -> tuple[Array, Array]:
        """Strain y_n = eps Y and velocity s_n of the ansatz at the sites (any real), at time t."""
        value = self.wave.at(cells, t, self.eps)
        velocity = _value(
            _initial_velocity(),
            {"Y_X": value.Y_X, "Y_T": value.Y_T, "c": self.speed, "eps": self.eps},
        )
        return self._scaled(value.Y), velocity[np.newaxis]

    def strain(self, cells: ArrayLike, t: float) -> Array:
        """Strains eps Y."""
        return self._scaled(self.wave.value_at(cells, t, self.eps))

    def background(self, cells: ArrayLike, t: float) -> Array:
        """Strains of the bare wave of the same phase."""
        return self._scaled(self.wave.value_at(cells, t, self.eps, "background"))

    def far_field(self, sites: Sites, t: float) -> Array | None:
        """Strains of the left far field behind the middle of the sites, of the right one ahead.

        None on a constant background, where it is the first denominator, and for a bare periodic
        wave, whose far field is the wave itself.
        """
        if self.wave.constant_background is not None or self.wave.numbers.is_bare:
            return None
        behind, ahead = np.split(sites, [sites.size // 2])
        left = self._scaled(self.wave.value_at(behind, t, self.eps, "left"))
        right = self._scaled(self.wave.value_at(ahead, t, self.eps, "right"))
        return np.concatenate([left, right], axis=1)

    def displaced(self, cells: Array, t: float) -> tuple[Array, Array, Array, Array]:
        """Wave and background, then their slopes from cell to cell."""
        wave, background = (
            at(cells, t, self.eps) for at in (self.wave.at, self.wave.background_at)
        )
        slopes = self.eps**2 * wave.Y_X, self.eps**2 * background.Y_X
        return self.eps * wave.Y, self.eps * background.Y, *slopes

    def measured(self, f: ArrayLike, mean_strain: tuple[float, ...]) -> Array:
        """The strains."""
        return np.asanyarray(f, dtype=np.float64)

    def energy(self, lattice: NumericLattice, f: Array, v: Array) -> float:
        """That of the chain whose bonds are strained so (`lattice.Model.energy`)."""
        return self.constants.energy(State(0.0, f, v))

    def uniform(self) -> Array:
        """The constant background."""
        return np.array([self.level])

    def strained(self, mean_strain: tuple[float, ...]) -> NumericLattice:
        """The lattice itself: its strains are what moves."""
        return self.lattice

    def support(self, t: float) -> tuple[float, float]:
        """The sites between which there is a wave; infinite on a periodic background."""
        if self.wave.wavelength is not None:
            return -math.inf, math.inf
        x, deviation = _deviation(self.constants, self.wave, self.eps, t)
        low, high = support_of(x, deviation, FLAT) or (0.0, 0.0)
        return self.speed * t + low, self.speed * t + high

    def extent(self, times: Sequence[float], tolerance: float) -> tuple[float, float]:
        """Sites from c t between which the wave deviates; infinitely far inside out if nowhere."""
        key = self.constants, self.wave, self.eps, tuple(times)
        return extent([support_of(*place, tolerance) for place in _deviations(*key)])

    def stretch_range(self, times: Sequence[float]) -> Array:
        """The least and the largest strain of the wave at any time."""
        values = (
            _values(self.constants, self.wave, self.eps, t)[1] for t in watched_times(tuple(times))
        )
        strains = [self.eps * value for value in values]
        return np.array([min(map(np.min, strains)), max(map(np.max, strains))])

    def rigid(self, offsets: Array, t: float) -> tuple[Array, Array]:
        """Strains in the frame at time t, and their slopes from site to site (fields, sites)."""
        value = self.wave(self.eps * offsets, self.eps**3 * t)
        return self._scaled(value.Y), self.eps**2 * value.Y_X[np.newaxis]

    def seam_room(self, t: float) -> int:
        """A wavelength of a periodic background, many widths of a kink; 0 on a constant one."""
        wave = self.wave
        if wave.constant_background is not None:
            return 0
        if wave.wavelength is not None:
            return math.ceil(wave.wavelength / self.eps)
        height = float(np.max(np.abs(wave.far_field(0.0, 0.0, "right").Y)))
        return math.ceil(KINK / (wave.numbers.a * self.eps * height))

    def closed(self, ring: InitialCells, room: int) -> InitialCells:
        """The ring with ends that pass into each other within ``room`` sites of the seam.

        Those of a kink, whose far fields differ, pass into the kink's negative at the seam.
        """
        if not room or self.wave.wavelength is not None:
            return self.blended(ring, room)
        size, t = ring.cells.size, ring.t
        middle = ring.cells[0] + 0.5 * size
        crest = round(self.wave.phase_zeros(t, self.eps)[0]) - middle

        def profile(x: Array) -> Array:
            return np.stack(self.state(x + middle, t))

        f, v = negate_at_seam(profile, float(size), crest, ring.cells - middle)
        return replace(ring, f=f, v=v)

    def fading(self, t: float, speed: float) -> Fading | None:
        """What draws a closed ring to rest where the seam's signals, of that speed, have come."""
        if not self.seam_room(t) or self.duration == 0.0:
            return None
        depth = max(float(FADING_DEPTH), (self.wave.wavelength or 0.0) / self.eps)
        return Fading(t, speed, self.level, depth)

    def _scaled(self, value: Array) -> Array:
        """Strains of one field, which a wave's values are in units of eps."""
        return np.asarray(self.eps * value)[np.newaxis]


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


def find_bounds(moving: MovingWave, tolerance: float) -> WaveBounds:
    """The bounds of compared sites and wave (`wave_extent`) at all times from first to last."""
    low, high = moving.extent(moving.times, tolerance)
    edge = float(moving.compared)
    return WaveBounds(min(-edge, low), max(edge, high), moving.stretch_range(moving.times))


WATCHED = 256
"""Times whose values are kept: those at which a few waves are watched."""


@lru_cache(maxsize=4)
def _deviations(
    constants: "Model", wave: NumericWave, eps: float, times: tuple[float, ...]
) -> list[tuple[Array, Array]]:
    """Return `_deviation` at the times at which a wave is watched; every plan asks for them."""
    return [_deviation(constants, wave, eps, t) for t in watched_times(times)]


def _deviation(constants: "Model", wave: NumericWave, eps: float, t: float) -> tuple[Array, Array]:
    """Return positions relative to c t in order, and the deviation from the far fields there."""
    x, value = _values(constants, wave, eps, t)
    cells = constants.sound_speed() * t + x
    left, right = (wave.value_at(cells, t, eps, side) for side in FAR_FIELDS)
    return x, np.minimum(np.abs(value - left), np.abs(value - right))


@lru_cache(maxsize=WATCHED)
def _values(constants: "Model", wave: NumericWave, eps: float, t: float) -> tuple[Array, Array]:
    """Return positions relative to c t in order, and Y there: all that a range of strains needs."""
    origin = constants.sound_speed() * t
    zeros = wave.phase_zeros(t, eps) or [origin]
    x = places_about([zero - origin for zero in zeros], 1.0 / (wave.numbers.a * eps))
    return x, wave.value_at(origin + x, t, eps)
