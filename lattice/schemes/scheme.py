"""Time-stepping schemes as tables whose order is checked when they are declared."""

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lattice.kernels import plain as stencil
from lattice.model import Constants
from lattice.schemes.order_conditions import composition_defect, runge_kutta_defect
from lattice.schemes.splitting import advance_splitting, splitting_oscillator

Array = NDArray[np.float64]

ROUNDING = 1e-24
"""Defect allowed to coefficients that are given with 26 digits."""


class Scheme(Protocol):
    """What a run needs of a scheme."""

    def __hash__(self) -> int:
        """Tables are values: equal tables have equal hashes."""

    @property
    def name(self) -> str:
        """The name by which a scene asks for it."""

    @property
    def order(self) -> int:
        """Order of convergence in the step."""

    @property
    def stages(self) -> int:
        """Force evaluations per step."""

    @property
    def reference(self) -> str:
        """Where the coefficients come from."""

    def advance(self, y: Array, s: Array, h: float, steps: int, constants: Constants) -> None:
        """Advance the ring (y, s) in place by ``steps`` steps of length ``h``."""

    def oscillator(self, z: Array) -> Array:
        """One step of y'' = -y with the steps ``z``, as matrices of shape (len(z), 2, 2)."""


@dataclass(frozen=True)
class Composition:
    """A symmetric composition of Stoermer-Verlet steps with the weights ``gammas``.

    ``half`` holds the weights up to the middle one, as decimal literals. Raises ValueError if the
    order conditions fail by more than the rounding of the literals.
    """

    name: str
    order: int
    half: tuple[str, ...]
    reference: str

    def __post_init__(self) -> None:
        defect = composition_defect(self.gammas, self.order)
        if defect > ROUNDING:
            raise ValueError(
                f"half must satisfy the conditions of order {self.order} to {ROUNDING:g}, "
                f"got a defect of {defect:.1e} in {self.name} (check the digits)"
            )

    @property
    def gammas(self) -> tuple[str, ...]:
        """All weights, first to last."""
        return self.half + self.half[-2::-1]

    @property
    def stages(self) -> int:
        """Force evaluations per step."""
        return 2 * len(self.half) - 1

    @cached_property
    def kicks(self) -> Array:
        """Kick lengths in units of the step."""
        return np.array([float(gamma) for gamma in self.gammas])

    @cached_property
    def drifts(self) -> Array:
        """Drift lengths in units of the step: half of each kick on either side of it."""
        exact = [Fraction(gamma) / 2 for gamma in self.gammas]
        ends = [Fraction(0), *exact, Fraction(0)]
        return np.array([float(a + b) for a, b in pairwise(ends)])

    def advance(self, y: Array, s: Array, h: float, steps: int, constants: Constants) -> None:
        """Advance the ring (y, s) in place by ``steps`` steps of length ``h``."""
        advance_splitting(y, s, self.drifts * h, self.kicks * h, steps, constants)

    def oscillator(self, z: Array) -> Array:
        """One step of y'' = -y with the steps ``z``, as matrices of shape (len(z), 2, 2)."""
        return splitting_oscillator(self.drifts, self.kicks, z)


@dataclass(frozen=True)
class RungeKutta:
    """An explicit Runge-Kutta table (A, b), run in its Nystroem form on y'' = D V'(y).

    The two forms are the same method: y' = s is linear, so its stages can be eliminated. Raises
    ValueError if A is not strictly lower triangular or an order condition fails (exactly).
    """

    name: str
    order: int
    A: tuple[tuple[Fraction, ...], ...]
    b: tuple[Fraction, ...]
    reference: str

    def __post_init__(self) -> None:
        if any(value for i, row in enumerate(self.A) for value in row[i:]):
            raise ValueError(
                f"A must be strictly lower triangular, got another in {self.name} "
                "(only explicit schemes can be run)"
            )
        defect = runge_kutta_defect(self.A, self.b, self.order)
        if defect:
            raise ValueError(
                f"A, b must satisfy the conditions of order {self.order}, "
                f"got a defect of {defect} in {self.name} (check the table)"
            )

    @property
    def stages(self) -> int:
        """Force evaluations per step."""
        return len(self.b)

    @cached_property
    def nystroem(self) -> tuple[Array, Array, Array, Array]:
        """Nodes A 1, inner weights A A, position weights b A and velocity weights b."""
        A = np.array(self.A, dtype=object)
        b = np.array(self.b, dtype=object)
        return _floats(A.sum(axis=1)), _floats(A @ A), _floats(b @ A), _floats(b)

    def advance(self, y: Array, s: Array, h: float, steps: int, constants: Constants) -> None:
        """Advance the ring (y, s) in place by ``steps`` steps of length ``h``."""
        stencil.advance_nystroem(y, s, *self.nystroem, h, steps, *constants.kernel)

    def oscillator(self, z: Array) -> Array:
        """One step of y'' = -y with the steps ``z``, as matrices of shape (len(z), 2, 2)."""
        generator = np.array([[0.0, 1.0], [-1.0, 0.0]])
        table, weights = _floats(np.array(self.A)), _floats(np.array(self.b))
        step, power = np.tile(np.eye(2), (len(z), 1, 1)), np.eye(2)
        stage = np.ones(self.stages)
        for degree in range(1, self.stages + 1):
            power = power @ generator
            step += (weights @ stage) * z[:, None, None] ** degree * power
            stage = table @ stage
        return step


def _floats(values: Iterable[object]) -> Array:
    return np.asarray(values, dtype=object).astype(np.float64)
