"""The verdict on one closed form: what was found, how, and in how many seconds."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any


class Outcome(enum.StrEnum):
    """What a check can find.  "Could not decide" never looks like "wrong".

    ``PROVED`` is exact (`verify.proof`).  ``CHECKED`` is a residual that vanishes at the stated
    digits and points, which is evidence and not a proof.  ``REFUTED`` has a witness,
    ``UNDECIDED`` a reason.
    """

    PROVED = "PROVED"
    CHECKED = "CHECKED"
    REFUTED = "REFUTED"
    UNDECIDED = "UNDECIDED"

    @property
    def passed(self) -> bool:
        """Whether the closed form stands.

        >>> Outcome.CHECKED.passed, Outcome.UNDECIDED.passed
        (True, False)
        """
        return self in (Outcome.PROVED, Outcome.CHECKED)


@dataclass(frozen=True)
class Verdict:
    """The outcome of one check of one closed form.

    ``detail`` is one line: the residual at each precision, the fact that was proved, or the reason
    why nothing was decided.  ``residual`` is the largest relative residual at the highest
    precision (0 for an exact proof, None if there is none).  ``witness`` names the point, as exact
    rationals in text, at which a refuted form leaves a residual.

    Raises ValueError for a refutation without a witness, and for an undecided verdict without a
    reason.
    """

    name: str
    equation: str
    method: str
    outcome: Outcome
    detail: str
    residual: float | None = None
    witness: Mapping[str, str] | None = None
    seconds: float = 0.0

    def __post_init__(self) -> None:
        if self.outcome is Outcome.REFUTED and self.witness is None:
            raise ValueError(
                "witness must name the point of a refutation, got none "
                "(use UNDECIDED where there is no such point)"
            )
        if self.outcome is Outcome.UNDECIDED and not self.detail:
            raise ValueError(
                "detail must give the reason of an undecided verdict, got '' (say what stopped it)"
            )

    @property
    def passed(self) -> bool:
        """Whether the closed form stands: proved or checked."""
        return self.outcome.passed

    def json(self) -> dict[str, Any]:
        """The record as plain data for ``json.dumps``.

        >>> verdict = Verdict("kink", "defocusing mKdV", "residual", Outcome.CHECKED, "3e-49")
        >>> verdict.json()["outcome"]
        'CHECKED'
        """
        record = asdict(self) | {"outcome": self.outcome.value}
        record["witness"] = None if self.witness is None else dict(self.witness)
        return record
