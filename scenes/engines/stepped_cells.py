"""Cells of a run, on a ring or in a moving window: their stepper and their view of the wave."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.schemes import Scheme, check_step
from longwave.lattice.seam import Fading
from longwave.lattice.state import BlowUp, Domain, Sites, State
from longwave.lattice.stepper import CHUNK, LEAST_CHUNK, FixedDomain, Stepper
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.domain_plan import ComparedCells, DomainPlan, Ends, count_cells
from longwave.scenes.engines.ring_cost import cell_seconds
from longwave.scenes.engines.run_record import RunRecord
from longwave.scenes.engines.window import FedWave, Window, stored_chain
from longwave.scenes.observed.observables import observable_named
from longwave.scenes.observed.view import View
from longwave.scenes.starts.initial_cells import InitialCells
from longwave.scenes.starts.lattice_wave import LatticeWave
from longwave.support.checkpoint import Memory
from longwave.support.real_arrays import Array

LOOK_SECONDS = 0.02
"""Seconds between two stops, at which the state is checked for NaN and Ctrl-C takes effect."""


class SteppedCells:
    """Cells of a run on a ring, with its initial data, stepper and views.

    The scene is in lattice times. The ring has the scene's number of sites, or the given ``ends``.
    With ``nudged`` the last digits of the initial data are changed. With ``fades`` the cells that
    can no longer affect a compared cell are damped; by default they are, unless an observable
    measures all cells. ``scale`` is the unit of errors; ``reach`` is the number of compared cells
    on either side of the frame along each axis. Raises ValueError for a ring that is too small.
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
        self._fades = not measures_all_cells(scene) if fades is None else fades
        self.scale, self.reach = domains.wave.scale, domains.compared.reach
        if ends is None:
            least, sites = count_cells(domains.plain_ends(0)), scene.discretisation.sites
            if sites < least:
                raise ValueError(
                    f"sites must satisfy sites >= {least} on this ring, got {sites} (else signals "
                    "from the seam reach the compared sites; widen it or end earlier)"
                )
            ends = domains.plain_ends(sites - least)
        self.ends = ends

    @property
    def task(self) -> str:
        """Text that identifies the run in a checkpoint: scene, ring, and whether it is nudged."""
        return f"{self.scene.json()} on {self.ends}{' nudged' if self._nudged else ''}"

    @cached_property
    def ring(self) -> InitialCells:
        """Initial data on the ring. The stepper advances these arrays in place."""
        ring = self.domains.ring(self.ends)
        return ring.nudged() if self._nudged else ring

    def stepper(self, restart: State | None) -> tuple[Stepper, float]:
        """Return the stepper and the largest stable step; ValueError if the scene's is larger."""
        stated = self.scene.discretisation
        limit = check_step(stated.step, stated.table, self.domains.fastest)
        state, domain = self._begin(restart)
        ring, scheme = self.ring, stated.table
        amplitude = float(np.max(np.abs(ring.f))) if self.domains.wave.watches_strains else None
        chunk = steps_between_looks(ring.lattice, state, scheme, amplitude is not None)
        stepper = Stepper(state, scheme, ring.lattice, domain, stated.step, amplitude, chunk)
        return stepper, limit

    def _begin(self, restart: State | None) -> tuple[State, Domain]:
        """Return the state from which to start or resume the run, and its domain."""
        if restart is not None:
            self.ends = _ends_of(restart, self.domains.plain_ends(0))
        ring = self.ring
        state = State(ring.t, ring.f, ring.v)
        if restart is not None:
            shape = state.f.shape
            state = State(restart.t, restart.f.reshape(shape), restart.v.reshape(shape))
        domains, fading = self.domains, None
        if self._fades and domains.room:
            fading = domains.wave.fading(domains.times[0], domains.signals[0])
        return state, RingDomain(state, self.ends, domains, fading)

    def view(self, state: State) -> CellView:
        """Return the view of wave and ``state`` on the compared cells."""
        domains, ring = self.domains, self.ring
        ends, arrays = self.ends_at(state), self.arrays_at(state)
        return CellView(
            domains.wave, domains.compared, ring.lattice, ring.mean_strain, state, ends, arrays
        )

    def ends_at(self, state: State) -> Sequence[Ends]:
        """Return the first and last cell of a state along each axis."""
        return self.ends

    def arrays_at(self, state: State) -> tuple[Array, Array]:
        """Return fields and velocities of a state in the order of the cells."""
        return state.arrays

    def refined(self, scene: Scene) -> SteppedCells:
        """Return the cells of a refined scene with the same wave."""
        return type(self)(scene, self.domains)

    def attributes(self, stepper: Stepper) -> dict[str, Any]:
        """Return run attributes: the number of sites, and the strain range if it is monitored."""
        return {"sites": count_cells(self.ends), **self._strains(stepper)}

    def _strains(self, stepper: Stepper) -> dict[str, float]:
        """Return the smallest and largest strain of the run; empty for a wave without strains."""
        if not self.domains.wave.watches_strains:
            return {}
        least, most = stepper.ranges[0]
        return {"least_strain": float(least), "most_strain": float(most)}


