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
from longwave.lattice.state import BlowUp, Domain, Sites, State
from longwave.lattice.stepper import LEAST_CHUNK, Stepper, StillRing
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.ring_cost import cell_seconds
from longwave.scenes.engines.wave_rings import ComparedCells, Ends, WaveRings, sites_of
from longwave.scenes.engines.window import Window, stored_chain
from longwave.scenes.observed.run_record import RunRecord
from longwave.scenes.observed.view import View
from longwave.scenes.starts.lattice_wave import CellRing, LatticeWave

Array = NDArray[np.float64]

LOOK_SECONDS = 0.02
"""Seconds between two stops, at which it is looked whether the state is finite; Ctrl-C waits."""


class RingCells:
    """The cells of a ring as they are stepped, with the members that `ChainSites` has.

    The scene has times of the lattice. Its ring has as many sites as it says, unless its ``ends``
    are given. Raises ValueError for a ring that is too small.
    """

    def __init__(
        self,
        scene: Scene,
        rings: WaveRings,
        ends: list[Ends] | None = None,
        nudged: bool = False,
    ) -> None:
        self.scene, self.rings, self._nudged = scene, rings, nudged
        self.scale, self.reach = rings.wave.scale, rings.compared.reach
        if ends is None:
            least, sites = sites_of(rings.plain_ends(0)), scene.discretisation.sites
            if sites < least:
                raise ValueError(
                    f"sites must satisfy sites >= {least} on this ring, got {sites} (else signals "
                    "from the seam reach the compared sites; widen it or end earlier)"
                )
            ends = rings.plain_ends(sites - least)
        self.ends = ends

    @property
    def task(self) -> str:
        """Everything that its states follow from: scene, ring, whether last digits are changed."""
        return f"{self.scene.json()} on {self.ends}{' nudged' if self._nudged else ''}"

    @cached_property
    def ring(self) -> CellRing:
        """The data, until they are stepped: there is one copy of a large ring."""
        ring = self.rings.ring(self.ends)
        return ring.nudged() if self._nudged else ring

    def stepper(self, restart: State | None) -> tuple[Stepper, float]:
        """What steps the cells, and the largest stable step."""
        stated = self.scene.discretisation
        limit = check_step(stated.step, stated.table, self.rings.fastest)
        if restart is not None:
            self.ends = _ends_of(restart, self.rings.plain_ends(0))
        ring = self.ring
        state = State(ring.t, ring.f, ring.v)
        if restart is not None:
            shape = state.f.shape
            state = State(restart.t, restart.f.reshape(shape), restart.v.reshape(shape))
        domain = CellDomain(state, self.ends, self.rings)
        return ring_stepper(ring.lattice, state, domain, stated.table, stated.step), limit

    def view(self, state: State) -> CellView:
        """The compared cells."""
        return CellView(self, state)

    def ends_at(self, state: State) -> Sequence[Ends]:
        """First and last cell along each axis that a state holds."""
        return self.ends

    def arrays_at(self, state: State) -> tuple[Array, Array]:
        """Fields and velocities of a state in the order of the cells."""
        return state.arrays

    def refined(self, scene: Scene) -> RingCells:
        """The cells of a finer scene."""
        return RingCells(scene, self.rings)

    def told(self, stepper: Stepper) -> dict[str, Any]:
        """The sites of the ring, which on a plane the scene does not say."""
        return {"sites": sites_of(self.ends)}


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
class CellDomain(StillRing):
    """A ring of cells with these ends."""

    ends: Sequence[Ends]
    rings: WaveRings

    def locate(self, found: BlowUp, state: State) -> BlowUp:
        """``found``, with the cell in the place of where it is stored."""
        columns = state.f[0].size // state.f.shape[1]
        site = self.ends[0][0] + found.site // columns
        return self.rings.located(replace(found, site=site), self.ends)


def ring_stepper(
    lattice: NumericLattice, state: State, domain: Domain, scheme: Scheme, step: float
) -> Stepper:
    """What steps a ring, with a stop every ``LOOK_SECONDS``, of a chain or `LEAST_CHUNK` steps."""
    seconds = cell_seconds(lattice) * state.f[0].size
    least = LEAST_CHUNK if lattice.dimension == 1 else 1
    chunk = max(least, int(LOOK_SECONDS / (scheme.stages * seconds)))
    return Stepper(state, scheme, lattice, domain, step, None, chunk)


