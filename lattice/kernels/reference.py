"""Reference integrators in NumPy for any scheme and lattice; slower than compiled kernels."""

from __future__ import annotations

from collections.abc import Callable

from longwave.support.real_arrays import Array

Acceleration = Callable[[Array], Array]


def advance_splitting(
    acceleration: Acceleration, f: Array, v: Array, drifts: Array, kicks: Array, steps: int
) -> None:
    """Advance (f, v) in place by a splitting; ``drifts`` and ``kicks`` include the time step."""
    for _ in range(steps):
        for drift, kick in zip(drifts[:-1], kicks, strict=True):
            f += drift * v
            v += kick * acceleration(f)
        f += drifts[-1] * v


def advance_nystroem_method(
    acceleration: Acceleration, f: Array, v: Array, table: tuple[Array, ...], h: float, steps: int
) -> None:
    """Advance (f, v) in place by ``steps`` steps ``h`` of the method with this `NystroemTable`."""
    nodes, inner, outer, weights = table
    for _ in range(steps):
        forces: list[Array] = []
        for node, row in zip(nodes, inner, strict=True):
            stage = f + node * h * v
            for weight, force in zip(row, forces, strict=False):
                stage += weight * h * h * force
            forces.append(acceleration(stage))
        f += h * v
        for out, weight, force in zip(outer, weights, forces, strict=True):
            f += out * h * h * force
            v += weight * h * force
