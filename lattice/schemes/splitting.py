"""Drift-kick splittings of y'' = f(y) that use that the kinetic energy is quadratic.

Such a splitting need satisfy the Nystroem conditions only, which are fewer than a general
composition's; its free weights are spent on a small error. Long waves are nearly linear, so most of
that error is a wrong speed: a higher phase-lag order removes it. At a sup error of 1e-6 of Y2 the
method of order 6 and phase-lag order 8 evaluates the force half as often as Blanes and Moan's of
order 6, and a quarter as often as Kahan and Li's of order 8.
"""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lattice.kernels import blocked as tiled
from lattice.kernels import plain as stencil
from lattice.kernels import two_cores as arcs
from lattice.model import Constants
from lattice.schemes.nystroem_conditions import phase_lag_defect, splitting_defect

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Splitting:
    """A symmetric splitting; decimal literals or fractions up to the middle.

    ``drift_half`` holds the drifts up to the middle, ``kick_half`` the kicks. With one drift more
    than kicks the last drift is the middle of the step, with as many the last kick is.
    ``phase_order`` is the phase-lag order where it exceeds the order. Raises ValueError if a
    condition of either fails by more than the rounding of the literals.
    """

    name: str
    order: int
    drift_half: tuple[str, ...]
    kick_half: tuple[str, ...]
    reference: str
    phase_order: int = 0

    def __post_init__(self) -> None:
        drifts, kicks = self._all_drifts, self._all_kicks
        rounding = _rounding(drifts + kicks)
        for kind, order, defect in (
            ("order", self.order, splitting_defect(drifts, kicks, self.order)),
            (
                "phase-lag order",
                self.phase_order,
                phase_lag_defect(drifts, kicks, self.phase_order),
            ),
        ):
            if defect > rounding:
                raise ValueError(
                    f"drift_half, kick_half must satisfy the conditions of {kind} {order} to "
                    f"{rounding:g}, got a defect of {defect:.1e} in {self.name} (check the digits)"
                )

    @property
    def stages(self) -> int:
        """Force evaluations per step."""
        return len(self._all_kicks)

    @property
    def _middle_is_kick(self) -> bool:
        return len(self.kick_half) == len(self.drift_half)

    @property
    def _all_drifts(self) -> tuple[str, ...]:
        return _mirrored(self.drift_half, not self._middle_is_kick)

    @property
    def _all_kicks(self) -> tuple[str, ...]:
        return _mirrored(self.kick_half, self._middle_is_kick)

    @cached_property
    def drifts(self) -> Array:
        """Drift lengths in units of the step."""
        return np.array([float(Fraction(literal)) for literal in self._all_drifts])

    @cached_property
    def kicks(self) -> Array:
        """Kick lengths in units of the step."""
        return np.array([float(Fraction(literal)) for literal in self._all_kicks])

    def advance(self, y: Array, s: Array, h: float, steps: int, constants: Constants) -> None:
        """Advance the ring (y, s) in place by ``steps`` steps of length ``h``."""
        advance_splitting(y, s, self.drifts * h, self.kicks * h, steps, constants)

    def oscillator(self, z: Array) -> Array:
        """One step of y'' = -y with the steps ``z``, as matrices of shape (len(z), 2, 2)."""
        return splitting_oscillator(self.drifts, self.kicks, z)


def _mirrored(half: tuple[str, ...], once: bool) -> tuple[str, ...]:
    """``half`` and its reflection; the last entry stands ``once`` or twice."""
    return half + half[::-1][once:]


def _rounding(literals: tuple[str, ...]) -> float:
    """Defect allowed to literals: a hundred units in the last place of the shortest decimal."""
    decimals = [len(literal.partition(".")[2]) for literal in literals if "." in literal]
    return 10.0 ** (2.0 - min(decimals))


def advance_splitting(
    y: Array, s: Array, drifts: Array, kicks: Array, steps: int, constants: Constants
) -> None:
    """Advance the ring in place by the fastest kernel that its size admits."""
    advance = _fastest(y.size, kicks.size)
    advance(y, s, drifts, kicks, steps, *constants.kernel)


def _fastest(size: int, stages: int) -> Callable[..., None]:
    if not tiled.fits(size, stages):
        return stencil.advance_composition
    return arcs.advance_on_arcs if arcs.pays(size) else tiled.advance_tiled


def splitting_oscillator(drifts: Array, kicks: Array, z: Array) -> Array:
    """One step of y'' = -y with the steps ``z``, as matrices of shape (len(z), 2, 2)."""
    step = np.tile(np.eye(2), (len(z), 1, 1))
    for drift, kick in zip(drifts, [*kicks, 0.0], strict=True):
        step[:, 0] += drift * z[:, None] * step[:, 1]
        step[:, 1] -= kick * z[:, None] * step[:, 0]
    return step
