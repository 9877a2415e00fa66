"""Cost of force laws: nanoseconds a cell and stage, as vectors and by the C library.

A chain of 4096 cells with each law; kernels of both kinds run in turn, the least time of each
counts.

    python force_laws.py [--rounds 7] [--stages 2000]
"""

import argparse
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from unittest.mock import patch

import numpy as np
from sympy import Rational, cos, exp, log, sin, sqrt, tanh

from longwave.derive.algebra.contact import contact
from longwave.derive.lattice import Lattice, spring
from longwave.derive.symbols import x
from longwave.lattice.kernels import ring_kernel, row_code
from longwave.lattice.kernels.ring_kernel import RingKernel
from longwave.lattice.numeric_lattice import numeric_lattice
from longwave.support.compiled.native_code import native_functions

CELLS = 4096

LAWS = {
    "cubic": 4 * x + x**3,
    "Toda": exp(x) - 1,
    "Morse": exp(-x) - exp(-2 * x),
    "Hertz": contact(x + Rational(1, 2)) ** Rational(3, 2) - sqrt(2) / 4,
    "power -7": (1 + x) ** -7 - 1,
    "power 1.4": (1 + x) ** Rational(7, 5) - 1,
    "contact 1.4": contact(x + Rational(1, 2)) ** Rational(7, 5) - Rational(1, 2) ** Rational(7, 5),
    "log": log(1 + x),
    "sin": sin(x),
    "cos": 1 - cos(x) + x,
    "tanh": tanh(x),
}


def kernel(force: object, by_library: bool) -> Callable[[int], float]:
    """Return seconds of so many stages of a chain with that force."""
    law = numeric_lattice(
        Lattice("tried", "", ("u",), (1,), (spring(force, ((0,), 0), ((1,), 0)),)), {}
    )
    advance = RingKernel(law, CELLS)
    start = 0.05 * np.sin(np.arange(CELLS) / 10.0)[np.newaxis]

    def run(stages: int) -> float:
        f, v = start.copy(), np.zeros_like(start)
        begun = time.perf_counter()
        advance.advance_stages(f, v, np.full(1, 1e-3), np.full(1, 1e-3), stages)
        return time.perf_counter() - begun

    with written_for(by_library):
        run(1)
    return run


@contextmanager
def written_for(by_library: bool) -> Iterator[None]:
    """Build kernels with the C library's functions in this block, cached under another key."""
    if not by_library:
        yield
        return
    ring_kernel._machine_code.cache_clear()

    def keyed_functions(module: str, key: str, *more: object) -> object:
        return native_functions(module, f"{key} library", *more)

    with (
        patch.object(ring_kernel, "native_functions", keyed_functions),
        patch.object(row_code, "FUNCTIONS_OF_LANES", {}),
        patch.object(
            row_code, "power", lambda x, p: x.with_value(x.code.function("pow", x.value, x.of(p)))
        ),
    ):
        yield
    ring_kernel._machine_code.cache_clear()


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="What force laws cost.")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--stages", type=int, default=2000)
    options = parser.parse_args()
    runs = {name: [kernel(law, by) for by in (True, False)] for name, law in LAWS.items()}
    least = {name: [np.inf, np.inf] for name in runs}
    for _ in range(options.rounds):
        for name, pair in runs.items():
            for place, run in enumerate(pair):
                least[name][place] = min(least[name][place], run(options.stages))
    cubic = least["cubic"][1]
    print(
        "ns a cell and stage: by the library, as vectors; their ratio; over that of a cubic force"
    )
    for name, (by, own) in least.items():
        unit = CELLS * options.stages * 1e-9
        print(f"{name:12s} {by / unit:7.2f} {own / unit:7.2f} {by / own:7.1f} {own / cubic:7.1f}")


if __name__ == "__main__":
    main()
