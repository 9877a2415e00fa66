"""Durations of derivations of large cells: those that took over a minute, five runs each.

Run ``python benchmarks/derivations.py [CASE ...]`` from the top folder: for each case the seconds
of processor time of each run, and by the clock, each in a process of its own; nothing is kept.
``--runs N`` takes another number of runs.
"""

import argparse
import subprocess
import sys
from pathlib import Path

HOUSE = Path(__file__).parents[1]

RUN = """
import sys, time
from tests.derive.large_cells import CASES
work, begun = CASES[sys.argv[1]], time.perf_counter()
used = time.process_time()
work()
print(f"{time.process_time() - used:.2f} {time.perf_counter() - begun:.2f}")
"""


def main() -> int:
    """Print the table."""
    sys.path.insert(0, str(HOUSE))
    from tests.derive.large_cells import CASES

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", choices=[*CASES, []], metavar="CASE")
    parser.add_argument("--runs", type=int, default=5)
    chosen = parser.parse_args()
    for name in chosen.cases or CASES:
        runs = [_seconds(name) for _ in range(chosen.runs)]
        used, passed = ("  ".join(times) for times in zip(*runs, strict=True))
        print(f"{name}\n  processor {used}\n  clock     {passed}", flush=True)
    return 0


def _seconds(name: str) -> list[str]:
    """Return seconds of processor time, and by the clock."""
    command = [sys.executable, "-P", "-c", RUN, name]
    ended = subprocess.run(command, cwd=HOUSE, capture_output=True, text=True, check=True)
    return ended.stdout.split()


if __name__ == "__main__":
    sys.exit(main())
