"""Soak: random scenes of both kinds end with a result within their tolerance, or with a reason.

Every second scene is one of the paper's chain (`reports/studies/estimate_scenes.py`), the others
are on the lattices of the catalogue (`searches/soak_scenes.py`).  One in ``--every`` is judged:
on the paper's chain by the causal reference, which shares no domain with it and whose error is
measured; on another lattice by a second run to a hundredth of the tolerance.

    python -m searches.soak [--count 1000] [--seed 1] [--start 0] [--every 5]

A scene is "no answer" if it takes more than 20 s of the processor, or three times what it said
before if that is more, or ends in anything but a ValueError of one line.  The exit status is 1 if
there is one, or an error above its estimate.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from longwave.scenes import run
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.lattice_run import record_scene
from longwave.scenes.engines.sideband_growth import measure_growth
from longwave.support.processes import OutOfTime, time_limit
from longwave.support.request_limits import Cancelled
from searches.estimate_judge import ANSWER_SECONDS, judge_scene, warm_up
from searches.estimate_scenes import random_scene
from searches.soak_scenes import soak_scene

BUDGET = 2.0
"""Expected seconds beyond which a scene of another lattice is drawn anew."""

TIGHTER = 0.01
"""The second run's tolerance, in units of the first one's."""

LATE = 3.0
"""Times what a scene said it would take, in which it must end."""

LEAST = 1e-11
SAID = 60.0


class Measured(NamedTuple):
    """Values of a run of another lattice, the unit of its error, and the error's estimate."""

    values: NDArray[np.float64]
    scale: float
    estimate: float


@dataclass(frozen=True)
class Soaked:
    """Ending of a scene: "result", "refused", "above its tolerance", "no answer" or "dishonest"."""

    ending: str
    reason: str = ""
    judged: bool = False
    seconds: float = 0.0

    @property
    def good(self) -> bool:
        """Whether it ended as it should."""
        return self.ending in ("result", "refused")


def soaked(seed: int, index: int, judging: bool) -> Soaked:
    """Run the scene of (seed, index), and judge it if that is wanted."""
    begun = time.process_time()
    ending, reason, judged = (_of_chain if index % 2 else _of_lattice)(seed, index, judging)
    return Soaked(ending, reason, judged, time.process_time() - begun)


def _of_chain(seed: int, index: int, judging: bool) -> tuple[str, str, bool]:
    drawn = random_scene(seed, index)
    if not judging:
        reported = [0.0]

        def work() -> tuple[str, str]:
            ran = run(drawn.scene, announce=reported.append)
            return _of_data(ran.attrs, drawn.scene.target.tolerance)

        ending = _ended(work)
        if ending[0] == "no answer" and LATE * max(reported) > ANSWER_SECONDS:
            ending = _ended(work, LATE * max(reported))
        return *ending, False
    found = judge_scene(drawn)
    if found.verdict in ("dishonest", "no answer", "refused"):
        return found.verdict, found.reason or f"{found.true:g} > {found.estimate:g}", True
    if found.verdict == "false alarm":
        return "refused", found.reason, False
    above = found.estimate > found.tolerance
    return "above its tolerance" if above else "result", "", found.verdict == "honest"


def _of_data(attributes: dict[str, object], tolerance: float) -> tuple[str, str]:
    estimate, reason = float(str(attributes["error_estimate"])), str(attributes["blow_up"])
    if reason:
        return "refused", reason
    return _within(estimate, tolerance)


def _within(estimate: float, tolerance: float) -> tuple[str, str]:
    good = math.isfinite(estimate) and estimate <= tolerance
    return "result" if good else "above its tolerance", "" if good else f"{estimate:g}"


def _of_lattice(seed: int, index: int, judging: bool) -> tuple[str, str, bool]:
    for redrawn in range(100):
        found: list[Measured] = []
        scene = soak_scene(seed, index, redrawn)
        work = partial(_run, scene, found, BUDGET)
        try:
            ending, reason = _ended(work)
        except Cancelled:
            continue
        if ending != "result" or not judging:
            return ending, reason, False
        return _judged(scene, found[0])
    return "refused", "all that were drawn would take long", False


def _run(scene: Scene, found: list[Measured], budget: float) -> tuple[str, str]:
    def announce(seconds: float) -> None:
        if seconds > budget:
            raise Cancelled

    found.append(_measured(scene, announce))
    return _within(found[-1].estimate, scene.target.tolerance)


def _measured(scene: Scene, announce: Callable[[float], None]) -> Measured:
    if not scene.is_growth:
        ran = record_scene(scene, announce=announce)
        values = ran.values("strains" if "strains" in ran.variables else "strain")
        scale = scene.eps ** ran.attrs["power"]
        return Measured(values, scale, ran.attrs["error_estimate"])
    growth = measure_growth(scene, announce=announce)
    unit = growth.plan.wave.largest_growth
    return Measured(np.array(growth.measured), unit, growth.run_error / unit)


def _judged(scene: Scene, first: Measured) -> tuple[str, str, bool]:
    """Judge a scene's run by a tighter run."""
    tighter = scene.changed(tolerance=max(LEAST, TIGHTER * scene.target.tolerance))
    found: list[Measured] = []
    try:
        ending, _ = _ended(lambda: _run(tighter, found, 10.0 * BUDGET))
    except Cancelled:
        return "result", "", False
    if ending != "result":
        return "result", "", False
    distance = float(np.max(np.abs(first.values - found[0].values))) / first.scale
    if distance > first.estimate + found[0].estimate:
        return "dishonest", f"{distance:g} > {first.estimate:g}", True
    return "result", "", True


def _ended(work: Callable[[], tuple[str, str]], limit: float = ANSWER_SECONDS) -> tuple[str, str]:
    """Return the ending of a run, without its warnings."""
    try:
        with time_limit(limit), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return work()
    except ValueError as error:
        return ("no answer" if "\n" in str(error) else "refused"), str(error)
    except OutOfTime:
        return "no answer", f"no end within {limit:.3g} s"
    except Exception as error:
        return "no answer", f"{type(error).__name__}: {error}"


def main() -> int:
    """Soak and print counts; return 1 if a scene ended otherwise than it should."""
    parser = argparse.ArgumentParser(description="Random scenes end with a result or a reason.")
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--every", type=int, default=5, help="one scene in so many is judged")
    options = parser.parse_args()
    warm_up()
    endings: Counter[str] = Counter()
    reasons: Counter[str] = Counter()
    judged, slowest, last_report = 0, 0.0, time.monotonic()
    for index in range(options.start, options.start + options.count):
        one = soaked(options.seed, index, index // 2 % options.every == 0)
        kind = "paper's chain" if index % 2 else "other lattices"
        endings[f"{kind}: {one.ending}"] += 1
        judged += one.judged
        slowest = max(slowest, one.seconds)
        if one.ending == "refused":
            reasons[one.reason.partition(",")[0][:70]] += 1
        if not one.good:
            print(f"{options.seed}:{index}: {one.ending}: {one.reason[:200]}", flush=True)
        if time.monotonic() - last_report > SAID:
            last_report = time.monotonic()
            print(f"{index + 1 - options.start} scenes, {dict(endings)}", flush=True)
    for text, count in sorted(endings.items()):
        print(f"{count:6} {text}")
    print(f"{judged:6} judged; the slowest took {slowest:.1f} s of the processor")
    for text, count in reasons.most_common(20):
        print(f"{count:6} refused: {text}")
    return int(any(not text.endswith(("result", "refused")) for text in endings))


if __name__ == "__main__":
    sys.exit(main())
