"""A scene with a tolerance by the stencil, in a window that holds the wave or on a causal ring."""

import math
import time
from collections.abc import Collection
from dataclasses import replace

import numpy as np
import xarray as xr

from lattice.refine import SAFETY, Announce, Engine, Kind, StoppedSearch, refine
from lattice.schemes.catalogue import scheme_named
from lattice.trial import NUDGE, Choices, Estimate, StoppedTrial, Trial, clock_error, rounding_error
from solutions import Wave
from verify.comparison.domain import window_moves
from verify.comparison.recording import Progress
from verify.comparison.scene import Scene
from verify.comparison.stencil import (
    PREFERRED,
    StrainSamples,
    domain_kind,
    exact_times,
    extent_of,
    judged_times,
    least_sites,
    longest_step,
    round_up,
    run_from,
    shorter_step,
)
from verify.comparison.unfinished import UnfinishedRun, unfinished
from verify.comparison.wave_bounds import Extent

STEP_RATIO = 0.85
"""Step of a control run, in units of the one before it."""

SIZE_RATIO = 1.3
"""Size of a control run's window."""

WINDOW_SAFETY = 3.0
"""Factor on the difference of two windows, enough where the error falls like 1/size^1.1. That of a
small one fell by a fifth only where it grew by 1.25: it had hardly left the wave, a rational one of
order 5."""

WIDER = 256
"""Sites by which the control run's ring is wider, which is causal as it is."""

DECAY = 5
"""A window's error falls at least like N^-DECAY (measured: between 5.8 and 7.4)."""

CLEARANCE = 128
"""Sites beyond the wave on which runs of a scout are compared."""

REACHES = (0.2, 4.0)
"""Least factor on a step, and largest factor on a size, from one choice to the next."""

MOST_SITES = 2**20
"""Sites of the largest domain: a run takes 230 bytes a site (measured); two are done at once."""

RUNAWAY = 4.0
"""A causal ring whose strains ask for one so many times wider has run away: the step is at fault,
or the lattice."""


def run_stencil(
    scene: Scene, wave: Wave, progress: Progress, announce: Announce
) -> tuple[xr.Dataset, Estimate, float]:
    """The run of a scene to its tolerance, the estimated error, and the seconds of planning.

    The error is infinite if the lattice blows up by itself; what came before is kept. Raises
    ValueError for what wave or lattice do not admit and for a tolerance below what rounding leaves,
    UnfinishedRun on Ctrl-C.
    """
    assert scene.tolerance is not None
    begun = time.perf_counter()
    engine = StencilEngine(scene, wave, extent_of(scene, wave))
    try:
        found = refine(engine, scene.tolerance, progress, announce)
    except StoppedSearch as stop:
        run = None if stop.trial is None else stop.trial.payload
        raise unfinished(run, stop.error, stop.before) from None
    run = found.trial.payload
    if math.isinf(found.error) and not run.attrs["blow_up"]:
        raise ValueError(
            f"snapshots must end before strains run away, got {scene.end:g} (they grew beyond "
            f"{run.attrs['most_strain']:.3g} whatever the step; end earlier or take a smaller eps)"
        )
    planned = time.perf_counter() - begun - found.trial.seconds
    decade = 10.0 ** (1.0 / engine.order)
    if not found.trial.choices.causal:
        decade *= 10.0 ** (1.0 / DECAY)
    return run, Estimate(found.error, found.rounding, decade), planned


