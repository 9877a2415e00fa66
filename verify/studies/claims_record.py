"""A statement of the paper as a record: what was measured for it, and the verdict.

Texts hold mathematics between dollars, in plain names ($eps = 0.05$), for whoever prints them.
"""

import enum
from dataclasses import dataclass
from typing import NamedTuple


class Ruling(enum.StrEnum):
    """What the measured numbers say of a statement."""

    CONFIRMED = "confirmed"
    NOT_CONFIRMED = "not confirmed"
    DEPENDS = "depends"


class Measurement(NamedTuple):
    """A number: of what, its value, and its discretisation error (0 if it is exact)."""

    of: str
    value: float
    error: float = 0.0


@dataclass(frozen=True)
class Claim:
    """One statement of the paper.

    ``depends_on`` names the parameters on which the verdict rests, with the reading of words that
    the paper leaves open.
    """

    name: str
    statement: str
    measurements: tuple[Measurement, ...]
    ruling: Ruling
    depends_on: str


def ruling(*holds: bool) -> Ruling:
    """All hold, none does, or it depends.

    >>> str(ruling(True, False))
    'depends'
    """
    if all(holds):
        return Ruling.CONFIRMED
    return Ruling.DEPENDS if any(holds) else Ruling.NOT_CONFIRMED
