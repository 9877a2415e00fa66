"""The command `longwave`: what the words of `longwave.commands` end with.

Exit status: 0 if all is well; 1 if something is refuted, undecided, rejected, missing or did not
come to its end; 2 for wrong input, told in one line; 130 after Ctrl-C; 141 if the reader of the
output has gone.
"""

import os
import sys
from collections.abc import Sequence

import click
from click.shell_completion import shell_complete

from longwave.commands import COMPLETION, longwave

WRONG, INTERRUPTED, NO_READER = 2, 130, 141


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit status."""
    words = list(sys.argv[1:] if argv is None else argv) or ["--help"]
    if COMPLETION in os.environ:
        return shell_complete(longwave, {}, "longwave", COMPLETION, os.environ[COMPLETION])
    try:
        with longwave.make_context("longwave", [*words]) as context:
            status = longwave.invoke(context)
        sys.stdout.flush()
    except click.exceptions.Exit as stop:
        return stop.exit_code
    except click.ClickException as error:
        return _wrong(error, words[0])
    except (click.Abort, KeyboardInterrupt):
        print(f"longwave {words[0]}: interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        _drop_output()
        return NO_READER
    except OSError as error:
        _drop_output()
        print(f"error: {error.filename or 'output'}: {error.strerror}", file=sys.stderr)
        return WRONG
    return int(status or 0)


def _drop_output() -> None:
    """Let what is still to be written to the standard output go nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _wrong(error: click.ClickException, word: str) -> int:
    """Tell a wrong word or option in one line, with the command whose help explains it."""
    line = " ".join(error.format_message().split()).removesuffix(".")
    line = "".join(sign if sign.isprintable() else ascii(sign)[1:-1] for sign in line)
    context = error.ctx if isinstance(error, click.UsageError) else None
    command = f"longwave {word}" if word in longwave.commands else "longwave"
    if not line.startswith("COMMAND"):
        line = f"{line[0].lower()}{line[1:]}" if line[1:2].islower() else line
        line += f" (see {context.command_path if context else command} --help)"
    print(f"error: {line}", file=sys.stderr)
    return WRONG


if __name__ == "__main__":
    sys.exit(main())
