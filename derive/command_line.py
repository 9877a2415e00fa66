"""What the commands of all rooms share: errors, long work and Ctrl-C, each told in one line."""

import argparse
import os
import sys
from collections.abc import Sequence
from typing import NoReturn

import click

LONG = 10.0
"""Seconds from which on a command says beforehand how long it will take."""

WRONG, INTERRUPTED, NO_READER = 2, 130, 141
"""Exit status after wrong input, Ctrl-C (128 + SIGINT) and the end of the output's reader."""


class OneLineParser(argparse.ArgumentParser):
    """An argument parser whose errors are one line on stderr and exit status 2."""

    def error(self, message: str) -> NoReturn:
        """Print ``error: message (see ... --help)`` and stop."""
        fail(f"{message} (see {self.prog} --help)")
        sys.exit(WRONG)


def fail(message: object) -> int:
    """Print ``error: message`` in one line on stderr; return the exit status 2."""
    print(f"error: {one_line(message)}", file=sys.stderr)
    return WRONG


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


def example(*lines: str) -> str:
    """The example at the end of a command's help."""
    return "\b\nExample:\n" + "\n".join(f"  {line}" for line in lines)


def run_command(command: click.Command, program: str, argv: Sequence[str] | None = None) -> int:
    """Run a command by the words given, or those of the command line; return its exit status."""
    words = list(sys.argv[1:] if argv is None else argv)
    inner = isinstance(command, click.Group) and bool(words) and words[0] in command.commands
    told = f"{program} {words[0]}" if inner else program
    try:
        with command.make_context(program, [*words]) as context:
            status = command.invoke(context)
        sys.stdout.flush()
    except click.exceptions.Exit as stop:
        return stop.exit_code
    except click.ClickException as error:
        return fail(_wrong_words(error, told))
    except (click.Abort, KeyboardInterrupt):
        return interrupted(told)
    except BrokenPipeError:
        _drop_output()
        return NO_READER
    except OSError as error:
        _drop_output()
        return fail(f"{error.filename or 'output'}: {error.strerror}")
    return int(status or 0)


def _wrong_words(error: click.ClickException, program: str) -> str:
    """What is wrong with the words, with the command whose help explains it."""
    line = error.format_message().removesuffix(".")
    if line.startswith("COMMAND"):
        return line
    context = error.ctx if isinstance(error, click.UsageError) else None
    line = f"{line[0].lower()}{line[1:]}" if line[1:2].islower() else line
    return f"{line} (see {context.command_path if context else program} --help)"


def _drop_output() -> None:
    """Let what is still to be written to the standard output go nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
