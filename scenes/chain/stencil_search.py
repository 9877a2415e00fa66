"""A scene site by site: as it is stated, or with a tolerance in a window or on a causal ring."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from longwave.lattice.model import Model
from longwave.lattice.refine import USUAL_WORK, Announce, Refined
from longwave.lattice.schemes import Scheme, check_step, scheme_named, stability_limit
from longwave.lattice.state import Domain, State
from longwave.lattice.stepper import Stepper, advance
from longwave.lattice.trial import (
    NUDGE,
    SAFETY,
    Choices,
    Engine,
    Kind,
    Progress,
    StepSearch,
    StoppedTrial,
    Trial,
    clock_error,
    rounding_error,
    shorter_step,
)
from longwave.scenes.chain.domain import Array, SiteRing, least_ring, seam_room
from longwave.scenes.chain.moving_wave import MovingWave, WaveBounds, find_bounds
from longwave.scenes.description.numerics import Discretisation
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.ring_cost import LARGE, SHARE
from longwave.scenes.engines.stated_run import run_from
from longwave.scenes.engines.window import (
    SIZE_RATIO,
    WINDOW_DECAY,
    WINDOW_SAFETY,
    Window,
    front,
    judged_times,
    least_window,
    round_up,
    signal_drift,
    widened,
    window_moves,
)
from longwave.scenes.observed.observables import observable_named
from longwave.scenes.observed.recorders import Samples, exact_times
from longwave.scenes.observed.run_record import RunRecord, UnfinishedRun, searched, searched_on_part
from longwave.scenes.observed.view import SiteView
from longwave.support.request_limits import ExpectedCost, current_limits


class ChainSites:
    """A scene on the paper's chain as it is stepped.

    Errors are told in units of ``scale``, y/eps; ``reach`` cells are compared on either side of the
    frame along each axis; ``task`` is everything that its states follow from.
    """

    def __init__(self, scene: Scene, moving: MovingWave) -> None:
        self.scene, self.moving = scene, moving
        self.scale, self.reach, self.task = scene.eps, (scene.compared,), scene.json()

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
        """What steps the sites, kernels compiled, and the largest stable step.

        They begin with the scene's data, or with the state ``restart`` of an earlier run of the
        same scene. Raises ValueError for a step past the stability limit and for a domain that is
        too small.
        """
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


PREFERRED = "reduced_phase_6"
"""Fewest force evaluations for sup errors from 1e-2 to 1e-9 of those in the table."""

LIMIT_SHARE = 0.9
"""Longest step tried, in units of the stability limit at the largest strain of the wave."""


def domain_kind(scene: Scene, moving: MovingWave) -> str:
    """A window on a constant background, unless something asked for needs a ring."""
    background = moving.wave.constant_background
    needs_ring = any(observable_named(name).needs_ring for name in scene.observables)
    return "ring" if needs_ring or background is None else "window"


def longest_step(model: Model, scheme: Scheme, bounds: WaveBounds) -> float:
    """A step that is stable about the wave's largest strain."""
    limit = stability_limit(scheme) / model.highest_frequency(bounds.strain)
    return LIMIT_SHARE * limit


def least_sites(moving: MovingWave, domain: str, bounds: WaveBounds) -> int:
    """Fewest sites that hold the wave and the compared sites, in a multiple that suits kernels.

    A window's also keep off the rear's signals, which are faster than it on some backgrounds.
    """
    if domain == "ring":
        return round_up(least_ring(moving, bounds.strain) + seam_room(moving))
    return round_up(least_window(bounds.reach + signal_drift(moving)))


STEP_RATIO = 0.85
"""Step of a control run, in units of the one before it."""

WIDER = 256
"""Sites by which the control run's ring is wider, which is causal as it is."""

CLEARANCE = 128
"""Sites beyond the wave on which runs of a scout are compared."""

PERIODS = 20
"""Of a background, on either side of a wave, that show what it does."""

RUNAWAY = 4.0
"""A causal ring whose strains ask for one so many times wider has run away: the step is at fault,
or the lattice."""


def run_stencil(scene: Scene, progress: Progress, announce: Announce) -> tuple[RunRecord, Refined]:
    """The run of a scene to its tolerance, and how its error was estimated.

    The error is infinite if the lattice blows up by itself; what came before is kept. Raises
    ValueError for what wave or lattice do not admit and for a tolerance below what rounding leaves,
    UnfinishedRun on Ctrl-C.
    """
    engine = StencilEngine(scene, scene.moving_wave)
    parts = engine.parts()
    found = parts and searched_on_part(*parts, scene, progress, announce)
    found = found or searched(engine, scene, progress, announce)
    run = found.trial.payload
    if math.isinf(found.error) and not run.attrs["blow_up"]:
        raise ValueError(
            f"snapshots must end before strains run away, got {scene.end:g} (they grew beyond "
            f"{run.attrs['most_strain']:.3g} with steps down to {found.trial.choices.step:.2g}; "
            "end earlier or take a smaller eps)"
        )
    return run, found


