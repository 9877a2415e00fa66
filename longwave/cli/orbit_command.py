"""``longwave orbit``: exact time-periodic orbits of a chain, with every number's error."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from longwave.cli.proved_motion import LARGEST_ERROR, Finding, find_and_print, number_text
from longwave.derive.lattice import Lattice
from longwave.waves.exact_orbit import exact_orbit


def orbit_and_print(
    model: str,
    constants: Mapping[str, str],
    *,
    sites: int | None,
    mode: int,
    energy: str | None,
    frequency: str | None,
    digits: int,
    **output: Any,
) -> int:
    """Find an orbit, print its verdict and write its certificate; return the exit status.

    ``output`` and the status are those of `find_and_print`.
    """

    def find(lattice: Lattice) -> Finding:
        orbit = exact_orbit(
            lattice,
            sites=sites or 0,
            mode=mode,
            energy=energy or 0,
            frequency=frequency or 0,
            error=LARGEST_ERROR,
        )
        rows = [
            (name.replace("_", " "), number_text(value, digits))
            for name, value in orbit.numbers.items()
        ]
        notes = []
        if orbit.certificate.get("kind") == "orbit" and not orbit.multipliers:
            notes.append(
                "  The multipliers are not proved (some are too close, or the chain is too long)."
            )
        return Finding(orbit, rows, notes)

    return find_and_print(model, constants, find, example="o.json", **output)
