"""What the commands of all rooms share: errors, long work and Ctrl-C, each told in one line.

A room declares its words with click, next to what they do; `run_words` is the way into any of them.
"""

import os
import sys
from collections.abc import Sequence

import click

LONG = 10.0
"""Seconds from which on a command says beforehand how long it will take."""

WRONG = 2
"""Exit status after wrong input."""

INTERRUPTED, NO_READER = 130, 141
"""Exit status after Ctrl-C, and where the reader of the output has gone: 128 + the signal."""

json_option = click.option("--json", "json_wanted", is_flag=True, help="Print JSON.")


class Words(click.Group):
    """A group whose unknown word is told together with the known ones."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command of the first word; a UsageError lists the words if it is none."""
        if self.get_command(ctx, args[0]) is None and not args[0].startswith("-"):
            known = ", ".join(self.commands)
            raise click.UsageError(f"COMMAND must be a known one, got {args[0]} (one of {known})")
        return super().resolve_command(ctx, args)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The words in the order in which they are declared."""
        return list(self.commands)


def example(line: str) -> str:
    """The end of a command's help: an example."""
    return f"\b\nExample:\n  {line}"


def called_by() -> str:
    """What the running command was called by, as in `longwave verify mutations`."""
    return click.get_current_context().command_path


def run_words(command: click.Command, program: str, argv: Sequence[str] | None = None) -> int:
    """Run a command (by default on the words of the command line); return its exit status.

    0 if all is well; 1 if something is refuted, undecided, rejected, missing or did not come to its
    end; 2 for wrong input, told in one line; 130 after Ctrl-C; 141 if the reader of the output has
    gone.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    known = command.commands if isinstance(command, click.Group) else ()
    called = f"{program} {words[0]}" if words and words[0] in known else program
    try:
        with command.make_context(program, [*words], help_option_names=["-h", "--help"]) as context:
            status = command.invoke(context)
        sys.stdout.flush()
    except click.exceptions.Exit as stop:
        return stop.exit_code
    except click.ClickException as error:
        return _wrong(error, called)
    except (click.Abort, KeyboardInterrupt):
        return interrupted(called)
    except BrokenPipeError:
        _drop_output()
        return NO_READER
    except OSError as error:
        _drop_output()
        return fail(error)
    return int(status or 0)


def _drop_output() -> None:
    """Let what is still to be written to the standard output go nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _wrong(error: click.ClickException, called: str) -> int:
    """Tell a wrong word or option in one line, with the command whose help explains it."""
    line = " ".join(error.format_message().split()).removesuffix(".")
    context = error.ctx if isinstance(error, click.UsageError) else None
    if not line.startswith("COMMAND"):
        line = f"{line[0].lower()}{line[1:]}" if line[1:2].islower() else line
        line += f" (see {context.command_path if context else called} --help)"
    return fail(line)


def fail(message: object) -> int:
    """Print ``error: message`` in one line on stderr; return the exit status 2.

    An error of a file says which file, and what is wrong with it.
    """
    if isinstance(message, OSError) and message.strerror:
        message = f"{message.filename or 'output'}: {message.strerror}"
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
