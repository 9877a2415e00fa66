"""What the spectral engine is asked for, and what it gives back."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lattice.model import Model
from lattice.trial import Choices, Estimate
from solutions import Wave

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SpectralTask:
    """What is to be run: a wave from ``t0``, seen at ``times`` within ``compared`` sites of c t.

    ``tolerance`` is the wanted sup error of y/eps there against the infinite lattice started from
    the same data. ``times`` increase and do not lie before t0. ``most_work`` is the most that the
    next runs may ever take, in points times their log2 times evaluations.
    """

    constants: Model
    wave: Wave
    eps: float
    t0: float
    times: tuple[float, ...]
    compared: int
    tolerance: float
    most_work: float = math.inf

    def __post_init__(self) -> None:
        if not self.tolerance > 0:
            raise ValueError(
                f"tolerance must satisfy tolerance > 0, got {self.tolerance:g} (1e-4 is usual)"
            )
        if not self.times or self.times[0] < self.t0 or sorted(self.times) != list(self.times):
            raise ValueError(
                f"times must increase from t0 = {self.t0:g}, got {self.times} (sort them)"
            )

    def sites(self, t: float) -> NDArray[np.int64]:
        """The compared sites at time ``t``."""
        middle = math.floor(self.constants.sound_speed() * t + 0.5)
        return middle + np.arange(-self.compared, self.compared + 1)


@dataclass(frozen=True)
class SpectralCost:
    """A run: ``steps``, ``points``, ``evaluations`` of the force, ``circumference``, ``seconds``.

    ``strain`` is the smallest and the largest that was met; ``planning_seconds`` are those of the
    runs before it.
    """

    steps: int
    points: int
    evaluations: int
    circumference: float
    strain: tuple[float, float]
    seconds: float
    planning_seconds: float = 0.0

    @property
    def work(self) -> float:
        """Evaluations of the force times points."""
        return float(self.evaluations) * self.points


@dataclass(frozen=True)
class SpectralRun:
    """``values`` of y/eps on the compared sites at the task's times, of shape (times, sites).

    With the choices that it took, its estimated error and its cost.
    """

    task: SpectralTask
    values: Array
    choices: Choices
    estimate: Estimate
    cost: SpectralCost

    def strain(self, index: int) -> Array:
        """Strain on the compared sites at ``task.times[index]``."""
        strain: Array = self.values[index] * self.task.eps
        return strain
