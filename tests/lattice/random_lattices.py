"""Random lattices, states and reference solutions, for searches over all engines."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from longwave.lattice.force_program import ForceProgram, force_program
from longwave.lattice.numeric_lattice import Entry, NumericBond, NumericLattice

Array = NDArray[np.float64]
Random = np.random.Generator


def random_force(random: Random, size: float, stiffness: float) -> ForceProgram:
    """Return a random force whose nonlinear part matters at stretches of that size."""
    from sympy import Float, Rational, exp, sin

    from longwave.derive.symbols import x

    kind = random.choice(["polynomial", "polynomial", "linear", "toda", "sine", "hertz"])
    K, scale = Float(stiffness), Float(random.choice([0.3, 1.0]) / size)
    if kind == "toda":
        return force_program(K / scale * (exp(scale * x) - 1))
    if kind == "sine":
        return force_program(K / scale * sin(scale * x))
    if kind == "hertz":
        gap = 20 / scale
        return force_program(
            Float(2 / 3) * K * gap ** Rational(-1, 2) * (gap ** Rational(3, 2) - (gap - x) ** 1.5)
        )
    if kind == "linear":
        return ForceProgram((stiffness,))
    others = random.uniform(-0.4, 0.4, int(random.integers(1, 4))) * random.integers(0, 2)
    powers = size ** -np.arange(1.0, 1.0 + others.size)
    return ForceProgram((stiffness, *(stiffness * others * powers).tolist()))


def random_lattice(random: Random, size: float, axes: int = 1) -> NumericLattice:
    """Return a random lattice of masses and springs, some tied to their sites, or of strains.

    It has up to three fields and a reach of up to three cells. ``size`` is that of the stretches.
    """
    unit = 10.0 ** random.uniform(-1, 1)
    if random.random() < 0.2:
        return _strains(random, size, unit, axes)
    fields = int(random.choice([1, 1, 2, 3]))
    masses = tuple(random.uniform(0.3, 3.0, fields).tolist())
    bonds = []
    for field in range(fields):
        cells = np.zeros(axes, dtype=int)
        cells[0] = field == fields - 1
        bonds.append(_spring(random, size, unit, field, (field + 1) % fields, cells))
    for axis in range(1, axes):
        cells = np.zeros(axes, dtype=int)
        cells[axis] = 1
        bonds.append(_spring(random, size, unit, 0, 0, cells))
    for _ in range(int(random.integers(0, 3))):
        cells = random.integers(-2, 4, axes)
        ends = random.integers(0, fields, 2)
        if np.any(cells) or ends[0] != ends[1]:
            bonds.append(_spring(random, size, 0.3 * unit, *ends, cells))
    if random.random() < 0.3:
        here, field = (0,) * axes, int(random.integers(0, fields))
        force = random_force(random, size, 0.5 * unit)
        bonds.append(NumericBond((Entry(here, 1.0, field),), (Entry(here, -1.0, field),), force))
    return NumericLattice("random", ("u", "v", "w")[:fields], masses, tuple(bonds))


def _spring(
    random: Random, size: float, stiffness: float, first: int, second: int, cells: Array
) -> NumericBond:
    force = random_force(random, size, stiffness * random.uniform(0.3, 1.5))
    here, there = (0,) * len(cells), tuple(int(step) for step in cells)
    back = tuple(-step for step in there)
    return NumericBond(
        (Entry(there, 1.0, int(second)), Entry(here, -1.0, int(first))),
        (Entry(here, 1.0, int(first)), Entry(back, -1.0, int(second))),
        force,
        float(random.choice([0.0, 0.3 * size])),
    )


def _strains(random: Random, size: float, unit: float, axes: int) -> NumericLattice:
    bonds = []
    for axis in range(axes):
        one = tuple(int(other == axis) for other in range(axes))
        here, back = (0,) * axes, tuple(-step for step in one)
        action = (Entry(one, 1.0, 0), Entry(here, -2.0, 0), Entry(back, 1.0, 0))
        force = random_force(random, size, unit)
        bonds.append(NumericBond((Entry(here, 1.0, 0),), action, force))
    return NumericLattice("strains", ("y",), (1.0,), tuple(bonds))


def smooth_or_rough(
    random: Random, size: float, fields: int, counts: Sequence[int], width: float
) -> Array:
    """Return random fields whose spectrum decays over ``width`` modes; inf for white noise."""
    values = size * random.standard_normal((fields, *counts))
    if width == np.inf:
        return 0.3 * values
    axes = tuple(range(1, 1 + len(counts)))
    modes = np.fft.fftn(values, axes=axes)
    for axis, count in enumerate(counts, 1):
        number = np.fft.fftfreq(count, 1.0 / count)
        shape = [-1 if other == axis else 1 for other in range(modes.ndim)]
        modes *= np.exp(-((number / width) ** 2)).reshape(shape)
    found = np.fft.ifftn(modes, axes=axes).real
    largest = float(np.max(np.abs(found)))
    return np.asarray(0.5 * size * found / (largest or 1.0))


def reference(
    lattice: NumericLattice, f: Array, v: Array, times: Sequence[float] | Array
) -> Array | None:
    """Return the fields at the times (from 0 on) by DOP853; None if it stalls or diverges."""
    size = f.size

    def slope(_: float, z: Array) -> Array:
        with np.errstate(all="ignore"):
            pull = lattice.acceleration(z[:size].reshape(f.shape)).ravel()
        return np.concatenate([z[size:], np.nan_to_num(pull, nan=1e300)])

    start = np.concatenate([f.ravel(), v.ravel()])
    scale = max(float(np.max(np.abs(start))), 1e-300)
    with np.errstate(all="ignore"):
        found = solve_ivp(
            slope, (0.0, times[-1]), start, "DOP853", times, rtol=1e-12, atol=1e-14 * scale
        )
    if not found.success or not np.all(np.abs(found.y) < 1e3 * scale):
        return None
    return np.asarray(found.y[:size].T.reshape(-1, *f.shape))
