"""What the spectral engine is asked for, and what it gives back."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solutions import Wave
from verify.exponential.adams import ORDER
from verify.lattice.constants import Constants
from verify.lattice.ring_state import RingState

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SpectralTask:
    """What is to be run: a wave from ``t0``, seen at ``times`` within ``compared`` sites of c t.

    ``tolerance`` is the wanted sup error of y/eps there against the infinite lattice started from
    the same data. ``times`` increase and do not lie before t0.
    """

    constants: Constants
    wave: Wave
    eps: float
    t0: float
    times: tuple[float, ...]
    compared: int
    tolerance: float

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
class Estimates:
    """Measured errors of y/eps on the compared sites (sup over sites and times).

    ``domain_ratio`` is what the last doubling of the domain divided its difference by.
    """

    time_step: float
    sampling: float
    domain: float
    domain_ratio: float

    @property
    def total(self) -> float:
        """Their sum: the error against the infinite lattice."""
        return self.time_step + self.sampling + self.domain

    @property
    def next_decade(self) -> float:
        """The factor by which ten times more accuracy costs more (steps times points)."""
        return float(10.0 ** (1.0 / ORDER + 1.0 / math.log2(self.domain_ratio)))


@dataclass(frozen=True)
class SpectralCost:
    """The last run (``steps``, ``points``, ``evaluations`` of the force, ``seconds``), and all.

    ``work`` counts force evaluations times points, ``planning_*`` those of the runs before the
    last, which measured its errors.
    """

    steps: int
    points: int
    evaluations: int
    seconds: float
    planning_work: float
    planning_seconds: float

    @property
    def work(self) -> float:
        """Evaluations of the force times points, of the last run."""
        return float(self.evaluations) * self.points


@dataclass(frozen=True)
class SpectralRun:
    """The ring at the task's times, the step and circumference it took, and the errors measured."""

    task: SpectralTask
    states: tuple[RingState, ...]
    step: float
    estimates: Estimates
    cost: SpectralCost

    @property
    def circumference(self) -> float:
        """Circumference of the ring, in sites."""
        return self.states[0].circumference

    def strain(self, index: int) -> Array:
        """Strain on the compared sites at ``task.times[index]``."""
        state = self.states[index]
        return state.strain(self.task.sites(state.t))
