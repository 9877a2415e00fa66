"""Records of the domains and engines that a scene may name, as runs use them."""

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
    """A domain, whose ``cells`` are stepped by a scene that states it."""

    cells: Callable[[Scene, DomainPlan], SteppedCells]


class WaveRuns(NamedTuple):
    """Run of a scene's wave to its tolerance, and what it is expected to cost."""

    record: Callable[[Scene, Progress, Announce], RunRecord]
    cost: Callable[[Scene], ExpectedCost]


@dataclass(frozen=True, kw_only=True)
class WaveEngine(EngineRules):
    """An engine for the wave of a scene; ``runs`` imports what computes it."""

    runs: Callable[[], WaveRuns]
