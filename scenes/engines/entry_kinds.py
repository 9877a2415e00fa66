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
    """Domain of a stated discretisation; ``cells`` builds the cells that are stepped."""

    cells: Callable[[Scene, DomainPlan], SteppedCells]


class WaveRuns(NamedTuple):
    """Functions that run a scene's wave to its tolerance and that predict the cost."""

    record: Callable[[Scene, Progress, Announce], RunRecord]
    cost: Callable[[Scene], ExpectedCost]


@dataclass(frozen=True, kw_only=True)
class WaveEngine(EngineRules):
    """Engine for a scene with a tolerance; ``runs`` imports and returns its functions."""

    runs: Callable[[], WaveRuns]
