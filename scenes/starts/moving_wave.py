"""Closed-form waves on the paper's chain: initial data, reference values, extent and bounds."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache, partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.seam import FADING_DEPTH, Fading, negate_at_seam
from longwave.lattice.state import Sites, State
from longwave.scenes.starts.initial_cells import InitialCells
from longwave.scenes.starts.lattice_wave import LatticeWave, nearest_cell
from longwave.scenes.starts.wave_extent import extent, sample_points, sampled_times, support_of
from longwave.solutions import NumericWave, Side, kept_data, kept_wave
from longwave.support.real_arrays import Array

if TYPE_CHECKING:
    from longwave.lattice.model import Model
    from longwave.scenes.description.scene import Scene
    from longwave.solutions import ClosedForm, Wave


FAR_FIELDS: tuple[Side, ...] = ("left", "right")

END_LEVEL = 1e-9
"""Deviation from the far fields, in units of eps, below which the wave counts as ended."""


@lru_cache(maxsize=8)
def moving_wave(scene: "Scene") -> "MovingWave":
    """Return the scene's wave on the paper's chain; ValueError for inadmissible parameters."""
    numbers = {
        name: value if isinstance(value, str) else float(value) for name, value in scene.parameters
    }
    wave = build_wave(scene.wave, scene.model, numbers)
    return MovingWave(wave, scene.model, scene.eps, (scene.t0, *scene.snapshots), scene.compared)


def build_wave(
    wave: "str | ClosedForm", constants: "Model", values: Mapping[str, float | str]
) -> NumericWave:
    """Return a closed form, given as an object or by name, with numeric parameters and constants.

    Raises ValueError for a parameter outside its domain, K3 != 0 and K4 of the wrong sign.
    """
    make = partial(_make_wave, wave, constants, values)
    if not isinstance(wave, str):
        return make()
    return kept_wave(__name__, f"{wave} {constants} {sorted(values.items())}", make)


def _make_wave(
    wave: "str | ClosedForm", constants: "Model", values: Mapping[str, float | str]
) -> "Wave":
    from longwave import derive
    from longwave.scenes.starts.lattice_derivation import exact_parameters
    from longwave.solutions import Wave, closed_form

    form = closed_form(wave, values) if isinstance(wave, str) else wave
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
"""Polynomial as a list of terms, each a coefficient with pairs (name, power) of its factors."""


@cache
def _initial_velocity() -> Polynomial:
    """Return dy/dt of the ansatz as a polynomial in Y_X, Y_T, c and eps."""
    return kept_data(__name__, "initial velocity", _derived_velocity)


def _derived_velocity() -> Polynomial:
    from longwave import derive

    terms = []
    for term in derive.initial_velocity().as_ordered_terms():
        coefficient, factors = term.as_coeff_mul()
        powers = (factor.as_base_exp() for factor in factors)
        terms.append((float(coefficient), [(base.name, int(power)) for base, power in powers]))
    return terms


def _value(polynomial: Polynomial, values: Mapping[str, "Array | float"]) -> Array:
    """Return the value of a polynomial, evaluated term by term, factors from the left."""
    first, *others = (
        math.prod((values[name] ** power for name, power in factors), start=coefficient)
        for coefficient, factors in polynomial
    )
    return np.asarray(sum(others, start=first), dtype=np.float64)


KINK_BLEND_WIDTHS = 40.0
"""Number of blended cells at either end of a kink's ring, in units of the kink's width."""


@dataclass(frozen=True)
class MovingWave(LatticeWave):
    """Closed-form wave on the paper's chain of strains, evaluated at sites to rounding accuracy.

    It starts at ``times[0]`` and is compared at the later ``times``, within ``compared`` sites of
    c t.  Raises ValueError if the times are not in increasing order.
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
        """Time of the initial data."""
        return self.times[0]

    @property
    def end(self) -> float:
        """Last time of the run."""
        return self.times[-1]

    @property
    def duration(self) -> float:
        """Duration of the run, from the first to the last of the ``times``."""
        return self.end - self.t0

    @property
    def level(self) -> float:
        """Strain of the constant background; 0 without one."""
        return self.eps * (self.wave.constant_background or 0.0)

    @property
    def name(self) -> str:
        """Name of the closed form."""
        return self.wave.numbers.name

    def amplifies_rounding(self, t: float) -> bool:
        """Return whether rounding errors may grow: true on a periodic background."""
        return self.wave.wavelength is not None

    @property
    def has_energy(self) -> bool:
        """True: the chain whose bonds have these strains has an energy."""
        return True

    @property
    def far_speed(self) -> float | None:
        """Speed of sound on a constant background; None without one."""
        is_constant = self.wave.constant_background is not None
        return self.constants.sound_speed(self.level) if is_constant else None

    @property
    def far_fastest(self) -> float:
        """Largest group velocity in the far field, the speed of sound."""
        return self.constants.sound_speed(self.level)

    @property
    def far_rates(self) -> tuple[Array, Array]:
        """Growth of the far field from cell to cell, and its velocity; both are 0 for strains."""
        return np.zeros(1), np.zeros(1)

    def compared_sites(self, t: float) -> Sites:
        """Return the sites within ``compared`` of c t; ValueError if too far for exact integers."""
        return nearest_cell(self.speed, t) + np.arange(-self.compared, self.compared + 1)

    def state(self, cells: ArrayLike, t: float) -> tuple[Array, Array]:
        """Return strain y_n = eps Y and its time derivative s_n at real sites, each (1, *sites)."""
        value = self.wave.at(cells, t, self.eps)
        values: dict[str, Array | float] = {"Y_X": value.Y_X, "Y_T": value.Y_T}
        values |= {"c": self.speed, "eps": self.eps}
        return self._scaled(value.Y), _value(_initial_velocity(), values)[np.newaxis]

    def strain(self, cells: ArrayLike, t: float) -> Array:
        """Return the strains eps Y of the wave, (1, *sites)."""
        return self._scaled(self.wave.value_at(cells, t, self.eps))

    def background(self, cells: ArrayLike, t: float) -> Array:
        """Return the strains of the bare wave of the same phase, (1, *sites)."""
        return self._scaled(self.wave.value_at(cells, t, self.eps, "background"))

    def far_field(self, sites: Sites, t: float) -> Array | None:
        """Return the strains of the true far fields on the sites.

        On the left half of the sites they are those of the left far field, else of the right one.

        None on a constant background, which equals the far field, and for a bare periodic wave,
        which is its own far field.
        """
        if self.wave.constant_background is not None or self.wave.numbers.is_bare:
            return None
        halves = zip(np.split(sites, [sites.size // 2]), FAR_FIELDS, strict=True)
        strains = [self._scaled(self.wave.value_at(n, t, self.eps, side)) for n, side in halves]
        return np.concatenate(strains, axis=1)

    def values_and_slopes(self, cells: Array, t: float) -> tuple[Array, Array, Array, Array]:
        """Return strains of wave and background, then the slopes of both from cell to cell."""
        wave, background = (
            at(cells, t, self.eps) for at in (self.wave.at, self.wave.background_at)
        )
        slopes = self.eps**2 * wave.Y_X, self.eps**2 * background.Y_X
        return self.eps * wave.Y, self.eps * background.Y, *slopes

    def quantity_values(self, f: ArrayLike, mean_strain: tuple[float, ...]) -> Array:
        """Return the compared quantities, which are the strains themselves."""
        return np.asanyarray(f, dtype=np.float64)

    def energy(self, lattice: NumericLattice, f: Array, v: Array) -> float:
        """Return the energy of the chain whose bonds have these strains (`Model.energy`)."""
        return self.constants.energy(State(0.0, f, v))

    def uniform(self) -> Array:
        """Return the strain of the constant background, (1,)."""
        return np.array([self.level])

    def strained_lattice(self, mean_strain: tuple[float, ...]) -> NumericLattice:
        """Return the lattice itself; a mean strain is part of its fields, the strains."""
        return self.lattice

    def support(self, t: float) -> tuple[float, float]:
        """Return the wave's first and last site at time t; infinite on a periodic background."""
        if self.wave.wavelength is not None:
            return -math.inf, math.inf
        x, deviation = _deviation(self.constants, self.wave, self.eps, t)
        low, high = support_of(x, deviation, END_LEVEL) or (0.0, 0.0)
        return self.speed * t + low, self.speed * t + high

    def extent(self, times: Sequence[float], tolerance: float) -> tuple[float, float]:
        """Return the ends of the wave relative to c t over all times; (inf, -inf) if it is flat."""
        key = self.constants, self.wave, self.eps, tuple(times)
        return extent([support_of(*profile, tolerance) for profile in _deviations(*key)])

    def stretch_range(self, times: Sequence[float]) -> Array:
        """Return the smallest and the largest strain of the wave over all times."""
        key = self.constants, self.wave, self.eps
        strains = [self.eps * _values(*key, t)[1] for t in sampled_times(tuple(times))]
        return np.array([min(map(np.min, strains)), max(map(np.max, strains))])

    def rigid_fields(self, offsets: Array, t: float) -> tuple[Array, Array]:
        """Return strains at offsets from c t, and their slopes from site to site, (1, sites)."""
        value = self.wave(self.eps * offsets, self.eps**3 * t)
        return self._scaled(value.Y), self.eps**2 * value.Y_X[np.newaxis]

    def seam_room(self, t: float) -> int:
        """Return the number of blended cells at either end: a wavelength, a kink's widths, or 0."""
        wave = self.wave
        if wave.constant_background is not None:
            return 0
        if wave.wavelength is not None:
            return math.ceil(wave.wavelength / self.eps)
        height = float(np.max(np.abs(wave.far_field(0.0, 0.0, "right").Y)))
        return math.ceil(KINK_BLEND_WIDTHS / (wave.numbers.a * self.eps * height))

    def closed_ring(self, ring: InitialCells, room: int) -> InitialCells:
        """Return the ring with its ends blended into each other within ``room`` sites of the seam.

        The far fields of a kink differ; its ring is closed by the kink's negative at the seam.
        """
        if not room or self.wave.wavelength is not None:
            return self.blended_ring(ring, room)
        size, t = ring.cells.size, ring.t
        middle = ring.cells[0] + 0.5 * size
        crest = round(self.wave.phase_zeros(t, self.eps)[0]) - middle

        def profile(x: Array) -> Array:
            return np.stack(self.state(x + middle, t))

        f, v = negate_at_seam(profile, float(size), crest, ring.cells - middle)
        return replace(ring, f=f, v=v)

    def fading(self, t: float, speed: float) -> Fading | None:
        """Return the damping of cells that signals of this speed from the seam reach.

        None for a ring without blending.
        """
        if not self.seam_room(t) or self.duration == 0.0:
            return None
        depth = max(float(FADING_DEPTH), (self.wave.wavelength or 0.0) / self.eps)
        return Fading(t, speed, self.level, depth)

    def _scaled(self, value: Array) -> Array:
        """Return values in units of eps as strains of one field, (1, *sites)."""
        return np.asarray(self.eps * value)[np.newaxis]


@dataclass(frozen=True)
class WaveBounds:
    """Interval ``low`` .. ``high``, in sites from c t, that contains wave and compared sites.

    ``strain`` holds the smallest and the largest strain of the wave at any time.
    """

    low: float
    high: float
    strain: Array

    @property
    def width(self) -> float:
        """Distance between the ends, in sites."""
        return self.high - self.low

    @property
    def middle(self) -> float:
        """Midpoint of the interval."""
        return 0.5 * (self.low + self.high)


def find_bounds(moving: MovingWave, tolerance: float) -> WaveBounds:
    """Return bounds that contain, at all times, the compared sites and the wave (`wave_extent`)."""
    low, high = moving.extent(moving.times, tolerance)
    edge = float(moving.compared)
    return WaveBounds(min(-edge, low), max(edge, high), moving.stretch_range(moving.times))


CACHED_TIMES = 256
"""Number of cached profiles, each of a wave at one time; enough for a few waves."""


@lru_cache(maxsize=4)
def _deviations(
    constants: "Model", wave: NumericWave, eps: float, times: tuple[float, ...]
) -> list[tuple[Array, Array]]:
    """Return `_deviation` at all `sampled_times`; cached, as several plans need it."""
    return [_deviation(constants, wave, eps, t) for t in sampled_times(times)]


def _deviation(constants: "Model", wave: NumericWave, eps: float, t: float) -> tuple[Array, Array]:
    """Return sorted positions relative to c t, and the distance of Y from the nearer far field."""
    x, value = _values(constants, wave, eps, t)
    cells = constants.sound_speed() * t + x
    left, right = (wave.value_at(cells, t, eps, side) for side in FAR_FIELDS)
    return x, np.minimum(np.abs(value - left), np.abs(value - right))


@lru_cache(maxsize=CACHED_TIMES)
def _values(constants: "Model", wave: NumericWave, eps: float, t: float) -> tuple[Array, Array]:
    """Return sorted positions relative to c t, dense enough to find the range of Y, and Y there."""
    origin = constants.sound_speed() * t
    zeros = wave.phase_zeros(t, eps) or [origin]
    x = sample_points([zero - origin for zero in zeros], 1.0 / (wave.numbers.a * eps))
    return x, wave.value_at(origin + x, t, eps)
