"""What the commands of all rooms share: errors, long work and Ctrl-C, each told in one line."""

import argparse
import sys
from typing import NoReturn

LONG = 10.0
"""Seconds from which on a command says beforehand how long it will take."""

INTERRUPTED = 130
"""Exit status after Ctrl-C, as shells have it: 128 + SIGINT."""


class OneLineParser(argparse.ArgumentParser):
    """An argument parser whose errors are one line on stderr and exit status 2."""

    def error(self, message: str) -> NoReturn:
        """Print ``error: message (see ... --help)`` and stop."""
        fail(f"{message} (see {self.prog} --help)")
        sys.exit(2)


def fail(message: object) -> int:
    """Print ``error: message`` in one line on stderr; return the exit status 2."""
    print(f"error: {one_line(message)}", file=sys.stderr)
    return 2


def one_line(message: object) -> str:
    r"""The message in one line, what would steer the terminal written out.

    >>> print(one_line("two\nlines, \x1b[31mred"))
    two lines, \x1b[31mred
    """
    line = " ".join(str(message).split())
    return "".join(sign if sign.isprintable() else ascii(sign)[1:-1] for sign in line)


def announce(work: str, seconds: float) -> None:
    """Say on stderr, before it begins, how long ``work`` will take, if that is ``LONG`` or more.

    >>> announce("rational_9", 0.5)
    """
    if seconds >= LONG:
        print(f"{work}: about {duration(seconds)} (Ctrl-C stops it)", file=sys.stderr, flush=True)


def duration(seconds: float) -> str:
    """Seconds in the unit that reads best, to two digits.

    >>> duration(44.4), duration(600), duration(20_000), duration(1e6)
    ('44 s', '10 min', '5.6 h', '12 days')
    """
    for size, unit in ((86_400, "days"), (3600, "h"), (60, "min")):
        if seconds >= 2 * size:
            return f"{_two_digits(seconds / size)} {unit}"
    return f"{_two_digits(seconds)} s"


def _two_digits(number: float) -> str:
    return f"{number:.2g}" if number < 99.5 else f"{number:.0f}"


def interrupted(program: str, kept: str = "") -> int:
    """Print one line on stderr after Ctrl-C, with what is ``kept``; return the exit status 130."""
    print(f"{program}: interrupted{f' ({kept})' if kept else ''}", file=sys.stderr)
    return INTERRUPTED
