"""Share of measured rates whose interval contains theory's: every case of the full report.

    python -m searches.rates
    python -m searches.rates --only 5e --only "bright, strain"

Each row: the case, the order of its data, the rate with its interval, theory's. Exit status 1 if
fewer than nine of ten are held. About ten minutes.
"""

import argparse
import sys

from longwave.reports.studies.lattice_runs import rate_jobs

HELD = 0.9


def main() -> int:
    """Measure, print, count."""
    parser = argparse.ArgumentParser(description="Rates of lattices near their limits.")
    parser.add_argument("--only", action="append", default=[], metavar="CASE")
    chosen = set(parser.parse_args().only)
    covered = []
    for job in rate_jobs(full=True).values():
        name, order = job.arguments
        if chosen and name not in chosen:
            continue
        found = job.function(*job.arguments)
        covered.append(found.reached)
        note = "" if found.reached else "  NOT HELD"
        print(f"{name:28} {order:10} {found.rate!s:18} {found.theory}{note}", flush=True)
    print(f"theory's rate is held in {sum(covered)} of {len(covered)}")
    return int(sum(covered) < HELD * len(covered))


if __name__ == "__main__":
    sys.exit(main())