def part_of(scene: Scene, moving: MovingWave) -> int | None:
    """The cells, on either side of c t, that stand for all that are compared in a large run.

    They hold the wave and all that signals from it reach, and many periods of its background. None
    where these are not few.
    """
    if 2 * scene.compared < LARGE:
        return None
    bounds = find_bounds(replace(moving, compared=1), scene.target.tolerance)
    fastest = moving.constants.highest_frequency(bounds.strain) / 2.0
    reached = bounds.reach + (moving.speed + fastest) * moving.duration
    reached += front(fastest, moving.duration)
    reached += PERIODS * (moving.wave.wavelength or 0.0) / moving.eps
    part = round_up(reached)
    return part if SHARE * part <= scene.compared else None


class StencilEngine(StepSearch):
    """Runs of a scene in windows or, where the background is not constant, on causal rings.

    Of the compared cells only those within ``judged`` of c t are judged, if that is given.
    """

    threads = 2
    decay = WINDOW_DECAY
    unstable = 1

    def __init__(self, scene: Scene, moving: MovingWave, judged: int | None = None) -> None:
        scheme = scheme_named(scene.target.scheme or PREFERRED)
        self._scene, self._moving = scene, moving
        beside = 0 if judged is None else scene.compared - judged
        self._judged = slice(beside, 2 * scene.compared + 1 - beside)
        self._bounds = find_bounds(moving, scene.target.tolerance)
        self._met: list[Array] = []  # on rings that were too narrow, of runs done at once
        self.amplifies_rounding = moving.wave.wavelength is not None
        self._domain = domain_kind(scene, moving)
        self.kinds: tuple[Kind, ...] = ("step", "domain") if self._domain == "window" else ("step",)
        self.safety = WINDOW_SAFETY if self._domain == "window" else SAFETY
        self._least = self._ring = _checked(least_sites(moving, self._domain, self._bounds))
        longest = longest_step(scene.model, scheme, self._bounds)
        stated = Discretisation(longest, self._domain, self._least, scheme.name)
        self._base = replace(scene, numerics=stated)
        exact = exact_times(self._base)
        is_window = self._domain == "window"
        self._times = judged_times(moving, exact) if is_window else tuple(exact)
        moves = window_moves(moving) if self._domain == "window" else ()
        stops = sorted({scene.t0, *exact, *(t for t in moves if t < scene.end)})
        super().__init__(scheme.order, longest, np.array(stops), self._least)
        self._first = replace(self._first, causal=self._domain == "ring")

    def coarse_engine(self) -> Engine:
        """The same about the wave alone, if that saves sites."""
        bounds = find_bounds(replace(self._moving, compared=1), self._scene.target.tolerance)
        compared = min(self._scene.compared, bounds.reach + CLEARANCE)
        if self._domain == "ring" or compared == self._scene.compared:
            return self
        return self._near(compared)

    def _near(self, compared: int) -> StencilEngine:
        scene = self._scene.changed(compared=compared, observables=())
        return StencilEngine(scene, replace(self._moving, compared=compared))

    def parts(self) -> tuple[StencilEngine, StencilEngine] | None:
        """Engines of a part that stands for all cells, if any, and of all of them, judged there."""
        part = part_of(self._scene, self._moving)
        if part is None:
            return None
        return self._near(part), StencilEngine(self._scene, self._moving, part)

    def run(self, choices: Choices, shown: bool, progress: Progress) -> Trial:
        """A run; on a ring that proves not to be causal, another one on a wider ring."""
        while True:
            trial = self._run(choices, shown, progress)
            strain = np.array([trial.payload.attrs[key] for key in ("least_strain", "most_strain")])
            if trial.values is None or not choices.causal:
                return trial
            bounds = replace(self._bounds, strain=strain)
            least = least_sites(self._moving, "ring", bounds)
            if choices.size >= least:
                return trial
            if least > RUNAWAY * choices.size:
                return replace(trial, values=None)
            choices = replace(choices, size=_checked(least))
            self._met.append(strain)

    def control(self, choices: Choices, kinds: Collection[Kind]) -> Choices:
        """A shorter step, a wider window; a ring, which is causal anyway, varies with the step.

        The ring is wider than it must be, or as it must be if it was wider before.
        """
        if "step" in kinds:
            step = shorter_step(self._stops, choices.step, self.order, STEP_RATIO)
            choices = replace(choices, step=step)
            if choices.causal:
                wider = WIDER if choices.size == self._ring else 0
                choices = replace(choices, size=self._ring + wider)
        if "domain" in kinds and not choices.causal:
            choices = self._sized(choices, SIZE_RATIO * choices.size)
        return choices

    def improved(self, choices: Choices, kind: Kind, excess: float) -> Choices:
        """By the laws of the scheme's order and of the window's size."""
        if kind == "step":
            return super().improved(choices, kind, excess)
        if choices.causal:
            return choices
        return self._sized(choices, widened(choices.size, excess, self.decay))

    def work(self, choices: Choices) -> float:
        """Site updates."""
        steps = self._moving.duration / choices.step
        return steps * self._base.discretisation.table.stages * choices.size

    def _sized(self, choices: Choices, sites: float) -> Choices:
        """With that many sites, or a causal ring if that takes fewer."""
        strain = np.concatenate([self._bounds.strain, *self._met])
        bounds = replace(self._bounds, strain=strain)
        causal = least_sites(self._moving, "ring", bounds)
        if not choices.causal and sites >= causal:
            self._ring = _checked(causal)
            return replace(choices, size=self._ring, causal=True)
        return replace(choices, size=_checked(round_up(sites)))

    def _run(self, choices: Choices, shown: bool, progress: Progress) -> Trial:
        samples = Samples(self._times, lambda view: np.array(view.numerics[:, self._judged]))
        looked = (shown or choices.causal) and not choices.nudged
        domain = "closed_ring" if choices.causal else "window"
        scheme = self._base.discretisation.scheme
        eps = self._scene.eps * (1.0 + NUDGE * choices.nudged)
        base = self._base
        if choices.nudged:  # at the same times and sites
            same = {key: getattr(base, key) for key in ("t0", "snapshots", "compared")}
            base = base.changed(eps=eps, **same)
        stated = replace(
            base,
            numerics=Discretisation(choices.step, domain, int(choices.size), scheme),
            observables=base.observables if looked else (),
        )
        stopped = False
        try:
            sites = ChainSites(stated, replace(self._moving, eps=eps))
            run = run_from(sites, None, progress, [samples])
        except UnfinishedRun as stop:
            run, stopped = stop.record, True
        steps, size = run.attrs["force_evaluations"], run.attrs["sites"]
        values = None
        if not run.attrs["blow_up"]:
            values = np.array(samples.samples) / self._scene.eps
        largest = max(abs(run.attrs["least_strain"]), abs(run.attrs["most_strain"]))
        rounding = rounding_error(largest / self._scene.eps, steps)
        if values is not None:
            rounding += clock_error(values, self._moving.speed, (stated.t0, stated.end))
        seconds = float(run.attrs["seconds"])
        seen = bool(stated.observables)
        trial = Trial(choices, values, float(steps) * size, seconds, rounding, run, seen)
        if stopped:
            raise StoppedTrial(trial)
        return trial


