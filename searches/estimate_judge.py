"""The judge of estimates: the true error of a run, against a causal reference.

The true error is the largest difference of y/eps to the reference over the snapshots and
the compared sites. The reference's own error is what a change of its step by `RATIO` changes; its
domain makes none. A run is dishonest if its true error exceeds its estimate by more than the
reference may err.
"""

import math
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from longwave.reports.studies.estimates import MAX_REFERENCE_ERROR, Judged
from longwave.scenes import run
from longwave.scenes.description.entries import table
from longwave.scenes.description.numerics import EngineRules
from longwave.scenes.description.scene import Scene
from longwave.support.processes import OutOfTime, time_limit
from searches.causal_reference import CausalReference, SoftenedError
from searches.estimate_scenes import RandomScene, random_scene

Array = NDArray[np.float64]

RATIO = 0.72
"""Step of the reference, in units of the one before it."""

FIRST, SHORTEST = 0.65, 0.02
"""Longest and shortest step of the references, in units of the stability limit."""

FINE = 0.3
"""Shortest step of a reference's first run: shorter ones may leave but rounding, whose sign does
not vary, so that two runs differ by less than either errs."""

ROUNDED = 1e-9
"""Part of max|Y| above which it is not rounding that separates two references."""

PARTED = 2.0
"""What rounding does to one of two runs, in units of their difference."""

ORDER = 6
"""By which the reference's error is foreseen (and never measured)."""

ROUNDING = 4 * 2.0**-52
"""Part of max|Y| that the reference is not trusted with, whatever its step."""

FLOOR = 1e-12
"""Part of max|Y| below which a reference's error is good enough for any estimate."""

NOTHING = 1e-300
"""Least error of a reference that is foreseen: where nothing moves there is none."""

UPDATE = 4e-10
"""Seconds per site and force evaluation of a reference."""

REFERENCE_SECONDS = 30.0
"""Predicted seconds beyond which a reference is not refined."""

ANSWER_SECONDS = 20.0
"""Processor seconds after which a run counts as one without an answer."""


@dataclass(frozen=True)
class _Answer:
    strain: Array | None
    engine: str
    estimate: float
    reason: str
    ended: bool = True


def warm_up() -> None:
    """Run both engines on both kinds of background: compiling is then no part of a scene's time."""
    for wave in ("rational_1", "wave_cn"):
        for engine in table(EngineRules):
            run(
                Scene.of(
                    name="warm-up",
                    wave=wave,
                    eps=0.05,
                    t0=0.0,
                    snapshots=(10.0,),
                    K2=1.0,
                    K4=1.0,
                    compared=30,
                    parameters=() if wave == "rational_1" else (("k", 0.5),),
                    tolerance=1e-3,
                    engine=engine,
                )
            )


def judge(seed: int, index: int) -> Judged:
    """Run the random scene (seed, index) and judge its estimate."""
    return judge_scene(random_scene(seed, index))


def judge_scene(drawn: RandomScene, answer: Callable[[Scene], xr.Dataset] | None = None) -> Judged:
    """Judge a scene; ``answer`` runs it in the place of `scenes.run`."""
    scene = drawn.scene
    begun = time.process_time()
    given = _answer(scene, answer)
    between = time.process_time()
    verdict, true, own = _verdict(scene, given)
    return Judged(
        drawn.seed,
        drawn.index,
        scene.wave_name,
        scene.target.engine,
        given.engine,
        scene.target.tolerance,
        verdict,
        given.estimate,
        true,
        own,
        given.reason,
        between - begun,
        time.process_time() - between,
        drawn.redrawn,
        scene.json(),
    )


def _answer(scene: Scene, answer: Callable[[Scene], xr.Dataset] | None) -> _Answer:
    """Return the program's answer, without its warnings."""
    begun = time.process_time()

    def watch(_: float) -> None:
        if time.process_time() - begun > ANSWER_SECONDS:
            raise OutOfTime

    try:
        with time_limit(ANSWER_SECONDS), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = run(scene, watch) if answer is None else answer(scene)
    except ValueError as error:
        return _Answer(None, "", math.nan, str(error))
    except OutOfTime:
        return _Answer(None, "", math.nan, f"no end within {ANSWER_SECONDS:g} s", ended=False)
    except Exception as error:
        return _Answer(None, "", math.nan, f"{type(error).__name__}: {error}", ended=False)
    estimate, reason = float(found.attrs["error_estimate"]), str(found.attrs["blow_up"])
    strain = np.asarray(found["strain"]) if "strain" in found else None
    return _Answer(strain, str(found.attrs["engine"]), estimate, reason)


def _verdict(scene: Scene, given: _Answer) -> tuple[str, float, float]:
    """Return the verdict, the true error and the reference's."""
    nothing = given.strain is None or not given.strain.size
    if not given.ended or (not given.reason and not math.isfinite(given.estimate)):
        return "no answer", math.nan, math.nan
    if "\n" in given.reason:
        return "no answer", math.nan, math.nan
    if nothing or (given.reason and not math.isfinite(given.estimate)):
        alarm = "blow-up" in given.reason and not _softens(scene)
        return ("false alarm" if alarm else "refused"), math.nan, math.nan
    assert given.strain is not None
    try:
        true, own, good = _true_error(scene, given.strain, given.estimate)
    except SoftenedError:
        return ("refused" if given.reason else "dishonest"), math.inf, math.nan
    if not true - own <= given.estimate:
        return "dishonest", true, own
    if given.reason:
        return "false alarm", true, own
    return ("honest" if good or true + own <= given.estimate else "undecided"), true, own


def _softens(scene: Scene) -> bool:
    """Return whether waves cease to exist in the reference, too."""
    reference = CausalReference(scene)
    try:
        reference.run(FIRST * reference.longest_step)
    except SoftenedError:
        return True
    return False


def _true_error(scene: Scene, strain: Array, estimate: float) -> tuple[float, float, bool]:
    """Return the largest difference of y/eps to the reference, its error, and whether that is good.

    Where a shorter step makes the reference worse, rounding is what is left.
    """
    reference = CausalReference(scene)
    accuracy = MAX_REFERENCE_ERROR * max(estimate, 1e-13)
    share = max(FINE, FIRST * min(1.0, accuracy / 1e-6) ** (1.0 / (ORDER + 1)))
    coarse = reference.run(share * reference.longest_step).strain
    largest = float(np.max(np.abs(coarse))) / scene.eps
    accuracy = max(MAX_REFERENCE_ERROR * estimate, FLOOR * largest)
    shorter, best = RATIO, (math.inf, math.inf)
    while True:
        share *= shorter
        fine = reference.run(share * reference.longest_step).strain
        own = ROUNDING * largest + float(np.max(np.abs(fine - coarse))) / scene.eps
        true = float(np.max(np.abs(strain - fine[: len(strain)]))) / scene.eps
        worse, best = best[0] <= min(own, ROUNDED * largest), min(best, (own, true))
        clear = own <= MAX_REFERENCE_ERROR * (true - estimate)
        shorter = min(RATIO, 0.9 * (accuracy / max(own, NOTHING)) ** (1.0 / ORDER))
        step = share * shorter * reference.longest_step
        dear = UPDATE * reference.evaluations(step) > REFERENCE_SECONDS
        if own <= accuracy or clear or dear or worse or share < SHORTEST:
            good = best[0] <= accuracy
            return best[1], best[0] if good else PARTED * best[0], good
        coarse = fine
