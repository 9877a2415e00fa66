"""``longwave orbit``: exact time-periodic orbits of a chain, with every number's error."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from longwave.cli.wave_command import LARGEST_ERROR, number_text
from longwave.derive.lattice_file import find_lattice
from longwave.derive.symbols import constant_value
from longwave.support import console
from longwave.support.atomic_file import write_atomically
from longwave.support.command_line import command_name, fail
from longwave.support.interruption import interrupted
from longwave.waves.exact_orbit import ExactOrbit, exact_orbit
from longwave.waves.proved import Existence


def orbit_and_print(
    model: str,
    constants: Mapping[str, str],
    *,
    sites: int | None,
    mode: int,
    energy: str | None,
    frequency: str | None,
    certificate: str | None,
    digits: int,
    force: bool,
    json_wanted: bool,
) -> int:
    """Find an orbit, print its verdict and write its certificate; return the exit status.

    The status is 0 if the orbit exists, 1 if it is not proved or is refused, 2 for wrong input.
    """
    try:
        console.check_output(certificate, "o.json", force=force)
        lattice = find_lattice(model).with_values(
            {name: constant_value(name, text) for name, text in constants.items()}
        )
        orbit = exact_orbit(
            lattice,
            sites=sites or 0,
            mode=mode,
            energy=energy or 0,
            frequency=frequency or 0,
            error=LARGEST_ERROR,
        )
        if certificate is not None and orbit.certificate:
            text = json.dumps(dict(orbit.certificate), indent=1) + "\n"
            path = Path(certificate)
            write_atomically(path, lambda draft: draft.write_text(text, encoding="utf-8"), force)
    except KeyboardInterrupt:
        return interrupted(command_name(), "nothing was saved")
    except (ValueError, OSError) as error:
        return fail(error)
    if json_wanted:
        console.print_json(orbit.to_json())
    else:
        console.print_lines(console.plain_console(), _lines(orbit, digits))
    return int(orbit.verdict is not Existence.EXISTS)


def _lines(orbit: ExactOrbit, digits: int) -> list[str]:
    """Return the lines to print: the verdict, the theorem, and each number with its error."""
    if orbit.verdict is not Existence.EXISTS:
        return [f"{orbit.verdict}: {orbit.reason}"]
    rows = [
        (name.replace("_", " "), number_text(value, digits))
        for name, value in orbit.numbers.items()
    ]
    width = max(len(name) for name, _ in rows)
    statement = orbit.statement.splitlines()[0]
    lines = [
        f"{orbit.verdict}: {statement}",
        *(f"  {name:<{width}}  {text}" for name, text in rows),
    ]
    if orbit.certificate["kind"] == "orbit" and not orbit.multipliers:
        lines.append(
            "  The multipliers are not proved (some are too close, or the chain is too long)."
        )
    return lines