class StencilEngine:
    """Runs of a scene in windows or, where the background is not constant, on causal rings."""

    threads = 2
    unstable = 1
    most_work = math.inf

    def __init__(self, scene: Scene, wave: Wave, extent: Extent, compared: int = 0) -> None:
        scheme = scheme_named(scene.scheme or PREFERRED)
        self.order: int = scheme.order
        self._scene, self._wave, self._extent = scene, wave, extent
        self.fragile = wave.wavelength is not None
        self._domain = domain_kind(scene, wave)
        self.kinds: tuple[Kind, ...] = ("step", "domain") if self._domain == "window" else ("step",)
        self.safety = WINDOW_SAFETY if self._domain == "window" else SAFETY
        self._least = _checked(least_sites(scene, wave, self._domain, extent))
        self._longest = longest_step(scene, scheme, extent)
        self._base = replace(
            scene,
            tolerance=None,
            engine="stencil",
            scheme=scheme.name,
            step=self._longest,
            domain=self._domain,
            sites=self._least,
            compared=compared or scene.compared,
        )
        exact = exact_times(self._base)
        self._times = judged_times(scene, exact, self._domain)
        moves = window_moves(scene) if self._domain == "window" else ()
        self._stops = np.array(sorted({scene.t0, *exact, *(t for t in moves if t < scene.end)}))

    def first(self) -> Choices:
        """The longest step and the smallest domain."""
        return Choices(self._longest, self._least, self._domain == "ring")

    def scout(self) -> Engine:
        """The same about the wave alone, if that saves sites."""
        scene = replace(self._scene, compared=1, observables=())
        extent = extent_of(scene, self._wave)
        compared = min(self._scene.compared, extent.reach + CLEARANCE)
        if self._domain == "ring" or compared == self._scene.compared:
            return self
        scene = replace(scene, compared=compared)
        return StencilEngine(scene, self._wave, extent_of(scene, self._wave))

    def run(self, choices: Choices, shown: bool, progress: Progress) -> Trial:
        """A run; on a ring that proves not to be causal, another one on a wider ring."""
        while True:
            trial = self._run(choices, shown, progress)
            strain = np.array([trial.payload.attrs[key] for key in ("least_strain", "most_strain")])
            if trial.values is None or not choices.causal:
                return trial
            extent = replace(self._extent, strain=strain)
            least = least_sites(self._base, self._wave, "ring", extent)
            if choices.size >= least:
                return trial
            if least > RUNAWAY * choices.size:
                return replace(trial, values=None)
            choices, self._extent = replace(choices, size=_checked(least)), extent

    def varied(self, choices: Choices, kinds: Collection[Kind]) -> Choices:
        """A shorter step, a wider window; a ring, which is causal anyway, varies with the step."""
        if "step" in kinds:
            step = shorter_step(self._stops, choices.step, self.order, STEP_RATIO)
            choices = replace(choices, step=step)
            if choices.causal:
                choices = replace(choices, size=choices.size + WIDER)
        if "domain" in kinds and not choices.causal:
            choices = self._sized(choices, SIZE_RATIO * choices.size)
        return choices

    def better(self, choices: Choices, kind: Kind, excess: float) -> Choices:
        """By the laws of the scheme's order and of the window's size."""
        if kind == "step":
            factor = max(REACHES[0], 0.95 * excess ** (-1.0 / self.order))
            return replace(choices, step=factor * choices.step)
        if choices.causal:
            return choices
        factor = min(REACHES[1], max(1.2, 1.05 * excess ** (1.0 / DECAY)))
        return self._sized(choices, factor * choices.size)

    def work(self, choices: Choices) -> float:
        """Site updates."""
        steps = (self._scene.end - self._scene.t0) / choices.step
        return steps * self._base.scheme_table.stages * choices.size

    def _sized(self, choices: Choices, sites: float) -> Choices:
        """With that many sites, or a causal ring if that takes fewer."""
        causal = least_sites(self._base, self._wave, "ring", self._extent)
        if not choices.causal and sites >= causal:
            return replace(choices, size=_checked(causal), causal=True)
        return replace(choices, size=_checked(round_up(sites)))

    def _run(self, choices: Choices, shown: bool, progress: Progress) -> Trial:
        samples = StrainSamples(self._times)
        looked = (shown or choices.causal) and not choices.nudged
        stated = replace(
            self._base,
            eps=self._scene.eps * (1.0 + NUDGE * choices.nudged),
            step=choices.step,
            sites=int(choices.size),
            domain="closed_ring" if choices.causal else "window",
            observables=self._base.observables if looked else (),
        )
        stopped = False
        try:
            run = run_from(stated, None, progress, [samples])
        except UnfinishedRun as stop:
            run, stopped = stop.run, True
        steps, size = run.attrs["force_evaluations"], run.attrs["sites"]
        values = None
        if not run.attrs["blow_up"]:
            values = np.array(samples.samples) / self._scene.eps
        largest = max(abs(run.attrs["least_strain"]), abs(run.attrs["most_strain"]))
        rounding = rounding_error(largest / self._scene.eps, steps)
        if values is not None:
            c, times = stated.constants.sound_speed(), (stated.t0, stated.end)
            rounding += clock_error(values, c, times)
        seconds = float(run.attrs["seconds"])
        seen = bool(stated.observables)
        trial = Trial(choices, values, float(steps) * size, seconds, rounding, run, seen)
        if stopped:
            raise StoppedTrial(trial)
        return trial


def _checked(sites: int) -> int:
    if sites <= MOST_SITES:
        return sites
    raise ValueError(
        f"snapshots, compared and tolerance must ask for at most {MOST_SITES} sites with engine "
        f"'stencil', got {sites} (end earlier, compare fewer or take engine 'spectral')"
    )
