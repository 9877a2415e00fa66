"""Springs of a chain, read from a certificate."""

from __future__ import annotations

from .force_text import read_force
from .limits import CertificateError
from .periodic import Spring
from .reading import Record

MAX_NEIGHBOUR = 8


def springs_of(lattice: Record) -> tuple[Spring, ...]:
    """Read a chain's springs. Raises CertificateError unless each neighbour has one force."""
    items = [Record(item, "spring") for item in lattice.items("springs", MAX_NEIGHBOUR)]
    lattice.close()
    springs = tuple(map(_spring, items))
    if not springs or len({spring.neighbour for spring in springs}) != len(springs):
        raise CertificateError("springs must have one force for each neighbour")
    return springs


def _spring(item: Record) -> Spring:
    spring = Spring(item.integer("neighbour", 1, MAX_NEIGHBOUR), read_force(item.text("force")))
    item.close()
    return spring
