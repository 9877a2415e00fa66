"""Durations of derivations: every known long-wave limit, envelopes, and the catalogue's checks.

Run ``python benchmarks/reductions.py`` from the top folder: a table of row, seconds of processor
time, and whether the coefficients are symbolically those that are known. ``--checks`` adds the
self-checks of every lattice in the catalogue, a few minutes. Exit status 1 if anything differs.
"""

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from longwave.derive import (
    LATTICES,
    checks_of_envelope,
    checks_of_reduction,
    envelope,
    find_scaling,
)
from tests.derive.known_envelopes import KNOWN
from tests.derive.known_reductions import all_rows


def main() -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--checks", action="store_true", help="the catalogue's self-checks too")
    chosen = parser.parse_args()
    print(f"{'row':42} {'seconds':>8}  equal")
    agree = True
    for name, differences in _rows():
        agree &= _told(name, lambda differences=differences: not differences())
    if chosen.checks:
        print(f"\n{'self-checks':42} {'seconds':>8}  agree")
        for name, checked in _checks():
            agree &= _told(name, checked)
    return not agree


def _told(name: str, work: Callable[[], bool]) -> bool:
    begun = time.process_time()
    try:
        good, message = work(), ""
    except ValueError as error:
        good, message = False, f" {error}"
    print(
        f"{name:42} {time.process_time() - begun:8.2f}  {'yes' if good else 'NO'}{message}",
        flush=True,
    )
    return good


def _rows() -> Iterator[tuple[str, Callable[[], list[str]]]]:
    for row in all_rows():
        yield f"{row.name} {row.kind}", lambda row=row: list(row.differences())
    for name, differences in KNOWN.items():
        yield f"envelope of {name}", differences


def _checks() -> Iterator[tuple[str, Callable[[], bool]]]:
    for name, lattice in LATTICES.items():
        try:
            found = find_scaling(lattice)
        except ValueError:
            found = ()
        for reduction in found:
            yield (
                f"{name}, {reduction.pde.kind}",
                lambda reduction=reduction: all(c.passed for c in checks_of_reduction(reduction)),
            )
        if lattice.dimension == 1:
            yield (
                f"{name}, envelope",
                lambda lattice=lattice: all(
                    c.passed for c in checks_of_envelope(envelope(lattice))
                ),
            )


if __name__ == "__main__":
    sys.exit(main())