@dataclass(frozen=True)
class CellView(View):
    """A wave on any lattice, seen in the compared cells of a ring."""

    held: RingCells
    state: State

    @property
    def level(self) -> float:
        """The uniform strain that the wave is added to."""
        return float(self._wave.uniform()[0])

    @property
    def travelled(self) -> float:
        """At the speed of the wave's frame."""
        return self._wave.speed * self.t

    @property
    def crest_law(self) -> float | None:
        """That of the first quantity, by the wave's own law."""
        return self._wave.crest(self.t)

    @cached_property
    def sites(self) -> Sites:
        """The compared cells along the first axis."""
        cells = self._cells if self._cells.ndim == 1 else self._cells[0, :, 0]
        return cells.astype(np.int64)

    @cached_property
    def numerics(self) -> Array:
        """All quantities that are compared, of the run: a copy, for the state goes on."""
        wide, inner = self.held.rings.beside(self._places(self.held.rings.compared))
        found = self._wave.measured(self._arrays[0][:, *wide], self.held.ring.mean_strain)
        return np.array(found[:, *inner])

    @cached_property
    def analytics(self) -> Array:
        """The same of the wave."""
        return self._wave.strain(self._cells, self.t)

    @cached_property
    def backgrounds(self) -> Array:
        """The same of what it deviates from."""
        return np.asarray(self._wave.background(self._cells, self.t), dtype=np.float64)

    @property
    def also(self) -> dict[str, Any]:
        """The sup error in its unit, T, and all quantities if there are more than one."""
        apart = float(np.max(np.abs(self.numerics - self.analytics))) / self.held.scale
        found = {"sup_error": apart, "slow_time": self.t * self._wave.eps**self._wave.slow}
        if len(self.numerics) == 1:
            return found
        return found | {"strains": self.numerics, "analytics": self.analytics}

    def displaced(self, shift: float) -> tuple[Array, Array, Array, Array]:
        """Wave, background and their slopes, which are differences."""
        at = [self._cells - shift + apart for apart in (0.0, SLOPE_APART, -SLOPE_APART)]
        found = []
        for made in (self._wave.strain, self._wave.background):
            value, ahead, behind = (np.asarray(made(cells, self.t)[0]) for cells in at)
            found += [value, (ahead - behind) / (2.0 * SLOPE_APART)]
        return found[0], found[2], found[1], found[3]

    @property
    def energy(self) -> float:
        """That of the ring of displacements."""
        with np.errstate(all="ignore"):
            return self.held.ring.lattice.energy(self.state.f, self.state.v)

    @property
    def means(self) -> tuple[float, float]:
        """Of the first quantity over the ring, and of the velocities of all masses."""
        lattice = self.held.ring.lattice
        strain = self._wave.measured(self._arrays[0], self.held.ring.mean_strain)[0]
        masses = np.array(lattice.masses)
        velocities = self._arrays[1].reshape(masses.size, -1).mean(axis=1)
        return float(np.mean(strain)), float(np.average(velocities, weights=masses))

    @property
    def stored(self) -> tuple[int, Array, Array]:
        """The periodic parts of the fields; without an axis for a single one."""
        f, v = (values[0] if len(values) == 1 else values for values in self._arrays)
        return self.held.ends_at(self.state)[0][0], f.copy(), v.copy()

    def judged(self, beyond: int = 0, compared: ComparedCells | None = None) -> Array:
        """What is compared, in these cells and some beyond, and its rate, in units of the scale."""
        places = self._places(compared or self.held.rings.compared, beyond)
        seen = self.held.rings.seen_at(self.held.ring, *self._arrays, places)
        return seen / self.held.scale

    @property
    def _wave(self) -> LatticeWave:
        return self.held.rings.wave

    @cached_property
    def _arrays(self) -> tuple[Array, Array]:
        return self.held.arrays_at(self.state)

    @cached_property
    def _cells(self) -> Array:
        return self.held.rings.compared.cells(self.t)

    def _places(self, compared: ComparedCells, beyond: int = 0) -> tuple[slice, ...]:
        return compared.places(self.held.ends_at(self.state), self.t, beyond)


SLOPE_APART = 1e-3
"""Cells on either side of which the difference is a slope: a wave is much longer."""


def tell_energies(run: RunRecord, begin: float, end: float) -> None:
    """Tell by how much an energy changed; nothing where it is none."""
    if math.isfinite(begin):
        run.attrs["energy_drift"] = abs(end - begin) / abs(begin) if begin else 0.0


