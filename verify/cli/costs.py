"""About how long a request takes, so that a command can say it before it begins.

The laws of the rational family were measured in processor seconds on one core of a 3 GHz server:
orders 7 to 12 for proofs, 4 to 8 for stable forms, 4 to 7 for the rest.  Beyond, they are orders
of magnitude.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from solutions.catalogue import CATALOGUE
from verify.proof.catalogue_proofs import higher_order


@dataclass(frozen=True)
class Law:
    """``seconds`` for a form of the catalogue; ``rational`` at order 7, which grows as a power."""

    seconds: float
    rational: float
    exponent: float

    def total(self, names: Iterable[str]) -> float:
        """Seconds for all the forms; raises ValueError for a name that is none.

        >>> round(PROOF.total(["rational_2", "rational_14"]))
        19
        """
        return sum(self._one(higher_order(name)) for name in names)

    def _one(self, order: int | None) -> float:
        if order is None:
            return self.seconds
        return self.rational * (order / 7) ** self.exponent


PROOF = Law(0.2, 0.15, 7.0)
STABLE = Law(0.3, 1.5, 3.3)
RESIDUAL = Law(0.3, 1.0, 4.0)
MUTANTS = Law(35.0 / len(CATALOGUE), 29.0, 6.5)
