"""What accuracy costs: a power law fitted to measured runs.

Near its asymptotic range a scheme's error falls like step^order, and its cost grows like 1/step.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class CostModel:
    """error = scale * cost^-order, ``cost`` in any unit (seconds, force evaluations)."""

    scale: float
    order: float

    def cost(self, error: float) -> float:
        """The cost of an error.

        >>> round(CostModel(1.0, 2.0).cost(1e-4), 6)
        100.0
        """
        return float((self.scale / error) ** (1.0 / self.order))

    @property
    def next_decade(self) -> float:
        """The factor by which ten times more accuracy costs more.

        >>> CostModel(1.0, 1.0).next_decade
        10.0
        """
        return float(10.0 ** (1.0 / self.order))


def fit_cost(costs: Sequence[float], errors: Sequence[float]) -> CostModel:
    """The power law through at least two runs (least squares of the logarithms).

    Raises ValueError for fewer than two runs, values that are not positive and errors that do not
    fall with the cost.

    >>> round(fit_cost([1, 2, 4], [1e-2, 1e-2 / 64, 1e-2 / 4096]).order, 9)
    6.0
    """
    if len(costs) != len(errors) or len(costs) < 2:
        raise ValueError(f"costs must hold at least two runs, got {len(costs)} (run once more)")
    if min(*costs, *errors) <= 0:
        least = min(*costs, *errors)
        raise ValueError(f"costs and errors must be positive, got {least:g} (leave out exact runs)")
    slope, level = np.polyfit(np.log(costs), np.log(errors), 1)
    if not slope < 0:
        raise ValueError(
            f"errors must fall with the cost, got the exponent {slope:.2g} "
            "(leave out runs that rounding governs)"
        )
    return CostModel(math.exp(level), -float(slope))
