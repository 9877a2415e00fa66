"""View of lattice and wave on the compared cells at one time, and the paper's relative error."""

from abc import ABC, abstractmethod
from typing import Any

import numpy as np

from longwave.lattice.state import Sites, State
from longwave.support.real_arrays import Array
from longwave.support.user_files import shown


def relative_sup_error(numeric: Array, analytic: Array, background: Array) -> float:
    """Return max |analytic - numeric| / max |analytic - background| over the compared sites.

    All three are strains at the same integer sites. If ``background`` is the bare periodic wave of
    the same phase, this is the paper's eq. (16). If it is the wave's true far field, this is the
    second error reported on periodic backgrounds. A sup over sites depends on where between two
    sites the crest is; in the paper's scenes it is on site 0.

    Raises ValueError if shapes differ, no site is compared, a value is not finite, or the wave
    equals its background.

    >>> relative_sup_error(np.array([1.0, 4.5]), np.array([1.0, 5.0]), np.array([1.0, 1.0]))
    0.125
    """
    for array in (numeric, analytic, background):
        is_real = isinstance(array, np.ndarray) and array.dtype.kind in "fiu"
        if not is_real or np.ma.is_masked(array):
            raise ValueError(
                f"compared arrays must be NumPy arrays of real numbers, got {shown(array)} "
                "(convert with np.asarray)"
            )
    if not numeric.shape == analytic.shape == background.shape:
        shapes = f"{numeric.shape}, {analytic.shape}, {background.shape}"
        raise ValueError(f"compared arrays must have one shape, got {shapes} (take the same sites)")
    if numeric.size == 0:
        raise ValueError("compared arrays must not be empty, got none (compare at least one site)")
    deviation = float(np.max(np.abs(analytic - numeric)))
    amplitude = float(np.max(np.abs(analytic - background)))
    if not (np.isfinite(deviation) and np.isfinite(amplitude)):
        raise ValueError(
            "the compared strains must be finite, got NaN or infinity (did the run blow up?)"
        )
    if amplitude == 0.0:
        raise ValueError(
            "background must differ from the wave at some site, got the wave itself "
            "(the relative error divides by their difference)"
        )
    return deviation / amplitude


class View(ABC):
    """Lattice and wave on the compared cells at one time, evaluated lazily."""

    state: State

    @property
    def t(self) -> float:
        """Time of the state."""
        return self.state.t

    @property
    @abstractmethod
    def level(self) -> float:
        """Uniform value of the first compared quantity, on which the wave is superposed."""

    @property
    @abstractmethod
    def travelled(self) -> float:
        """Distance that the wave's frame has travelled from the origin, in sites."""

    @property
    @abstractmethod
    def sites(self) -> Sites:
        """Compared sites along the first axis."""

    @property
    @abstractmethod
    def numerics(self) -> Array:
        """Compared quantities of the run, (quantities, *sites)."""

    @property
    @abstractmethod
    def analytics(self) -> Array:
        """Compared quantities of the wave, (quantities, *sites)."""

    @property
    @abstractmethod
    def backgrounds(self) -> Array:
        """Compared quantities of the bare wave of the same phase, (quantities, *sites)."""

    @property
    def numeric(self) -> Array:
        """First compared quantity of the run, such as its strains."""
        return np.asanyarray(self.numerics[0])

    @property
    def analytic(self) -> Array:
        """First compared quantity of the wave."""
        return np.asanyarray(self.analytics[0])

    @property
    def background(self) -> Array:
        """First compared quantity of the bare wave of the same phase."""
        return np.asanyarray(self.backgrounds[0])

    @property
    def crest_law(self) -> float | None:
        """Height of a damped soliton's crest by its amplitude law; None for other waves."""
        return None

    @property
    def far_field(self) -> Array | None:
        """Strains of the wave's true far field; None if it equals the background."""
        return None

    @property
    def extra_variables(self) -> dict[str, Any]:
        """Further variables, by name, that `observables.strain` records; none unless overridden."""
        return {}

    @abstractmethod
    def displaced(self, shift: float) -> tuple[Array, Array, Array, Array]:
        """Return wave, background and their n-derivatives, all at n - ``shift`` for compared n."""

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
        """Leftmost computed site, and copies of positions and velocities of all sites."""

    @property
    def error(self) -> float:
        """Relative sup error against the bare background."""
        return relative_sup_error(self.numerics, self.analytics, self.backgrounds)

    @property
    def error_far_field(self) -> float:
        """Relative sup error against the true far field, which must not be None."""
        assert self.far_field is not None
        return relative_sup_error(self.numeric, self.analytic, self.far_field)
