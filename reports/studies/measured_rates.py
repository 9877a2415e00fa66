"""The rates at which lattices come near their waves, measured for a report."""

from __future__ import annotations

from typing import TYPE_CHECKING

from longwave.scenes.rate_cases import rate_cases
from longwave.support.processes import Job, Key

if TYPE_CHECKING:
    from longwave.scenes.convergence import SceneConvergence

SECONDS = {"leading": 1.0, "slaved": 3.0, "corrected": 15.0}
"""About the processor time of a case by the order of its data; a long one takes ``LONGER``."""

LONGER = 10.0


def measured_rate(name: str, order: str) -> SceneConvergence:
    """Measure one of the `rate_cases` with data of an order.

    >>> found = measured_rate("2", "leading")
    >>> found.equation, found.theory, found.reached
    ('KdV', 4, True)
    """
    return rate_cases()[name].study(order)


def rate_jobs(full: bool) -> dict[Key, Job]:
    """The short cases with their simplest data; if ``full`` all cases, and with the next order."""
    return {
        ("rate", (name, order)): Job(
            measured_rate, (name, order), SECONDS[order] * (LONGER if case.is_long else 1.0)
        )
        for name, case in rate_cases().items()
        if full or not case.is_long
        for order in case.orders[: None if full else 1]
    }
