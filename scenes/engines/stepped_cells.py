"""Cells about a wave as they are stepped and seen: on a ring, or in a window that moves with it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.schemes import Scheme, check_step
from longwave.lattice.seam import Fading
from longwave.lattice.state import BlowUp, Domain, Sites, State
from longwave.lattice.stepper import CHUNK, LEAST_CHUNK, FixedDomain, Stepper
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.domain_plan import ComparedCells, DomainPlan, Ends, sites_of
from longwave.scenes.engines.ring_cost import cell_seconds
from longwave.scenes.engines.run_record import RunRecord
from longwave.scenes.engines.window import FedWave, Window, stored_chain
from longwave.scenes.observed.observables import observable_named
from longwave.scenes.observed.view import View
from longwave.scenes.starts.initial_cells import InitialCells
from longwave.scenes.starts.lattice_wave import LatticeWave
from longwave.support.checkpoint import Memory

Array = NDArray[np.float64]

LOOK_SECONDS = 0.02
"""Seconds between two stops, at which it is looked whether the state is finite; Ctrl-C waits."""


class SteppedCells:
    """The cells of a ring as they are stepped.

    The scene has times of the lattice. Its ring has as many sites as it says, unless its ``ends``
    are given. It ``fades`` far from the compared cells, unless all cells are seen. Errors are told
    in units of ``scale``; ``reach`` cells are compared on either side of the frame along each axis.
    Raises ValueError for a ring that is too small.
    """

    def __init__(
        self,
        scene: Scene,
        domains: DomainPlan,
        ends: list[Ends] | None = None,
        nudged: bool = False,
        fades: bool | None = None,
    ) -> None:
        self.scene, self.domains, self._nudged = scene, domains, nudged
        self._fades = not sees_all_cells(scene) if fades is None else fades
        self.scale, self.reach = domains.wave.scale, domains.compared.reach
        if ends is None:
            least, sites = sites_of(domains.plain_ends(0)), scene.discretisation.sites
            if sites < least:
                raise ValueError(
                    f"sites must satisfy sites >= {least} on this ring, got {sites} (else signals "
                    "from the seam reach the compared sites; widen it or end earlier)"
                )
            ends = domains.plain_ends(sites - least)
        self.ends = ends

    @property
    def task(self) -> str:
        """Everything that its states follow from: scene, ring, whether last digits are changed."""
        return f"{self.scene.json()} on {self.ends}{' nudged' if self._nudged else ''}"

    @cached_property
    def ring(self) -> InitialCells:
        """The data, until they are stepped: there is one copy of a large ring."""
        ring = self.domains.ring(self.ends)
        return ring.nudged() if self._nudged else ring

    def stepper(self, restart: State | None) -> tuple[Stepper, float]:
        """What steps the cells, and the largest stable step."""
        stated = self.scene.discretisation
        limit = check_step(stated.step, stated.table, self.domains.fastest)
        if restart is not None:
            self.ends = _ends_of(restart, self.domains.plain_ends(0))
        ring = self.ring
        state = State(ring.t, ring.f, ring.v)
        if restart is not None:
            shape = state.f.shape
            state = State(restart.t, restart.f.reshape(shape), restart.v.reshape(shape))
        domain = RingDomain(state, self.ends, self.domains, self._fading)
        return self._stepper_of(state, domain), limit

    def _stepper_of(self, state: State, domain: Domain) -> Stepper:
        ring, stated = self.ring, self.scene.discretisation
        amplitude = float(np.max(np.abs(ring.f))) if self.domains.wave.watches_strains else None
        return ring_stepper(ring.lattice, state, domain, stated.table, stated.step, amplitude)

    @property
    def _fading(self) -> Fading | None:
        """What fades the cells whose signals come too late."""
        return self.domains.fading() if self._fades and self.domains.room else None

    def view(self, state: State) -> CellView:
        """The compared cells."""
        domains, ring = self.domains, self.ring
        ends, arrays = self.ends_at(state), self.arrays_at(state)
        return CellView(
            domains.wave, domains.compared, ring.lattice, ring.mean_strain, state, ends, arrays
        )

    def ends_at(self, state: State) -> Sequence[Ends]:
        """First and last cell along each axis that a state holds."""
        return self.ends

    def arrays_at(self, state: State) -> tuple[Array, Array]:
        """Fields and velocities of a state in the order of the cells."""
        return state.arrays

    def refined(self, scene: Scene) -> SteppedCells:
        """The cells of a finer scene."""
        return SteppedCells(scene, self.domains)

    def told(self, stepper: Stepper) -> dict[str, Any]:
        """The sites of the ring, which on a plane the scene does not say, and strains."""
        return {"sites": sites_of(self.ends), **self._strains(stepper)}

    def _strains(self, stepper: Stepper) -> dict[str, float]:
        """The strains that were met, of a wave that watches them."""
        if not self.domains.wave.watches_strains:
            return {}
        least, most = stepper.ranges[0]
        return {"least_strain": float(least), "most_strain": float(most)}


def sees_all_cells(scene: Scene) -> bool:
    """Whether an observable of the scene is of all cells."""
    return any(observable_named(name).all_sites for name in scene.observables)


def _ends_of(restart: State, needed: Sequence[Ends]) -> list[Ends]:
    """The ends of the ring that a state of a chain was kept on."""
    first, last = restart.left, restart.left + restart.f.shape[-1] - 1
    low, high = needed[0]
    if low < first or high > last:
        raise ValueError(
            f"snapshots must leave the state's ring wide enough, got {first} .. {last} where "
            f"signals come from {low} .. {high} (end earlier, or run the scene to the later time)"
        )
    return [(first, last)]


@dataclass
class RingDomain(FixedDomain):
    """A ring of cells with these ends, some of which may fade."""

    ends: Sequence[Ends]
    domains: DomainPlan
    fading: Fading | None

    def fade(self, state: State) -> None:
        """Let fade what can no longer reach a compared cell."""
        if self.fading is not None:
            self.fading.at(state)

    def recall(self, memory: Memory, t: float) -> None:
        """Have faded until ``t``."""
        if self.fading is not None:
            self.fading.faded_until = t

    def locate(self, found: BlowUp, state: State) -> BlowUp:
        """``found``, with the cell in the place of where it is stored."""
        columns = state.f[0].size // state.f.shape[1]
        site = self.ends[0][0] + found.site // columns
        return self.domains.located(replace(found, site=site), self.ends)


def ring_stepper(
    lattice: NumericLattice,
    state: State,
    domain: Domain,
    scheme: Scheme,
    step: float,
    amplitude: float | None = None,
) -> Stepper:
    """What steps a ring, with a stop every ``LOOK_SECONDS``, of a chain or `LEAST_CHUNK` steps.

    With the ``amplitude`` of a wave its strains are watched (`blow_up.find_blow_up`), as often as
    what sends out too much at a ring's seam is to fade.
    """
    seconds = cell_seconds(lattice) * state.f[0].size
    least = LEAST_CHUNK if lattice.dimension == 1 else 1
    chunk = max(least, int(LOOK_SECONDS / (scheme.stages * seconds)))
    chunk = chunk if amplitude is None else min(chunk, CHUNK)
    return Stepper(state, scheme, lattice, domain, step, amplitude, chunk)


@dataclass(frozen=True)
class CellView(View):
    """A wave on any lattice, seen in the compared ones of the cells that a state holds.

    These have the given ``ends``, and fields and velocities in their order as ``arrays``; the
    ``lattice`` has its bonds stretched by the ``mean_strain``.
    """

    wave: LatticeWave
    compared: ComparedCells
    lattice: NumericLattice
    mean_strain: tuple[float, ...]
    state: State
    ends: Sequence[Ends]
    arrays: tuple[Array, Array]

    @property
    def level(self) -> float:
        """The uniform strain that the wave is added to."""
        return float(self.wave.uniform()[0])

    @property
    def travelled(self) -> float:
        """At the speed of the wave's frame."""
        return self.wave.speed * self.t

    @property
    def crest_law(self) -> float | None:
        """That of the first quantity, by the wave's own law."""
        return self.wave.crest(self.t)

    @cached_property
    def sites(self) -> Sites:
        """The compared cells along the first axis."""
        cells = self._cells if self._cells.ndim == 1 else self._cells[0, :, 0]
        return cells.astype(np.int64)

    @cached_property
    def numerics(self) -> Array:
        """All quantities that are compared, of the run: a copy, for the state goes on."""
        wide, inner = self.wave.beside(self._places(self.compared))
        found = self.wave.measured(self.arrays[0][:, *wide], self.mean_strain)
        return np.array(found[:, *inner], subok=True)

    @cached_property
    def analytics(self) -> Array:
        """The same of the wave."""
        return self.wave.strain(self._cells, self.t)

    @cached_property
    def backgrounds(self) -> Array:
        """The same of what it deviates from."""
        return np.asarray(self.wave.background(self._cells, self.t), dtype=np.float64)

    @cached_property
    def far_field(self) -> Array | None:
        """The first quantity of the wave's true far field, if it is told apart."""
        found = self.wave.far_field(self.sites, self.t)
        return None if found is None else np.asarray(found[0])

    @property
    def also(self) -> dict[str, Any]:
        """The sup error in its unit, T, and all quantities if there are more than one."""
        if self.wave.watches_strains:
            return {}
        apart = float(np.max(np.abs(self.numerics - self.analytics))) / self.wave.scale
        found = {"sup_error": apart, "slow_time": self.t * self.wave.eps**self.wave.slow}
        if len(self.numerics) == 1:
            return found
        return found | {"strains": self.numerics, "analytics": self.analytics}

    def displaced(self, shift: float) -> tuple[Array, Array, Array, Array]:
        """Wave, background and their slopes."""
        return self.wave.displaced(self._cells - shift, self.t)

    @property
    def energy(self) -> float:
        """That of the ring."""
        return self.wave.energy(self.lattice, self.state.f, self.state.v)

    @property
    def means(self) -> tuple[float, float]:
        """Of the first quantity over the ring, and of the velocities of all masses."""
        strain = self.wave.measured(self.arrays[0], self.mean_strain)[0]
        masses = np.array(self.lattice.masses)
        velocities = self.arrays[1].reshape(masses.size, -1).mean(axis=1)
        return float(np.mean(strain)), float(np.average(velocities, weights=masses))

    @property
    def stored(self) -> tuple[int, Array, Array]:
        """The periodic parts of the fields; without an axis for a single one."""
        f, v = (values[0] if len(values) == 1 else values for values in self.arrays)
        return self.ends[0][0], f.copy(), v.copy()

    def judged(self, beyond: int = 0, compared: ComparedCells | None = None) -> Array:
        """What is compared, in these cells and some beyond, and its rate, in units of the scale."""
        places = self._places(compared or self.compared, beyond)
        return self.wave.seen_at(*self.arrays, self.mean_strain, places) / self.wave.scale

    @cached_property
    def _cells(self) -> Array:
        return self.compared.cells(self.t)

    def _places(self, compared: ComparedCells, beyond: int = 0) -> tuple[slice, ...]:
        return compared.places(self.ends, self.t, beyond)


