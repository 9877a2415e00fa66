"""The constants of the strain FPUT lattice and what follows from them pointwise."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
KernelConstants = tuple[float, float | None, float | None]


NEGLIGIBLE = 1e-200
"""K3 and K4 in units of the largest constant below which no strain up to 1e90 feels them; quotients
of the others neither overflow nor underflow."""


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
            raise ValueError(
                f"K2 must satisfy K2 > 0, got {self.K2:g} (the sound speed is sqrt(K2))"
            )

    @property
    def kernel(self) -> KernelConstants:
        """The constants as the kernels take them: ``None`` for an absent or a negligible term.

        >>> Model(4, 1e-300, 1).kernel
        (4.0, None, 1.0)
        """
        least = NEGLIGIBLE * max(self.K2, abs(self.K3), abs(self.K4))
        K3, K4 = (None if abs(value) < least else float(value) for value in (self.K3, self.K4))
        return float(self.K2), K3, K4

    def stiffness(self, y: Array) -> Array:
        """V''(y) = K2 + 2 K3 y + 3 K4 y^2; waves exist only where it is positive.

        >>> float(Model(4, 0, 1).stiffness(np.array(1.0)))
        7.0
        """
        y = np.asarray(y, dtype=np.float64)
        return self.K2 + y * (2.0 * self.K3 + 3.0 * self.K4 * y)

    def least_stiffness(self, least: float, most: float) -> float:
        """The smallest V''(y) of all strains from ``least`` to ``most``.

        >>> Model(4, 1, 1).least_stiffness(-2.0, 3.0)  # at y = -1/3
        3.6666666666666665
        """
        places = [least, most]
        if self.K4 > 0.0:
            places.append(min(max(-self.K3 / (3.0 * self.K4), least), most))
        return min(self._stiffness(y) for y in places)

    def _stiffness(self, y: float) -> float:
        return self.K2 + y * (2.0 * self.K3 + 3.0 * self.K4 * y)

    def sound_speed(self, ybar: float = 0.0) -> float:
        """Speed (sites per unit time) of long waves on the uniform strain ``ybar``.

        >>> Model(4, 0, 1).sound_speed()
        2.0
        """
        stiffness = self._stiffness(ybar)
        if stiffness <= 0:
            raise ValueError(
                f"K2 + 2 K3 y + 3 K4 y^2 must be positive, got {stiffness:g} at y = {ybar:g} "
                "(take a smaller eps)"
            )
        return math.sqrt(stiffness)

    def highest_frequency(self, y: Array) -> float:
        """Largest linear frequency (zone boundary, k = pi) about any strain in ``y``."""
        return 2.0 * math.sqrt(max(float(np.max(self.stiffness(y))), self.K2))