def _checked(sites: int) -> int:
    most = current_limits().memory_bytes / SITE_BYTES
    if sites <= most:
        return sites
    raise ValueError(
        f"snapshots, compared and tolerance must ask for at most {most:.3g} sites with engine "
        f"'stencil', got {sites} (end earlier, compare fewer or take engine 'spectral')"
    )


START_SECONDS = 0.03
"""Before the first step, measured with the planning."""

SECONDS_PER_UPDATE = 6e-10
"""Seconds per site and force evaluation, measured with the planning."""

SITE_BYTES = 130.0
"""Of a run, for each site: 90 at ten million of them, with what it is compared with at a time."""


@lru_cache(maxsize=4)
def stencil_cost(scene: Scene) -> ExpectedCost:
    """What a window takes, or on a periodic background a ring: the first run, the widest one."""
    moving = scene.moving_wave
    scheme, bounds = scheme_named(PREFERRED), find_bounds(moving, scene.target.tolerance)
    steps = moving.duration / longest_step(scene.model, scheme, bounds)
    kind = domain_kind(scene, moving)
    sites = least_sites(moving, kind, bounds)
    seconds = START_SECONDS + SECONDS_PER_UPDATE * steps * scheme.stages * sites
    part = part_of(scene, moving)
    if part is not None:
        once = seconds * (1.0 / USUAL_WORK + part / scene.compared)
        return ExpectedCost(once, SITE_BYTES * sites)
    most = sites + WIDER if kind == "ring" else round(4.0 * SIZE_RATIO * sites)
    return ExpectedCost(seconds, SITE_BYTES * 2.0 * most)
