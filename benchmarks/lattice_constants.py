"""Measurements behind the constants of the lattice's kernels and absorbers, in a minute.

Kernels: processor time of a ring of 4096 sites with other blocks, in units of that with the ones
that are chosen, and the elapsed time of long rings on one core in units of that on two; the time
and the memory of large planes. Absorbers:
how much of a wave packet is left after one passage of the seam.
"""

import math
import resource
import sys
import time
from collections.abc import Callable
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray
from problem import PROBLEMS

from longwave.lattice.kernels import ring_kernel
from longwave.lattice.kernels.ring_kernel import RingKernel
from longwave.lattice.model import Model
from longwave.lattice.schemes import REDUCED_PHASE_6
from longwave.lattice.spectral import absorber
from longwave.lattice.spectral.evolution import SpectralRing
from longwave.lattice.spectral.field_ring import FieldRing

Array = NDArray[np.float64]
ROUNDS = 15
LINEAR, CUBIC = Model(1.0, 0.0, 0.0), Model(1.0, 0.0, 1.0)


def advanced(shape: tuple[int, ...], steps: int, **constants: int) -> Callable[[], None]:
    """Advance a chain or plane of that shape by the kernel with these constants."""
    lattice = CUBIC.lattice if len(shape) == 1 else PROBLEMS["square"].lattice
    kernel = RingKernel(lattice, *shape)
    ring = 0.01 * np.random.default_rng(0).standard_normal((2, 1, *shape))
    work = 0.2 * REDUCED_PHASE_6.drifts, 0.2 * REDUCED_PHASE_6.kicks
    ring_kernel._machine_code.cache_clear()

    def advance() -> None:
        with patch.multiple(ring_kernel, **constants):
            kernel.advance(*ring, *work, steps)

    advance()
    return advance


def seconds(advance: Callable[[], None], clock: Callable[[], float]) -> float:
    """Return the duration of the shortest of ``ROUNDS`` runs."""
    taken = []
    for _ in range(ROUNDS):
        begun = clock()
        advance()
        taken.append(clock() - begun)
    return min(taken)


def print_blocks() -> None:
    """Print the time of kernels with other blocks."""
    for name, shape, values in (
        ("BLOCK_ROWS", (4096,), (64, 128, 512)),
        ("MAX_STAGES", (4096,), (13, 52)),
        ("PLANE_BLOCK_ROWS", (64, 64), (1, 2, 16)),
        ("CACHED_DOUBLES", (512, 2048), (16_384, 32_768, 131_072)),
    ):
        steps = max(4, 1_600_000 // math.prod(shape))
        whole, *shares = (
            seconds(advanced(shape, steps, **{name: value}), time.thread_time)
            for value in (getattr(ring_kernel, name), *values)
        )
        shares = [share / whole for share in shares]
        entries = ", ".join(f"{v}: {share:.2f}" for v, share in zip(values, shares, strict=True))
        print(f"{name} = {getattr(ring_kernel, name)} takes 1.00; {entries}")


def print_cores() -> None:
    """Print the time on one core against that on two."""
    for size in (8192, ring_kernel.MIN_SHARED_VALUES, 65_536, 10**6, 10**7):
        steps = max(2, 2_000_000 // size)
        one, two = (
            seconds(advanced((size,), steps, MIN_SHARED_VALUES=least), time.perf_counter)
            for least in (2 * size, 1)
        )
        print(f"{size} cells: two cores are {one / two:.2f} times as fast as one")


def print_planes() -> None:
    """Print the time on planes within the caches and beyond."""
    for side, steps in ((64, 64), (256, 64), (1024, 4), (3163, 2)):
        taken = seconds(advanced((side, side), steps, MIN_SHARED_VALUES=10**9), time.thread_time)
        updates = steps * REDUCED_PHASE_6.stages * side**2
        print(f"{side} x {side} cells: {taken / updates * 1e9:.2f} ns a cell and stage")
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(f"all of the process: {1024 * most / side**2:.0f} bytes a cell of the last")


def left_of(wave_number: float, direction: float, **absorbing: float) -> float:
    """Return the share of a packet's largest strain that is left after one turn of the ring."""
    length, count, width = 600.0, 2400, 25.0
    x = length * (np.arange(count) / count - 0.5)
    modes = np.fft.fft(np.exp(-((x / width) ** 2)) * np.exp(1j * wave_number * x))
    k = 2.0 * np.pi * np.fft.fftfreq(count, length / count)
    w = 2.0 * np.sin(0.5 * np.abs(k)) * np.sign(k)
    s = np.fft.ifft(-1j * direction * w * modes).real
    state = FieldRing(0.0, (-0.5 * length,), (length,), np.fft.ifft(modes).real[None], s[None])
    speed = direction * math.cos(0.5 * wave_number) - 1.0
    end = SpectralRing(LINEAR, state, 0.5, **absorbing).at(length / abs(speed))
    return float(np.max(np.abs(end.f - np.mean(end.f))))


def print_absorbers() -> None:
    """Print what other absorbers leave of waves to the left, and of short waves to the right."""
    usual = absorber.ABSORBER_STRENGTH
    for name, packet, absorbing in (
        ("ABSORBER_WIDTH", (0.1, -1.0), {"absorbed": 1.0}),
        ("SHORT_ABSORBER_WIDTH", (1.5, 1.0), {"short": 0.75}),
    ):
        chosen = getattr(absorber, name)
        for factor in (0.5, 1.0, 2.0):
            setattr(absorber, name, factor * chosen)
            left = {
                f"{share * usual:g}": left_of(*packet, **absorbing, strength=share * usual)
                for share in (0.5, 1.0, 2.0)
            }
            entries = ", ".join(f"{strength}: {part:.0e}" for strength, part in left.items())
            print(f"{name} = 1/{1 / (factor * chosen):g}; left at a strength of {entries}")
        setattr(absorber, name, chosen)


def main() -> int:
    """Print all of it."""
    print_blocks()
    print_planes()
    print_cores()
    print_absorbers()
    return 0


if __name__ == "__main__":
    sys.exit(main())
