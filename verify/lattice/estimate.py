"""Estimated errors of a run, in units of y/eps, sup over the compared sites."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from verify.lattice.cost import CostModel, fit_cost


@dataclass(frozen=True)
class Estimate:
    """What the discretisation is estimated to change y/eps by, at most, against the exact flow.

    ``time`` is the time step's part, ``space`` the domain's (and the sampling's, where the engine
    samples). ``next_decade`` is the factor by which ten times more accuracy costs more.
    """

    time: float
    space: float
    next_decade: float

    @property
    def total(self) -> float:
        """Both parts."""
        return self.time + self.space


def richardson(difference: float, ratio: float, order: float) -> float:
    """Error of the coarser of two results whose steps have the ratio ``ratio`` < 1.

    >>> richardson(1.0 - 0.5**6, 0.5, 6)
    1.0
    """
    return float(difference / (1.0 - ratio**order))


def fitted_cost(steps: Sequence[float], errors: Sequence[float], order: float) -> CostModel:
    """error = scale * (1/step)^-order: fitted if there are two errors, else of the given order.

    A fit that finds no convergence (rounding) falls back on the given order.

    >>> round(fitted_cost([0.4, 0.2], [64e-6, 1e-6], 8).order, 9)
    6.0
    """
    pairs = [(1.0 / step, error) for step, error in zip(steps, errors, strict=True) if error > 0]
    if len(pairs) > 1:
        try:
            return fit_cost(*zip(*pairs, strict=True))
        except ValueError:
            pass
    cost, error = pairs[-1] if pairs else (1.0, math.ulp(1.0))
    return CostModel(error * cost**order, order)
