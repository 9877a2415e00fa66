"""The sites of the paper's chain, stepped with a stated discretisation, and what that takes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from longwave.lattice.schemes import check_step
from longwave.lattice.state import Domain, State
from longwave.lattice.stepper import Stepper, advance
from longwave.scenes.chain.domain import SiteRing, Window
from longwave.scenes.chain.moving_wave import MovingWave
from longwave.scenes.observables import observable_named
from longwave.scenes.view import SiteView

if TYPE_CHECKING:
    from longwave.scenes.scene import Scene


@dataclass(frozen=True)
class ChainSites:
    """A scene on the paper's chain as it is stepped (`stated_run.SteppedScene`)."""

    scene: Scene
    moving: MovingWave

    @property
    def scale(self) -> float:
        """Errors are of y/eps."""
        return self.scene.eps

    @property
    def reach(self) -> tuple[int, ...]:
        """The compared sites on either side."""
        return (self.scene.compared,)

    @property
    def task(self) -> str:
        """The scene."""
        return self.scene.json()

    def domain(self) -> Domain:
        """The domain that the scene states.

        A closed ring fades where nothing asks for all sites.
        """
        stated = self.scene.discretisation
        if stated.domain == "window":
            return Window(self.moving, stated.sites)
        closed = stated.domain == "closed_ring"
        whole = any(observable_named(name).all_sites for name in self.scene.observables)
        return SiteRing(self.moving, stated.sites, closed, fades=closed and not whole)

    def stepper(self, restart: State | None) -> tuple[Stepper, float]:
        """What steps the sites, and the largest stable step."""
        domain, stated, model = self.domain(), self.scene.discretisation, self.scene.model
        initial = domain.start()
        limit = check_step(stated.step, stated.table, model.highest_frequency(initial.f))
        advance(stated.table, initial.f, initial.v, stated.step, 0, model.lattice)
        state = initial if restart is None else restart
        amplitude = float(np.max(np.abs(initial.f)))
        return Stepper(state, stated.table, model.lattice, domain, stated.step, amplitude), limit

    def view(self, state: State) -> SiteView:
        """The compared sites."""
        return SiteView(self.moving, state)

    def refined(self, scene: Scene) -> ChainSites:
        """The sites of a finer scene, whose wave is the same."""
        return ChainSites(scene, self.moving)

    def told(self, stepper: Stepper) -> dict[str, Any]:
        """The strains that were met, and how well a window's feed fitted."""
        return {
            "least_strain": float(stepper.ranges[0, 0]),
            "most_strain": float(stepper.ranges[0, 1]),
            "feed_mismatch": stepper.domain.mismatch,
        }


START_SECONDS = 0.03
"""Before the first step, measured with the planning."""

PROCESS_SECONDS = 1.0
"""For imports, what is loaded and what is written, once in a process."""

SECONDS_PER_UPDATE = 6e-10
"""Seconds per site and force evaluation, measured with the planning."""
