"""Drift-kick splittings of y'' = f(y) that use that the kinetic energy is quadratic.

Such a splitting need satisfy the Nystroem conditions only, which are fewer than a general
composition's; its free weights are spent on a small error. At a sup error of 1e-6 of Y2 the
14-stage method of order 6 evaluates the force half as often as Kahan and Li's of order 8.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from verify.lattice import stencil, tiled
from verify.lattice.constants import Constants
from verify.lattice.nystroem_conditions import splitting_defect

Array = NDArray[np.float64]

ROUNDING = 1e-13
"""Defect allowed to coefficients that are published with 16 digits."""


@dataclass(frozen=True)
class Splitting:
    """A symmetric splitting; the literals up to the middle of ``drifts`` and ``kicks``.

    ``drift_half`` holds the drifts up to the middle one, ``kick_half`` the first half of an even
    number of kicks. Raises ValueError if an order condition fails by more than the rounding.
    """

    name: str
    order: int
    drift_half: tuple[str, ...]
    kick_half: tuple[str, ...]
    reference: str

    def __post_init__(self) -> None:
        defect = splitting_defect(self._all_drifts, self._all_kicks, self.order)
        if defect > ROUNDING:
            raise ValueError(
                f"drift_half, kick_half must satisfy the conditions of order {self.order} to "
                f"{ROUNDING:g}, got a defect of {defect:.1e} in {self.name} (check the digits)"
            )

    @property
    def stages(self) -> int:
        """Force evaluations per step."""
        return 2 * len(self.kick_half)

    @property
    def _all_drifts(self) -> tuple[str, ...]:
        return self.drift_half + self.drift_half[-2::-1]

    @property
    def _all_kicks(self) -> tuple[str, ...]:
        return self.kick_half + self.kick_half[::-1]

    @cached_property
    def drifts(self) -> Array:
        """Drift lengths in units of the step."""
        return np.array([float(literal) for literal in self._all_drifts])

    @cached_property
    def kicks(self) -> Array:
        """Kick lengths in units of the step."""
        return np.array([float(literal) for literal in self._all_kicks])

    def advance(self, y: Array, s: Array, h: float, steps: int, constants: Constants) -> None:
        """Advance the ring (y, s) in place by ``steps`` steps of length ``h``."""
        advance_splitting(y, s, self.drifts * h, self.kicks * h, steps, constants)

    def oscillator(self, z: Array) -> Array:
        """One step of y'' = -y with the steps ``z``, as matrices of shape (len(z), 2, 2)."""
        step = np.tile(np.eye(2), (len(z), 1, 1))
        for drift, kick in zip(self.drifts, [*self.kicks, 0.0], strict=True):
            step[:, 0] += drift * z[:, None] * step[:, 1]
            step[:, 1] -= kick * z[:, None] * step[:, 0]
        return step


def advance_splitting(
    y: Array, s: Array, drifts: Array, kicks: Array, steps: int, constants: Constants
) -> None:
    """Advance the ring in place by the fastest kernel that its size admits."""
    kernel = tiled.advance_tiled if tiled.fits(y.size, kicks.size) else stencil.advance_composition
    kernel(y, s, drifts, kicks, steps, *constants.kernel)


BLANES_MOAN_6 = Splitting(
    name="blanes_moan_6",
    order=6,
    drift_half=(
        "0.0378593198406116",
        "0.102635633102435",
        "-0.0258678882665587",
        "0.314241403071447",
        "-0.130144459517415",
        "0.106417700369543",
        "-0.00879424312851058",
        "0.2073050690568954",
    ),
    kick_half=(
        "0.09171915262446165",
        "0.183983170005006",
        "-0.05653436583288827",
        "0.004914688774712854",
        "0.143761127168358",
        "0.328567693746804",
        "-0.19641146648645423",
    ),
    reference="Blanes, Moan, J. Comput. Appl. Math. 142 (2002) 313, SRKN 14a of order 6",
)
