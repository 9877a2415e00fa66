"""Record types of the domains and engines that a scene may name, with their functions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from longwave.scenes.description.numerics import DomainRules, EngineRules

if TYPE_CHECKING:
    from longwave.lattice.refine import Announce
    from longwave.lattice.trial import Progress
    from longwave.scenes.description.scene import Scene
    from longwave.scenes.engines.domain_plan import DomainPlan
    from longwave.scenes.engines.run_record import RunRecord
    from longwave.scenes.engines.stepped_cells import SteppedCells
    from longwave.support.request_limits import ExpectedCost


@dataclass(frozen=True, kw_only=True)
class CellDomain(DomainRules):
    """Rules of a domain that a scene states, with the function ``cells`` that builds its cells."""

    cells: Callable[[Scene, DomainPlan], SteppedCells]


class WaveRuns(NamedTuple):
    """Functions: ``record`` runs a scene to its tolerance, ``cost`` predicts the run's cost."""

    record: Callable[[Scene, Progress, Announce], RunRecord]
    cost: Callable[[Scene], ExpectedCost]


@dataclass(frozen=True, kw_only=True)
class WaveEngine(EngineRules):
    """Rules of an engine for scenes with a tolerance; ``runs`` imports and returns `WaveRuns`."""

    runs: Callable[[], WaveRuns]
