"""The lattice against the wave on the compared cells at one time, and the paper's error figure."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.state import Sites, State
from longwave.support.user_files import shown

if TYPE_CHECKING:
    from longwave.scenes.chain.moving_wave import MovingWave
    from longwave.solutions import WaveValues

Array = NDArray[np.float64]


def relative_sup_error(numeric: Array, analytic: Array, background: Array) -> float:
    """max |analytic - numeric| / max |analytic - background| over the compared sites.

    All three are strains at the same integer sites. With the bare wave of the same phase as
    ``background`` this is the paper's eq. (16); with the wave's true far field it is the second
    figure for waves on periodic backgrounds. A sup over sites depends on where the crest falls
    between them: the paper's scenes have it on site 0.

    Raises ValueError if shapes differ, no site is compared, a value is not finite, or the wave is
    its own background.

    >>> relative_sup_error(np.array([1.0, 4.5]), np.array([1.0, 5.0]), np.array([1.0, 1.0]))
    0.125
    """
    for array in (numeric, analytic, background):
        is_real = isinstance(array, np.ndarray) and array.dtype.kind in "fiu"
        if not is_real or np.ma.is_masked(array):
            raise ValueError(
                f"compared arrays must be NumPy's, of real numbers, got {shown(array)} "
                "(np.asarray makes one)"
            )
    if not numeric.shape == analytic.shape == background.shape:
        shapes = f"{numeric.shape}, {analytic.shape}, {background.shape}"
        raise ValueError(f"compared arrays must have one shape, got {shapes} (take the same sites)")
    if numeric.size == 0:
        raise ValueError("compared arrays must hold a site, got none (compare at least one)")
    deviation = float(np.max(np.abs(analytic - numeric)))
    amplitude = float(np.max(np.abs(analytic - background)))
    if not (np.isfinite(deviation) and np.isfinite(amplitude)):
        raise ValueError(
            "the compared strains must be finite, got NaN or infinity (did the run blow up?)"
        )
    if amplitude == 0.0:
        raise ValueError(
            "background must differ from the wave at some site, got the wave itself "
            "(a bare wave has no relative error)"
        )
    return deviation / amplitude


class View(ABC):
    """Lattice and wave on the compared cells at one time; each is made when first used."""

    state: State

    @property
    def t(self) -> float:
        """The time."""
        return self.state.t

    @property
    @abstractmethod
    def level(self) -> float:
        """The uniform value of what is compared, to which the wave is added."""

    @property
    @abstractmethod
    def travelled(self) -> float:
        """Sites that the frame has gone from the origin."""

    @property
    @abstractmethod
    def sites(self) -> Sites:
        """The compared sites, along the first axis."""

    @property
    @abstractmethod
    def numerics(self) -> Array:
        """All quantities of the run that are compared, (quantities, *sites)."""

    @property
    @abstractmethod
    def analytics(self) -> Array:
        """The same of the wave."""

    @property
    @abstractmethod
    def backgrounds(self) -> Array:
        """The same of the bare wave of the same phase."""

    @property
    def numeric(self) -> Array:
        """The first quantity of the run, such as its strains."""
        return np.asanyarray(self.numerics[0])

    @property
    def analytic(self) -> Array:
        """The same of the wave."""
        return np.asanyarray(self.analytics[0])

    @property
    def background(self) -> Array:
        """The same of the bare wave of the same phase."""
        return np.asanyarray(self.backgrounds[0])

    @property
    def crest_law(self) -> float | None:
        """What losses leave of a soliton's crest by their law; None without one."""
        return None

    @property
    def far_field(self) -> Array | None:
        """Strains of the wave's true far field, if there is a second denominator."""
        return None

    @property
    def also(self) -> dict[str, Any]:
        """Variables that are told with the strains; none unless overridden."""
        return {}

    @abstractmethod
    def displaced(self, shift: float) -> tuple[Array, Array, Array, Array]:
        """Wave, background and their slopes in n, at n - ``shift`` for the compared sites n."""

    @property
    @abstractmethod
    def energy(self) -> float:
        """Kinetic and potential energy of the ring."""

    @property
    @abstractmethod
    def means(self) -> tuple[float, float]:
        """Mean strain and mean velocity of the ring."""

    @property
    @abstractmethod
    def stored(self) -> tuple[int, Array, Array]:
        """The leftmost site that is held, and copies of positions and velocities of all sites."""

    @property
    def is_background(self) -> bool:
        """Whether the wave is its own background on all compared sites."""
        return np.array_equal(self.analytics, self.backgrounds)

    @property
    def error(self) -> float:
        """Relative sup error against the bare background."""
        return relative_sup_error(self.numerics, self.analytics, self.backgrounds)

    @property
    def error_far_field(self) -> float:
        """Relative sup error against the true far field, where there is one."""
        assert self.far_field is not None
        return relative_sup_error(self.numeric, self.analytic, self.far_field)


@dataclass(frozen=True)
class SiteView(View):
    """A wave on the paper's chain, seen at the sites of a state."""

    moving: MovingWave
    state: State

    @property
    def level(self) -> float:
        """The constant background."""
        return self.moving.level

    @property
    def travelled(self) -> float:
        """At the speed of long waves."""
        return self.moving.speed * self.state.t

    @property
    def energy(self) -> float:
        """That of the chain whose bonds are strained by y (`lattice.Model.energy`)."""
        return self.moving.constants.energy(self.state)

    @property
    def means(self) -> tuple[float, float]:
        """Of strains and their velocities."""
        return float(np.mean(self.state.f)), float(np.mean(self.state.v))

    @property
    def stored(self) -> tuple[int, Array, Array]:
        """In the order of storage."""
        return self.state.left, self.state.f[0].copy(), self.state.v[0].copy()

    @cached_property
    def sites(self) -> Sites:
        """The compared sites."""
        return self.moving.compared_sites(self.state.t)

    @cached_property
    def numerics(self) -> Array:
        """Strains of the run."""
        return self.state.at(self.sites)[0]

    @cached_property
    def analytics(self) -> Array:
        """Strains eps Y of the wave."""
        return self._strain(self.moving.wave.at(*self._place))[np.newaxis]

    @cached_property
    def backgrounds(self) -> Array:
        """Strains of the bare wave of the same phase."""
        return self._strain(self.moving.wave.background_at(*self._place))[np.newaxis]

    @cached_property
    def far_field(self) -> Array | None:
        """Strains of the wave's true far field: the left one behind c t, the right one ahead.

        None on a constant background, where it is the first denominator, and for a bare periodic
        wave, whose far field is the wave itself.
        """
        wave = self.moving.wave
        if wave.constant_background is not None or wave.numbers.is_bare:
            return None
        sites, t, eps = self._place
        behind, ahead = np.split(sites, [self.moving.compared])
        left = self._strain(wave.far_field_at(behind, t, eps, "left"))
        right = self._strain(wave.far_field_at(ahead, t, eps, "right"))
        return np.concatenate([left, right])

    def displaced(self, shift: float) -> tuple[Array, Array, Array, Array]:
        """Wave, background and their slopes in n, at n - ``shift`` for the compared sites n."""
        eps = self.moving.eps
        place = (self.sites - shift, self.state.t, eps)
        wave, background = self.moving.wave.at(*place), self.moving.wave.background_at(*place)
        slopes = eps**2 * wave.Y_X, eps**2 * background.Y_X
        return self._strain(wave), self._strain(background), *slopes

    @property
    def _place(self) -> tuple[Sites, float, float]:
        return self.sites, self.state.t, self.moving.eps

    def _strain(self, values: WaveValues) -> Array:
        return self.moving.eps * values.Y