def tell_energies(run: RunRecord, begin: float, end: float) -> None:
    """Tell by how much an energy changed; nothing where it is none."""
    if math.isfinite(begin):
        run.attrs["energy_drift"] = abs(end - begin) / abs(begin) if begin else 0.0


class WindowCells(SteppedCells):
    """The cells of a moving window as they are stepped; as many as the scene states.

    Raises ValueError for a wave without a constant background, and for too few of them.
    """

    def __init__(self, scene: Scene, domains: DomainPlan, nudged: bool = False) -> None:
        self.scene, self.domains, self._nudged = scene, domains, nudged
        self.scale, self.reach = domains.wave.scale, domains.compared.reach
        fed = FedWave(domains, scene.discretisation.sites, nudged)
        self._window, first = Window(fed, fed.size), fed.first(fed.t0)
        self.ends = [(first, first + fed.size - 1)]

    @cached_property
    def ring(self) -> InitialCells:
        """The data."""
        return self._window.wave.ring

    def stepper(self, restart: State | None) -> tuple[Stepper, float]:
        """What steps the cells, and the largest stable step."""
        stated = self.scene.discretisation
        limit = check_step(stated.step, stated.table, self.domains.fastest)
        state = self._window.start()
        if restart is not None:
            shape = state.f.shape
            kept = (restart.f.reshape(shape), restart.v.reshape(shape))
            state = stored_chain(restart.t, restart.left, *kept)
        return self._stepper_of(state, self._window), limit

    def ends_at(self, state: State) -> Sequence[Ends]:
        """The first and the last cell that the window holds."""
        return [(state.left, state.left + state.f.shape[1] - 1)]

    def arrays_at(self, state: State) -> tuple[Array, Array]:
        """Fields and velocities in the order of the cells."""
        return state.at(state.sites)

    def refined(self, scene: Scene) -> WindowCells:
        """The cells of a finer scene."""
        return WindowCells(scene, self.domains)

    def told(self, stepper: Stepper) -> dict[str, Any]:
        """How well the feed fitted, and strains."""
        return {"feed_mismatch": stepper.domain.mismatch, **self._strains(stepper)}
