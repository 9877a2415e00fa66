"""Whether estimates of runs of random chains bound their errors: a search at any length.

Each case is a random lattice, state, ring, tolerance (`searches.random_chains`), judged by
DOP853. Prints cases whose estimate is too small, and how many there were of each kind.
"""

import argparse
import sys
import warnings
from collections import Counter

from searches.random_chains import judge


def main() -> int:
    """Judge them; 1 if an estimate was too small."""
    parser = argparse.ArgumentParser(description="Search for estimates that are too small.")
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--count", type=int, default=1000)
    chosen = parser.parse_args()
    warnings.simplefilter("ignore", RuntimeWarning)
    kinds: Counter[str] = Counter()
    worst = 0.0
    for seed in range(chosen.first, chosen.first + chosen.count):
        found = judge(seed)
        kinds[found.kind] += 1
        if found.kind == "sound":
            worst = max(worst, found.ratio)
        elif found.kind == "too small":
            print(f"case {seed}: the error is {found.ratio:.3g} times the estimate", flush=True)
    print(*(f"{kind}: {count}" for kind, count in kinds.items()), sep=", ")
    print(f"largest share of an estimate: {worst:.2g}")
    return int(kinds["too small"] > 0)


if __name__ == "__main__":
    sys.exit(main())
