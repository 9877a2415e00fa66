"""Parts that ``longwave wave`` and ``longwave orbit`` share: verdict, numbers and certificates."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import (
    ROUND_CEILING,
    ROUND_FLOOR,
    ROUND_HALF_EVEN,
    Context,
    Decimal,
    localcontext,
)
from pathlib import Path
from typing import Any

from longwave.derive.lattice import Lattice
from longwave.derive.lattice_file import find_lattice
from longwave.derive.symbols import constant_value
from longwave.support import console
from longwave.support.atomic_file import write_atomically
from longwave.support.command_line import command_name, fail
from longwave.support.interruption import interrupted
from longwave.waves.proved import Existence, Interval, Proved

LARGEST_ERROR = 1e-10


@dataclass(frozen=True)
class Finding:
    """A motion of a lattice, and what a command prints and writes of it.

    ``rows`` are names and texts, ``notes`` are lines below them; ``data`` and ``certificates`` are
    added to those of the motion.
    """

    motion: Proved
    rows: Sequence[tuple[str, str]]
    notes: Sequence[str] = ()
    data: Mapping[str, Any] = field(default_factory=dict)
    certificates: Sequence[Mapping[str, Any]] = ()

    @property
    def content(self) -> Any:
        """Content of the certificate's file: one certificate, or a list of several."""
        first = dict(self.motion.certificate)
        return [first, *map(dict, self.certificates)] if self.certificates else first

    @property
    def lines(self) -> list[str]:
        """Lines to print: the verdict, the theorem, and each number with its error."""
        motion = self.motion
        if motion.verdict is not Existence.EXISTS:
            return [f"{motion.verdict}: {motion.reason}"]
        width = max(len(name) for name, _ in self.rows)
        return [
            f"{motion.verdict}: {motion.statement.splitlines()[0]}",
            *(f"  {name:<{width}}  {text}" for name, text in self.rows),
            *self.notes,
        ]


def find_and_print(
    model: str,
    constants: Mapping[str, str],
    find: Callable[[Lattice], Finding],
    *,
    certificate: str | None,
    example: str,
    force: bool,
    json_wanted: bool,
) -> int:
    """Find a motion, print its verdict and write its certificate; return the exit status.

    ``example`` is the name of a file shown where ``certificate`` is not one. The status is 0 if the
    motion exists, 1 if it is not proved or is refused, 2 for wrong input.
    """
    try:
        console.check_output(certificate, example, force=force)
        lattice = find_lattice(model).with_values(
            {name: constant_value(name, text) for name, text in constants.items()}
        )
        finding = find(lattice)
        if certificate is not None and finding.motion.certificate:
            text = json.dumps(finding.content, indent=1) + "\n"
            path = Path(certificate)
            write_atomically(path, lambda draft: draft.write_text(text, encoding="utf-8"), force)
    except KeyboardInterrupt:
        return interrupted(command_name(), "nothing was saved")
    except (ValueError, OSError) as error:
        return fail(error)
    if json_wanted:
        console.print_json({**finding.motion.to_json(), **finding.data})
    else:
        console.print_lines(console.plain_console(), finding.lines)
    return int(finding.motion.verdict is not Existence.EXISTS)


def number_text(interval: Interval, digits: int) -> str:
    """Return a number with its error, rounded up, or both ends of a wide interval.

    >>> number_text(Interval("0.1234560", "0.1234565"), 5), number_text(Interval("0.25", "0.5"), 4)
    ('0.12346 +- 4.0e-6', '0.25 to 0.5')
    """
    low, high = Decimal(interval.lower), Decimal(interval.upper)
    if high - low > abs(high) / 1000:
        return f"{_rounded(low, digits, ROUND_FLOOR)} to {_rounded(high, digits, ROUND_CEILING)}"
    with localcontext(Context(prec=60)):
        middle = _rounded((low + high) / 2, digits, ROUND_HALF_EVEN)
        error = _rounded(max(high - middle, middle - low), 2, ROUND_CEILING)
    return f"{middle} +- {error:.1e}" if error else str(middle)


def _rounded(value: Decimal, digits: int, rounding: str) -> Decimal:
    return Context(prec=digits, rounding=rounding).plus(value)
