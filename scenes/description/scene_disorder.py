"""Disorder of a scene: deviations of masses or of a constant of the springs from cell to cell.

[disorder]
of = "mass"                 # all masses, or a constant of the springs, such as "K2"
spread = 0.1                # the largest deviation: m (1 + d) with |d| <= 0.1
seed = 1                    # of the realisation, the same on every ring
distribution = "uniform"    # or "binary": d is -spread or spread
sites = [0, 999]            # the first and the last cell that deviate; default: all
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from longwave.lattice.random_sites import DISTRIBUTIONS, site_deviations
from longwave.scenes.description import scene_checks as check
from longwave.support.real_arrays import Array
from longwave.support.user_files import shown

MASS = "mass"
"""Value of `Disorder.of` if masses deviate."""

FARTHEST_CELL = 2**53
"""Largest cell number up to which all whole numbers are exact doubles."""

LARGEST_SEED = 2**63 - 1


@dataclass(frozen=True)
class Disorder:
    """Deviations of a lattice's masses, or of one constant of its springs, from cell to cell.

    ``of``: "mass" or the constant's name. ``spread``: the largest relative deviation.
    ``distribution``: one of `DISTRIBUTIONS`. ``sites``: the first and the last cell that deviate,
    None for all. Raises ValueError for other values.

    >>> Disorder("K2", 0.1, seed=1, sites=(0, 9)).deviations([-1, 0, 1]).round(3)
    array([ 0.   , -0.04 , -0.092])
    """

    of: str
    spread: float
    seed: int
    distribution: str = "uniform"
    sites: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        check.text("of in [disorder]", self.of)
        spread = check.finite("spread in [disorder]", self.spread)
        if not 0.0 <= spread < 1.0:
            raise ValueError(
                f"spread in [disorder] must satisfy 0 <= spread < 1, got {spread:g} (it is the "
                "largest deviation as a share: with 1 a mass or a spring may vanish)"
            )
        object.__setattr__(self, "spread", spread)
        object.__setattr__(
            self, "seed", check.whole("seed in [disorder]", self.seed, 0, LARGEST_SEED)
        )
        check.one_of("distribution in [disorder]", self.distribution, DISTRIBUTIONS)
        if self.sites is not None:
            object.__setattr__(self, "sites", _ends(self.sites))

    @classmethod
    def of_pairs(cls, given: object) -> Disorder:
        """Return the disorder from a record, or from names and values as a mapping or pairs."""
        if isinstance(given, Disorder):
            return given
        values = dict(check.as_pairs("disorder", given, '{"of": "mass", "spread": 0.1, "seed": 1}'))
        check.refuse_unknown(values, [field.name for field in fields(cls)], " in [disorder]")
        for name in ("of", "spread", "seed"):
            if name not in values:
                raise ValueError(f"{name} in [disorder] must be stated, got nothing (state it)")
        return cls(**values)

    @property
    def pairs(self) -> tuple[tuple[str, Any], ...]:
        """Names and values in the form that `of_pairs` reads, without default values."""
        defaults = {field.name: field.default for field in fields(self)}
        values = ((name, getattr(self, name)) for name in defaults)
        return tuple((name, value) for name, value in values if value != defaults[name])

    def deviations(self, cells: ArrayLike, row: int = 0) -> Array:
        """Return relative deviations of consecutive cells, independent for each ``row``."""
        n = np.asarray(cells)
        deviations = self.spread * site_deviations(n, self.seed, row, self.distribution)
        if self.sites is None:
            return deviations
        return np.asarray(deviations * ((n >= self.sites[0]) & (n <= self.sites[1])))


def _ends(given: object) -> tuple[int, int]:
    """Return the first and the last deviating cell, checked; ValueError for other values."""
    if not isinstance(given, Sequence) or isinstance(given, str) or len(given) != 2:
        raise ValueError(
            f"sites in [disorder] must be the first and the last cell that deviate, got "
            f"{shown(given)} (such as [0, 999])"
        )
    ends = -FARTHEST_CELL, FARTHEST_CELL
    first, last = (check.whole("sites in [disorder]", cell, *ends) for cell in given)
    if first > last:
        raise ValueError(
            f"sites in [disorder] must have first <= last, got {first} and {last} (swap them)"
        )
    return first, last
