"""Fields of a long wave with a slow variable across, whose time derivative is not local in jets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from sympy import Expr, Symbol

    from longwave.derive.reduction import Reduction
    from longwave.solutions.numeric_wave import PlanarValues

Array = NDArray[np.float64]


class PlanarWave(Protocol):
    """A solution of a reduced equation with Z, such as a `solutions.Wave` of KP."""

    def potential(self, X: ArrayLike, T: ArrayLike, *, Z: ArrayLike) -> PlanarValues:
        """W with ``W_X = Y``, and its derivatives."""

    def __call__(self, X: ArrayLike, T: ArrayLike, *, Z: ArrayLike) -> PlanarValues:
        """Y and its derivatives."""


class PlanarFields:
    """The one field of a lattice and its time derivative, by the chain rule through X, Z and T.

    Raises ValueError for more than one field: those that follow are not evaluated across.
    """

    def __init__(
        self, reduction: Reduction, values: Mapping[Symbol, Expr], wave: PlanarWave, eps: float
    ) -> None:
        scaling = reduction.scaling
        if len(reduction.slaved) > 1 or len(scaling.space) != 2:
            raise ValueError(
                "a wave with a variable across must be one of one field and one such variable, got "
                f"{len(reduction.slaved)} fields and {len(scaling.space) - 1} variables "
                f"({reduction.lattice.name})"
            )
        self._wave, self._is_displacement = wave, reduction.is_displacement
        self._amplitude = eps**scaling.amplitude
        self._unit = eps**scaling.time
        self._frames = [
            (
                eps**variable.exponent,
                [float(step.xreplace(values)) for step in variable.direction],
                float(variable.speed.xreplace(values)),
            )
            for variable in scaling.space
        ]

    def state(self, cells: ArrayLike, t: float) -> tuple[Array, Array]:
        """The field and its time derivative, (1, *sites)."""
        axes = np.asarray(cells, dtype=np.float64)
        X, Z = (
            unit * (sum(d * axis for d, axis in zip(steps, axes, strict=True)) - speed * t)
            for unit, steps, speed in self._frames
        )
        ask = self._wave.potential if self._is_displacement else self._wave
        values = ask(X, self._unit * t, Z=Z)
        (along, _, c), (across, _, drift) = self._frames
        moved = self._unit * values.Y_T - along * c * values.Y_X - across * drift * values.Y_Z
        return self._amplitude * values.Y[None], self._amplitude * moved[None]
