"""The lattice against the wave on the compared sites at one time, and the paper's error figure."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.model import Sites, State
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
        if not isinstance(array, np.ndarray) or array.dtype.kind not in "fiu":
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


@dataclass(frozen=True)
class View:
    """Strains of the run and of the wave on the compared sites; each is made when first used."""

    moving: "MovingWave"
    state: State

    @cached_property
    def sites(self) -> Sites:
        """The compared sites."""
        return self.moving.compared_sites(self.state.t)

    @cached_property
    def numeric(self) -> Array:
        """Strains of the run."""
        return self.state.strain(self.sites)

    @cached_property
    def analytic(self) -> Array:
        """Strains eps Y of the wave."""
        return self._strain(self.moving.wave.at(*self._place))

    @cached_property
    def background(self) -> Array:
        """Strains of the bare wave of the same phase."""
        return self._strain(self.moving.wave.background_at(*self._place))

    @cached_property
    def far_field(self) -> Array:
        """Strains of the wave's true far field: the left one behind c t, the right one ahead."""
        left = self._strain(self.moving.wave.far_field_at(*self._place, "left"))
        right = self._strain(self.moving.wave.far_field_at(*self._place, "right"))
        return np.where(np.arange(left.size) < self.moving.compared, left, right)

    def displaced(self, shift: float) -> tuple[Array, Array, Array, Array]:
        """Wave, background and their slopes in n, at n - ``shift`` for the compared sites n."""
        eps = self.moving.eps
        place = (self.sites - shift, self.state.t, eps)
        wave, background = self.moving.wave.at(*place), self.moving.wave.background_at(*place)
        slopes = eps**2 * wave.Y_X, eps**2 * background.Y_X
        return self._strain(wave), self._strain(background), *slopes

    @property
    def has_far_field(self) -> bool:
        """Whether there is a second denominator.

        There is none on a constant background, where it is the first one, and for a bare periodic
        wave, whose far field is the wave itself.
        """
        wave = self.moving.wave
        return wave.constant_background is None and not wave.numbers.is_bare

    @property
    def error(self) -> float:
        """Relative sup error against the bare background."""
        return relative_sup_error(self.numeric, self.analytic, self.background)

    @property
    def error_far_field(self) -> float:
        """Relative sup error against the true far field."""
        return relative_sup_error(self.numeric, self.analytic, self.far_field)

    @property
    def _place(self) -> tuple[Sites, float, float]:
        return self.sites, self.state.t, self.moving.eps

    def _strain(self, values: "WaveValues") -> Array:
        return self.moving.eps * values.Y
