"""Random numbers by site: the same on every ring that contains the site, and on any machine.

They come from Philox (Salmon et al., SC11 (2011) 16), a generator that is a function of a key and a
counter and whose bits NumPy guarantees. No function whose last digit depends on a library, such as
the logarithm in normal numbers, is applied to them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from longwave.support.real_arrays import Array

DISTRIBUTIONS = ("uniform", "binary")
"""Distributions of deviations: uniform on -1 .. 1, or -1 and 1 with equal probability."""

SITE_OFFSET = 2**60
"""Offset that makes all site numbers positive."""

NUMBERS_PER_COUNTER = 4
"""Number of random numbers that the generator gives for one counter."""


def site_deviations(
    cells: ArrayLike, seed: int, row: int = 0, distribution: str = "uniform"
) -> Array:
    """Return a deviation between -1 and 1 for each of the given consecutive cells.

    ``row`` selects an independent sequence, for different quantities of a cell.

    >>> site_deviations([-1, 0, 1], seed=1).tolist() == [
    ...     *site_deviations([-1], seed=1), *site_deviations([0, 1], seed=1)]
    True
    >>> site_deviations([5, 6, 7, 8], seed=3, distribution="binary").tolist()
    [...]
    """
    sites = np.asarray(cells)
    if not sites.size:
        return np.zeros(0)
    first = int(sites[0]) + SITE_OFFSET
    block, skipped = divmod(first, NUMBERS_PER_COUNTER)
    generator = np.random.Philox(key=[seed, row], counter=[block, 0, 0, 0])
    bits = generator.random_raw(skipped + sites.size)[skipped:]
    if distribution == "binary":
        return np.where(bits >> np.uint64(63), 1.0, -1.0)
    return np.asarray((bits >> np.uint64(11)) * 2.0**-52 - (1.0 - 2.0**-53))


def mean_inverse(distribution: str, spread: float) -> float:
    """Return the mean of ``1/(1 + d)`` over deviations d of at most ``spread`` < 1.

    >>> mean_inverse("uniform", 0.0), round(mean_inverse("uniform", 0.3), 4)
    (1.0, 1.0317)
    """
    if distribution == "binary":
        return 1.0 / (1.0 - spread * spread)
    return float(np.arctanh(spread)) / spread if spread else 1.0
