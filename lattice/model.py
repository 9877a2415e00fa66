"""The paper's chain in strains: force constants, stiffness, sound speed and energy."""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from longwave.lattice.force_program import ForceProgram
from longwave.lattice.numeric_lattice import Entry, NumericBond, NumericLattice
from longwave.lattice.state import State
from longwave.support.real_arrays import Array

NEGLIGIBLE_RATIO = 1e-200
"""K3 and K4 below this fraction of the largest constant have no effect for strains up to 1e90, and
quotients of larger constants neither overflow nor underflow."""

CURVATURE = tuple(Entry((shift,), weight, 0) for shift, weight in ((1, 1.0), (0, -2.0), (-1, 1.0)))
"""Stencil of D f_n = f_{n+1} - 2 f_n + f_{n-1}."""

STRAIN = NumericBond((Entry((0,), 1.0, 0),), CURVATURE, ForceProgram())
"""Bond with the stretch and action of y_n'' = D V'(y)_n; only its force is to be filled in."""


@dataclass(frozen=True)
class Model:
    """Force constants of V'(y) = K2 y + K3 y^2 + K4 y^3 (unit mass, unit spacing)."""

    K2: float
    K3: float
    K4: float

    def __post_init__(self) -> None:
        for name, value in (("K2", self.K2), ("K3", self.K3), ("K4", self.K4)):
            if not math.isfinite(value):
                raise ValueError(f"{name} must be finite, got {value} (1 is usual)")
        if self.K2 <= 0:
            raise ValueError(f"K2 must satisfy K2 > 0, got {self.K2:g} (sound travels at sqrt(K2))")

    @cached_property
    def lattice(self) -> NumericLattice:
        """The strain lattice with these constants, without absent or negligible terms.

        >>> Model(4, 1e-300, 1).lattice.bonds[0].force.coefficients
        (4.0, 0.0, 1.0)
        """
        K2, *others = (float(value) for value in (self.K2, self.K3, self.K4))
        least = NEGLIGIBLE_RATIO * max(K2, *map(abs, others))
        K3, K4 = (0.0 if abs(value) < least else value for value in others)
        force = ForceProgram((K2, K3, K4)[: 3 if K4 else 2 if K3 else 1])
        return NumericLattice("fput_strain", ("y",), (1.0,), (replace(STRAIN, force=force),))

    def stiffness(self, y: Array) -> Array:
        """Return V''(y) = K2 + 2 K3 y + 3 K4 y^2; waves exist only where it is positive.

        >>> float(Model(4, 0, 1).stiffness(np.array(1.0)))
        7.0
        """
        y = np.asarray(y, dtype=np.float64)
        return self.K2 + y * (2.0 * self.K3 + 3.0 * self.K4 * y)

    def sound_speed(self, ybar: float = 0.0) -> float:
        """Return the speed (sites per unit time) of long waves on the uniform strain ``ybar``.

        >>> Model(4, 0, 1).sound_speed()
        2.0
        """
        stiffness = float(self.stiffness(np.array(ybar)))
        if stiffness <= 0:
            raise ValueError(
                f"K2 + 2 K3 y + 3 K4 y^2 must be positive, got {stiffness:g} at y = {ybar:g} "
                "(take a smaller eps)"
            )
        return math.sqrt(stiffness)

    def highest_frequency(self, y: Array) -> float:
        """Return the largest linear frequency (at k = pi) about the strains ``y``, or at rest."""
        return 2.0 * math.sqrt(max(float(np.max(self.stiffness(y))), self.K2))

    def energy(self, state: State) -> float:
        """Return the energy of the chain whose bonds are strained by y: sum of p_n^2 / 2 + V(y_n).

        The strain lattice is the chain u_n'' = V'(y_n) - V'(y_{n-1}), y_n = u_{n+1} - u_n, whose
        energy this is. The velocities p_n = u_n' are computed from s_n = p_{n+1} - p_n in the frame
        of the centre of mass. The mean of s, which no periodic p has, is left out.

        The exact flow obeys dH/dt = mean(s) sum V'(y_n): the energy is conserved if the mean of s
        is 0, and otherwise changes by the work of stretching the ring. mean(s) is itself conserved.

        >>> state = State(0.0, np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 1.0, -1.0]]))
        >>> round(Model(4, 0, 1).energy(state), 12)  # V = 2 + 1/4, p = (-1, -1, 2) / 3
        2.583333333333
        """
        y, s = state.f[0], state.v[0]
        momentum = np.cumsum(s - np.mean(s))
        momentum -= np.mean(momentum)
        K2, K3, K4 = self.K2, self.K3, self.K4
        potential = y * y * (K2 / 2.0 + y * (K3 / 3.0 + y * (K4 / 4.0)))
        return float(np.sum(0.5 * momentum * momentum + potential))


def chain_constants(lattice: NumericLattice) -> tuple[float, float | None, float | None] | None:
    """Return K2, K3 and K4 (None where absent) of a lattice y_n'' = D V'(y)_n, None for any other.

    >>> chain_constants(Model(4, 0, 1).lattice)
    (4.0, None, 1.0)
    """
    force = lattice.bonds[0].force
    if not 0 < len(force.coefficients) <= 3 or lattice != replace(
        lattice, masses=(1.0,), bonds=(replace(STRAIN, force=force),)
    ):
        return None
    K2, K3, K4 = (*force.coefficients, 0.0, 0.0)[:3]
    return K2, K3 or None, K4 or None
