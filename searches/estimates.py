"""The search for dishonest estimates: random scenes, each judged by a causal reference.

Run: ``python -m searches.estimates --output FILE`` (2000 scenes, up to an hour on two cores). The
file keeps one line of JSON a scene; begun again with the same file, the search goes on where it was
stopped. ``--only INDEX`` judges one scene and shows it. Exit status 1 if a scene is dishonest, or
ends without an answer or a reason.
"""

import argparse
import os
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from longwave.reports.studies.estimates import (
    QUANTILES,
    VERDICTS,
    Judged,
    estimate_rows,
    judged_scenes,
)
from longwave.support.processes import Job, LocalWorkers, as_ended
from searches.estimate_judge import judge, warm_up
from searches.estimate_scenes import random_scene


def main() -> int:
    """Judge the scenes and print the table."""
    options = _options()
    if options.only is not None:
        print(random_scene(options.seed, options.only).scene)
        one = judge(options.seed, options.only)
        print(one.json())
        return 0 if one.sound else 1
    found = {one.index: one for one in _known(options.output, options.seed)}
    missing = [index for index in range(options.count) if index not in found]
    begun, cut = time.perf_counter(), ""
    try:
        for one in _judged(options.seed, missing, options.workers):
            found[one.index] = one
            _keep(options.output, one)
            _tell(one, len(found), options.count)
    except KeyboardInterrupt:
        cut = f", interrupted after {len(found)} of {options.count}"
    judged = [found[index] for index in sorted(found) if index < options.count]
    _print_table(judged)
    print(f"{time.perf_counter() - begun:.0f} s with {options.workers} workers{cut}")
    if cut:
        return 130
    return 0 if all(one.sound for one in judged) else 1


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--count", type=int, default=2000, help="scenes (2000)")
    parser.add_argument("--seed", type=int, default=1, help="of the random scenes (1)")
    parser.add_argument("--workers", type=int, default=2, help="processes (2)")
    parser.add_argument("--output", type=Path, help="keep what is found here, a line a scene")
    parser.add_argument("--only", type=int, metavar="INDEX", help="judge this scene alone")
    return parser.parse_args()


def _judged(seed: int, indices: list[int], workers: int) -> Iterator[Judged]:
    """Yield the scenes' records as they come."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # else its idle threads use up the limits
    jobs = ((index, Job(judge, (seed, index))) for index in indices)
    for _, call in as_ended(jobs, LocalWorkers(workers, warm_up)):
        yield call.result()


def _known(path: Path | None, seed: int) -> list[Judged]:
    if path is None or not path.exists():
        return []
    return [one for one in judged_scenes(path) if one.seed == seed]


def _keep(path: Path | None, one: Judged) -> None:
    if path is not None:
        with path.open("a", encoding="utf-8") as file:
            file.write(one.json() + "\n")


def _tell(one: Judged, done: int, count: int) -> None:
    """Print a line on stderr for a scene that is not sound, and for every fiftieth."""
    if not one.sound or one.verdict == "undecided":
        print(
            f"{one.verdict}: scene {one.seed}:{one.index} ({one.wave}, {one.engine or one.asked}): "
            f"estimate {one.estimate:.2g}, true {one.true:.2g} {one.reason[:70]}",
            file=sys.stderr,
        )
    elif done % 50 == 0:
        print(f"{done} of {count}", file=sys.stderr)


def _print_table(judged: list[Judged]) -> None:
    heads = " ".join(f"{verdict:>11}" for verdict in VERDICTS)
    shares = " ".join(f"{'max' if q == 1 else f'{q:.0%}':>8}" for q in QUANTILES)
    print(f"{'':22} {'scenes':>6} {heads} {shares} {'seconds':>8}   (true/estimate)")
    for row in estimate_rows(judged):
        counts = " ".join(f"{count:11}" for count in row.verdicts.values())
        quantiles = " ".join(f"{quantile:8.2g}" for quantile in row.quantiles.values())
        print(f"{row.name:22} {row.count:6} {counts} {quantiles} {row.seconds:8.0f}")
    missed = sum(one.estimate > one.tolerance for one in judged)
    print(f"estimates above their tolerance: {missed}")
    print(f"drawn anew for the budget: {sum(one.redrawn for one in judged)}")
    reasons = Counter(one.kind for one in judged if one.reason)
    for kind, count in reasons.most_common():
        print(f"{count:6}  {kind}")


if __name__ == "__main__":
    sys.exit(main())