def measures_all_cells(scene: Scene) -> bool:
    """Return whether an observable of the scene measures more than the compared cells."""
    return any(observable_named(name).all_sites for name in scene.observables)


def _ends_of(restart: State, needed: Sequence[Ends]) -> list[Ends]:
    """Return the ends of the ring that a stored state of a chain covers.

    ``needed`` are the ends of the causal ring. Raises ValueError if the state's ring is smaller.
    """
    first, last = restart.left, restart.left + restart.f.shape[-1] - 1
    low, high = needed[0]
    if low < first or high > last:
        raise ValueError(
            f"snapshots must leave the state's ring wide enough, got cells {first} .. {last} but "
            f"signals arrive from {low} .. {high} (end earlier, or run the scene to the later time)"
        )
    return [(first, last)]


@dataclass
class RingDomain(FixedDomain):
    """Ring of cells with fixed ends, optionally with damping of cells that no longer matter."""

    ends: Sequence[Ends]
    domains: DomainPlan
    fading: Fading | None

    def fade(self, state: State) -> None:
        """Damp the cells that can no longer affect a compared cell."""
        if self.fading is not None:
            self.fading.at(state)

    def recall(self, memory: Memory, t: float) -> None:
        """Restore the damping that a run resumed at time ``t`` had applied so far."""
        if self.fading is not None:
            self.fading.faded_until = t

    def locate(self, found: BlowUp, state: State) -> BlowUp:
        """Return a blow-up with the cell's number instead of its storage index."""
        columns = state.f[0].size // state.f.shape[1]
        site = self.ends[0][0] + found.site // columns
        return self.domains.with_seam_distance(replace(found, site=site), self.ends)


def steps_between_looks(
    lattice: NumericLattice, state: State, scheme: Scheme, watches_strains: bool
) -> int:
    """Return the number of steps of a ring that take about ``LOOK_SECONDS``.

    It is at least `LEAST_CHUNK` on a chain. For a wave whose strains are checked
    (`blow_up.find_blow_up`) it is at most `CHUNK`, as the seam needs damping that often.
    """
    seconds = cell_seconds(lattice) * state.f[0].size
    least = LEAST_CHUNK if lattice.dimension == 1 else 1
    chunk = max(least, int(LOOK_SECONDS / (scheme.stages * seconds)))
    return min(chunk, CHUNK) if watches_strains else chunk


