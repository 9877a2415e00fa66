"""Springs of a chain, and the strip of an analytic force, read from a certificate."""

from __future__ import annotations

from collections.abc import Sequence

from flint import arb

from .composition import Strip
from .force_text import Force, read_force
from .limits import MAX_MODES, CertificateError
from .periodic import Spring
from .reading import Record

MAX_NEIGHBOUR = 8


def springs_of(lattice: Record, least: int = 1) -> tuple[Spring, ...]:
    """Read a chain's springs. Raises CertificateError unless each neighbour has one force.

    Where neighbours from ``least`` = 0 on are allowed, the 0-th spring is a force on each site.
    """
    items = [Record(item, "spring") for item in lattice.items("springs", MAX_NEIGHBOUR + 1)]
    lattice.close()
    springs = tuple(_spring(item, least) for item in items)
    if not springs or len({spring.neighbour for spring in springs}) != len(springs):
        raise CertificateError("springs must have one force for each neighbour")
    return springs


def _spring(item: Record, least: int) -> Spring:
    neighbour = item.integer("neighbour", least, MAX_NEIGHBOUR)
    spring = Spring(neighbour, read_force(item.text("force")))
    item.close()
    return spring


def nearest_force(springs: Sequence[Spring], subject: str) -> Force:
    """Return the force of a chain with springs between nearest neighbours only.

    Raises CertificateError that names the ``subject`` for any other chain.
    """
    if [spring.neighbour for spring in springs] != [1]:
        raise CertificateError(f"{subject} is proved for nearest neighbours only")
    return springs[0].force


def springs_text(springs: Sequence[Spring]) -> str:
    """Return the springs in words, for statements."""
    places = ["on each site", "", *(f"neighbour {m}" for m in range(2, MAX_NEIGHBOUR + 1))]
    texts = [(f"V'(r) = {spring.force.text}", places[spring.neighbour]) for spring in springs]
    return " and ".join(text + (f" ({place})" if place else "") for text, place in texts)


def strip_of(record: Record) -> Strip | None:
    """Read the strip on which a certificate's forces are bounded; None if it has no strip."""
    if "strip" not in record:
        return None
    inner = record.record("strip")
    strip = Strip(
        arb(inner.number("rho")),
        arb(inner.number("margin")),
        inner.integer("samples", 4, 32 * MAX_MODES),
    )
    inner.close()
    return strip