@dataclass(frozen=True)
class FedWave:
    """The wave of these rings as a window of ``size`` cells is fed with it (`WindowWave`).

    With ``nudged`` the last digits of its data are changed.
    """

    rings: WaveRings
    size: int
    nudged: bool = False

    @property
    def name(self) -> str:
        """The lattice's: its wave has none."""
        return f"this wave on {self.rings.wave.lattice.name}"

    @property
    def t0(self) -> float:
        """The first of the times."""
        return self.rings.times[0]

    @property
    def duration(self) -> float:
        """From the first to the last."""
        return self.rings.times[-1] - self.rings.times[0]

    @property
    def speed(self) -> float:
        """That of the wave's frame."""
        return self.rings.wave.speed

    @property
    def compared(self) -> int:
        """Cells on either side of the frame's origin."""
        return self.rings.compared.reach[0]

    @property
    def scale(self) -> float:
        """The unit of errors."""
        return self.rings.wave.scale

    @property
    def background_speed(self) -> float | None:
        """The speed of small long waves far from the wave."""
        return self.rings.wave.far_speed

    @property
    def fastest(self) -> float:
        """The largest group velocity of any wave about the data."""
        return self.rings.signals[0]

    def frame(self, t: float) -> int:
        """The cell nearest to the frame's origin."""
        return self.rings.compared.middle(t)

    @cached_property
    def ring(self) -> CellRing:
        """The data, with the mean strain that their displacements keep from end to end."""
        first = self.frame(self.t0) - self.size // 2
        ring = self.rings.wave.ring(np.arange(first, first + self.size, dtype=float), self.t0)
        return ring.nudged() if self.nudged else ring

    def initial_data(self, sites: Sites) -> tuple[Array, Array]:
        """The periodic parts of the fields, and the velocities, in all cells of the window."""
        return self.ring.f, self.ring.v

    def rigid_offsets(self, speed: float, sites: Sites, t: float) -> Array:
        """Cells at time t, from where the frame began, in one that moves at ``speed``."""
        begin = self.speed * self.t0
        return np.asarray((sites - begin) - speed * (t - self.t0), dtype=np.float64)

    def rigid_data(self, speed: float, offsets: Array) -> tuple[Array, Array]:
        """What deviates from the uniform far field, moving as it is at ``speed``."""
        wave, begin = self.rings.wave, self.speed * self.t0
        f, slopes = wave.rigid(begin + offsets, self.t0)
        return f, wave.far_rates[1][:, np.newaxis] - speed * slopes

    def uniform(self, sites: Sites, t: float) -> Array:
        """The uniform far field, less the mean strain, which the lattice's bonds hold."""
        wave, [mean] = self.rings.wave, self.ring.mean_strain
        growth, velocity = wave.far_rates
        left = growth - mean * np.array(wave.growth_shares)
        moved = np.multiply.outer(left, np.asarray(sites, dtype=np.float64))
        return np.asarray(moved + velocity[:, np.newaxis] * (t - self.t0))


class WindowCells(RingCells):
    """The cells of a moving window as they are stepped; as many as the scene states.

    Raises ValueError for a wave without a constant background, and for too few of them.
    """

    def __init__(self, scene: Scene, rings: WaveRings, nudged: bool = False) -> None:
        self.scene, self.rings, self._nudged = scene, rings, nudged
        self.scale, self.reach = rings.wave.scale, rings.compared.reach
        self._window = Window(FedWave(rings, scene.discretisation.sites, nudged), self._size)
        first = self._window.left(rings.times[0])
        self.ends = [(first, first + self._size - 1)]

    @property
    def _size(self) -> int:
        return self.scene.discretisation.sites

    @cached_property
    def ring(self) -> CellRing:
        """The data."""
        wave = self._window.wave
        assert isinstance(wave, FedWave)
        return wave.ring

    def stepper(self, restart: State | None) -> tuple[Stepper, float]:
        """What steps the cells, and the largest stable step."""
        stated = self.scene.discretisation
        limit = check_step(stated.step, stated.table, self.rings.fastest)
        state = self._window.start()
        if restart is not None:
            shape = state.f.shape
            kept = (restart.f.reshape(shape), restart.v.reshape(shape))
            state = stored_chain(restart.t, restart.left, *kept)
        lattice = self.ring.lattice
        return ring_stepper(lattice, state, self._window, stated.table, stated.step), limit

    def ends_at(self, state: State) -> Sequence[Ends]:
        """The first and the last cell that the window holds."""
        return [(state.left, state.left + state.f.shape[1] - 1)]

    def arrays_at(self, state: State) -> tuple[Array, Array]:
        """Fields and velocities in the order of the cells."""
        return state.at(state.sites)

    def refined(self, scene: Scene) -> WindowCells:
        """The cells of a finer scene."""
        return WindowCells(scene, self.rings)

    def told(self, stepper: Stepper) -> dict[str, Any]:
        """How well the feed fitted."""
        return {"feed_mismatch": stepper.domain.mismatch}


def stated_cells(scene: Scene, rings: WaveRings) -> RingCells:
    """The cells of the domain that a scene states."""
    is_window = scene.discretisation.domain == "window"
    return WindowCells(scene, rings) if is_window else RingCells(scene, rings)