@dataclass(frozen=True)
class CellView(View):
    """View of a wave on any lattice, in the compared cells of a state.

    The state's cells have the given ``ends``; ``arrays`` are its fields and velocities in the order
    of the cells. The bonds of ``lattice`` are stretched by ``mean_strain``.
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
        """Uniform value of the first compared quantity, on which the wave is superposed."""
        return float(self.wave.uniform()[0])

    @property
    def travelled(self) -> float:
        """Distance that the wave's frame has travelled, in cells."""
        return self.wave.speed * self.t

    @property
    def crest_law(self) -> float | None:
        """Height of the crest by the amplitude law of a damped soliton; None for other waves."""
        return self.wave.crest(self.t)

    @cached_property
    def sites(self) -> Sites:
        """Compared cells along the first axis."""
        cells = self._cells if self._cells.ndim == 1 else self._cells[0, :, 0]
        return cells.astype(np.int64)

    @cached_property
    def numerics(self) -> Array:
        """Compared quantities of the run, (quantities, *sites); a copy, as the state changes."""
        wide, inner = self.wave.with_neighbours(self.compared.slices(self.ends, self.t))
        values = self.wave.quantity_values(self.arrays[0][:, *wide], self.mean_strain)
        return np.array(values[:, *inner], subok=True)

    @cached_property
    def analytics(self) -> Array:
        """Compared quantities of the wave, (quantities, *sites)."""
        return self.wave.strain(self._cells, self.t)

    @cached_property
    def backgrounds(self) -> Array:
        """Compared quantities of the wave's background, (quantities, *sites)."""
        return np.asarray(self.wave.background(self._cells, self.t), dtype=np.float64)

    @cached_property
    def far_field(self) -> Array | None:
        """First quantity of the wave's true far field; None if it equals the background."""
        values = self.wave.far_field(self.sites, self.t)
        return None if values is None else np.asarray(values[0])

    @property
    def extra_variables(self) -> dict[str, Any]:
        """Sup error, slow time and any further quantities; empty for moving mKdV waves."""
        if self.wave.watches_strains:
            return {}
        error = float(np.max(np.abs(self.numerics - self.analytics))) / self.wave.scale
        variables = {"sup_error": error, "slow_time": self.t * self.wave.eps**self.wave.slow}
        if len(self.numerics) == 1:
            return variables
        return variables | {"strains": self.numerics, "analytics": self.analytics}

    def displaced(self, shift: float) -> tuple[Array, Array, Array, Array]:
        """Return wave, background and the slopes of both, moved ahead by ``shift`` cells."""
        return self.wave.values_and_slopes(self._cells - shift, self.t)

    @property
    def energy(self) -> float:
        """Energy of the ring."""
        return self.wave.energy(self.lattice, self.state.f, self.state.v)

    @property
    def means(self) -> tuple[float, float]:
        """Mean of the first quantity over the ring, and mass-weighted mean velocity."""
        strain = self.wave.quantity_values(self.arrays[0], self.mean_strain)[0]
        masses = np.array(self.lattice.masses)
        velocities = self.arrays[1].reshape(masses.size, -1).mean(axis=1)
        return float(np.mean(strain)), float(np.average(velocities, weights=masses))

    @property
    def stored(self) -> tuple[int, Array, Array]:
        """Leftmost cell, and copies of fields and velocities; a single field has no field axis."""
        f, v = (values[0] if len(values) == 1 else values for values in self.arrays)
        return self.ends[0][0], f.copy(), v.copy()

    def judged(self, beyond: int = 0, compared: ComparedCells | None = None) -> Array:
        """Return the compared quantities and their rates over `rate_unit`, in units of the scale.

        The cells are ``compared``, by default those of the view, and ``beyond`` cells around them.
        """
        cells = (compared or self.compared).slices(self.ends, self.t, beyond)
        values = self.wave.values_and_rates_at(*self.arrays, self.mean_strain, cells)
        return values / self.wave.scale

    @cached_property
    def _cells(self) -> Array:
        return self.compared.cells(self.t)


def add_energy_drift(run: RunRecord, begin: float, end: float) -> None:
    """Add the relative change of energy to a run's attributes, unless the energy is not finite."""
    if math.isfinite(begin):
        run.attrs["energy_drift"] = abs(end - begin) / abs(begin) if begin else 0.0


class WindowCells(SteppedCells):
    """Cells of a run in a moving window, whose number the scene states.

    Raises ValueError for a wave without a constant background and for a window that is too small.
    """

    def __init__(self, scene: Scene, domains: DomainPlan, nudged: bool = False) -> None:
        self.scene, self.domains, self._nudged = scene, domains, nudged
        self.scale, self.reach = domains.wave.scale, domains.compared.reach
        fed = FedWave(domains, scene.discretisation.sites, nudged)
        self._window, first = Window(fed), fed.first(fed.t0)
        self.ends = [(first, first + fed.size - 1)]

    @cached_property
    def ring(self) -> InitialCells:
        """Initial data on the window's cells."""
        return self._window.wave.ring

    def _begin(self, restart: State | None) -> tuple[State, Domain]:
        state = self._window.start()
        if restart is not None:
            shape = state.f.shape
            arrays = (restart.f.reshape(shape), restart.v.reshape(shape))
            state = stored_chain(restart.t, restart.left, *arrays)
        return state, self._window

    def ends_at(self, state: State) -> Sequence[Ends]:
        """Return the window's first and last cell at a state's time."""
        return [(state.left, state.left + state.f.shape[1] - 1)]

    def arrays_at(self, state: State) -> tuple[Array, Array]:
        """Return fields and velocities in the order of the cells."""
        return state.at(state.sites)

    def attributes(self, stepper: Stepper) -> dict[str, Any]:
        """Return run attributes: the feed's mismatch, and the strain range if it is monitored."""
        return {"feed_mismatch": stepper.domain.mismatch, **self._strains(stepper)}
