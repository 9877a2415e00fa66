"""Common parts of all commands: error lines, limits, options and exit statuses.

A room declares its commands with click next to their code; `run_words` runs any of them.
"""

import errno
import math
import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from contextvars import ContextVar
from itertools import pairwise
from typing import Any, TypeVar

import click

from longwave.support import interruption, request_limits
from longwave.support.known_names import did_you_mean, one_of
from longwave.support.slow_work import announce, report_time_left
from longwave.support.user_files import cut, printable, toml_value

WRONG, BROKEN = 2, 1
"""Exit statuses: `WRONG` after wrong input, `BROKEN` when the disk is full."""

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
"""Errors of a disk that accepts no more data."""

FILE_REMEDIES = {
    errno.ENOENT: "check the name; a new file's folder must exist",
    errno.ENOTDIR: "check the folders in its name",
    errno.EISDIR: "name a file in it",
    errno.EACCES: "change its permissions, or name another file",
    errno.EPERM: "change its permissions, or name another file",
    errno.ENAMETOOLONG: "shorten the name",
    **dict.fromkeys(FULL, "free some space, or write elsewhere"),
}
"""Remedies shown in messages, keyed by the errno of a file error."""

NO_READER = 141
"""Exit status when the reader of the output is gone: 128 + the signal's number."""

MAX_QUOTED, MAX_ERROR = 200, 4000
"""Largest number of characters of the input that an error quotes, and of a whole error message."""

_call: ContextVar[tuple[click.Command | None, Sequence[str]]] = ContextVar("_call")
"""Running command (None if it is unknown), and the words of its command line."""

Wrapped = TypeVar("Wrapped", bound=Callable[..., Any])
Number = TypeVar("Number", int, float)

force_option = click.option("--force", is_flag=True, help="Overwrite existing files.")
json_option = click.option("--json", "json_wanted", is_flag=True, help="Print JSON.")


def path_option(name: str, metavar: str, help_text: str) -> Callable[[Wrapped], Wrapped]:
    """Return a decorator that adds an option for a file or folder."""
    return click.option(name, metavar=metavar, type=click.Path(), help=help_text)


class CommandGroup(click.Group):
    """A group of commands, listed in the order of their declaration.

    The error for an unknown command lists the known commands, followed by ``otherwise`` if given.
    """

    def __init__(self, *arguments: Any, otherwise: str = "", **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._otherwise = f"; {otherwise}" if otherwise else ""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the first argument's command; raise UsageError with a list for an unknown one."""
        if self.get_command(ctx, args[0]) is None and not args[0].startswith("-"):
            known = one_of(args[0], self.commands) + self._otherwise
            raise click.UsageError(f"COMMAND must be a known one, got {args[0]} ({known})")
        return super().resolve_command(ctx, args)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of the commands."""
        return list(self.commands)


def example(line: str) -> str:
    """Return the example with which a command's help text ends."""
    return f"\b\nExample:\n  {line}"


Limit = Callable[[str | None], AbstractContextManager[object]]


def _limit_callback(limits: Limit) -> Callable[[click.Context, click.Parameter, str | None], None]:
    """Return an option's callback that applies the given limits while the command runs."""

    def hold(context: click.Context, _: click.Parameter, given: str | None) -> None:
        try:
            context.with_resource(limits(given))
        except ValueError as error:
            raise click.BadParameter(str(error).partition(" ")[2]) from None

    return hold


def _estimated_time(given: str | None) -> AbstractContextManager[request_limits.RequestLimits]:
    """Return a context that refuses requests whose estimated time exceeds the limit."""
    seconds = request_limits.USUAL_SECONDS if given is None else given
    return request_limits.request_limits(seconds=seconds)


@contextmanager
def _enforced_memory(given: str | None) -> Iterator[None]:
    """Refuse requests of the block that need too much memory, and enforce a limit if given."""
    with ExitStack() as stack:
        limits = stack.enter_context(request_limits.request_limits(given))
        if given and interruption.owns_process():
            allowed = limits.memory_bytes
            size = request_limits.memory_text(allowed)
            limit = f"must fit {size} and did not (take less, or raise --max-memory)"
            stack.enter_context(interruption.ended_beyond(allowed, limit))
            stack.enter_context(request_limits.enforced_memory(allowed))
        yield


@contextmanager
def _enforced_time(given: str | None) -> Iterator[None]:
    """Refuse requests of the block that take too long; end the command after a given limit."""
    with _estimated_time(given) as limits:
        allowed = limits.seconds if given else math.inf
        time = request_limits.duration(allowed)
        limit = f"must end within {time} and had not (take less, or raise --max-time)"
        with interruption.ended_after(allowed, limit):
            yield


def limits_of_each(memory: str = "", time: str = "") -> Callable[[Wrapped], Wrapped]:
    """Return a decorator that adds `--max-memory` and `--max-time`, applied while the command runs.

    ``memory`` and ``time`` are the defaults for a command that makes many runs one after another;
    the limits of such a command are compared with the estimate of each run. Without these two
    arguments the usual defaults apply, and limits that the user states are enforced on the whole
    command.
    """
    each = bool(memory or time)
    hold_memory = _limit_callback(request_limits.request_limits if each else _enforced_memory)
    hold_time = _limit_callback(_estimated_time if each else _enforced_time)

    def limited(command: Wrapped) -> Wrapped:
        for name, metavar, text, own, usual, hold in (
            ("memory", "SIZE", "more, as 4G", memory, "half of the machine's", hold_memory),
            ("time", "TIME", "longer, as 30min", time, "1h", hold_time),
        ):
            text = f"Refuse what takes {text} (default {own or usual})."
            words: dict[str, Any] = {"default": own or None, "expose_value": False}
            add = click.option(f"--max-{name}", metavar=metavar, help=text, callback=hold, **words)
            command = add(command)
        return command

    return limited


limit_options = limits_of_each()


def listed(
    name: str, text: str, convert: Callable[[str], Number], noun: str, hint: str
) -> tuple[Number, ...]:
    """Return the numbers in an option's text, separated by commas.

    Raises ValueError for other texts, saying that the numbers must be ``noun``, with the ``hint``.

    >>> listed("--eps", "0.1, 0.05", float, "numbers", "such as 0.1,0.05")
    (0.1, 0.05)
    """
    try:
        return tuple(map(convert, text.split(",")))
    except ValueError:
        raise ValueError(
            f"{name} must be {noun} with commas between, got {text[:60]!r} ({hint})"
        ) from None


def named_values(name: str, texts: Iterable[str], usual: str = "m1=1,m2=3") -> dict[str, str]:
    """Return values by name from an option's texts NAME=VALUE; ``usual`` is the example in errors.

    A comma in brackets or quotes belongs to the value. Raises UsageError for a name that is given
    twice.

    >>> named_values("--set", ["m1=1,m2=3", "times=[0, 1]"])
    {'m1': '1', 'm2': '3', 'times': '[0, 1]'}
    """
    result: dict[str, str] = {}
    for part in (part for text in texts for part in _split_at_commas(text)):
        word, sign, value = (piece.strip() for piece in part.partition("="))
        if not (word and sign and value):
            raise click.UsageError(f"{name} must be NAME=VALUE, got {part!r} (such as {usual})")
        if word in result:
            raise click.UsageError(
                f"{name} must give {word} one value, got {result[word]} and {value} (leave one out)"
            )
        result[word] = value
    return result


def _split_at_commas(text: str) -> list[str]:
    """Return the parts of a text between commas, ignoring commas in brackets or quotes.

    >>> _split_at_commas('a=[1, 2],b="c, d"')
    ['a=[1, 2]', 'b="c, d"']
    """
    parts, depth, quote = [""], 0, ""
    for sign in text:
        if quote or sign in "\"'":
            quote = ("" if sign == quote else quote) if quote else sign
        else:
            depth += (sign in "[{(") - (sign in ")}]")
        if sign == "," and not quote and depth <= 0:
            parts.append("")
        else:
            parts[-1] += sign
    return parts


def _set_fields(_: click.Context, __: click.Parameter, texts: tuple[str, ...]) -> dict[str, Any]:
    """Return the values of `--set` by field, each parsed as in a scene's file."""
    field_texts = named_values("--set", texts, "eps=0.05,parameters.k=0.7")
    return {field: toml_value(text) for field, text in field_texts.items()}


set_option = click.option(
    "--set",
    "changes",
    multiple=True,
    metavar="FIELD=VALUE,...",
    callback=_set_fields,
    help="Other values for fields of the scene, as eps=0.05,parameters.k=0.7.",
)


def command_name() -> str:
    """Return the full name of the running command, such as `longwave verify mutations`."""
    return click.get_current_context().command_path


def run_words(command: click.Command, program: str, argv: Sequence[str] | None = None) -> int:
    """Run a command (by default on the process's arguments) and return its exit status.

    The status is 0 for success; 1 if something is refuted, undecided, rejected, missing or
    incomplete; 2 for wrong input, reported in one line; 130 after Ctrl-C, 143 after SIGTERM; 141 if
    the reader of the output is gone. If the arguments are the process's own, signals are handled
    for the whole process, and the time left is reported from time to time.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    running, called = _named(command, program, arguments)
    _call.set((running, arguments))
    interruption.name_command(called)
    whole = argv is None
    with report_time_left(called) if whole else nullcontext():
        return interruption.interruptible(
            called, lambda: _run(command, program, called, arguments), whole
        )


def _named(command: click.Command, program: str, argv: Sequence[str]) -> tuple[click.Command, str]:
    """Return the subcommand that ``argv`` begins with, and its full name, from ``program`` on."""
    for word in argv:
        inner = command.commands.get(word) if isinstance(command, click.Group) else None
        if inner is None:
            break
        command, program = inner, f"{program} {word}"
    return command, program


def _run(command: click.Command, program: str, called: str, argv: Sequence[str]) -> int:
    """Run the command, and turn its errors into one line and an exit status."""
    try:
        with command.make_context(program, [*argv], help_option_names=["-h", "--help"]) as context:
            status = command.invoke(context)
        return _flushed(int(status or 0))
    except click.exceptions.Exit as stop:
        return _flushed(stop.exit_code)
    except click.ClickException as error:
        return _report_usage_error(error, called)
    except (click.Abort, KeyboardInterrupt):
        return interruption.interrupted(called)
    except BrokenPipeError:
        _drop_output()
        return NO_READER
    except (ValueError, OSError) as error:
        if isinstance(error, OSError) and error.filename is None:
            _drop_output()
        return fail(error)
    except MemoryError:
        if limit := interruption.stated_memory():
            return fail(f"{called} {limit}")
        return fail("the request must fit in memory, got one that does not (make it smaller)")


def _flushed(status: int) -> int:
    """Flush the output and return the exit status."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        _drop_output()
        return NO_READER
    except OSError as error:
        _drop_output()
        return fail(error)
    return status


def _drop_output() -> None:
    """Discard further standard output."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _report_usage_error(error: click.ClickException, called: str) -> int:
    """Report a wrong command or option in one line that names the help to see."""
    context = error.ctx if isinstance(error, click.UsageError) else None
    message, remedy = error.format_message(), ""
    if isinstance(error, click.NoSuchOption) and context is not None:
        message = f"no such option {error.option_name}"
        known = [name for parameter in context.command.params for name in parameter.opts]
        instead = context.command.context_settings.get("obj", {}).get(error.option_name)
        remedy = instead or did_you_mean(error.option_name, known)
    elif isinstance(error, click.BadParameter):
        choices = getattr(getattr(error.param, "type", None), "choices", ())
        remedy = did_you_mean(error.message.partition(" is not ")[0].strip("'"), choices)
    line = " ".join(_with_short_quotes(message).split()).removesuffix(".")
    if not line.startswith("COMMAND"):
        line = f"{line[0].lower()}{line[1:]}" if line[1:2].islower() else line
        see = f"see {context.command_path if context else called} --help"
        line += f" ({remedy} {see})" if remedy else f" ({see})"
    return fail(line)


def fail(message: object) -> int:
    """Print ``error: message`` in one line on stderr; return the exit status, 2 or 1.

    The status is 1 if the disk is full. The message of a file error names the argument, the file
    and a remedy. Parts of the command line are quoted with at most ``MAX_QUOTED`` characters. After
    Ctrl-C the interruption is reported instead of the error, because the stopped code may raise
    anything. A BrokenPipeError, from a reader that is gone, is raised again.
    """
    if interruption.was_interrupted():
        return interruption.interrupted()
    if isinstance(message, BrokenPipeError):
        raise message
    status = BROKEN if isinstance(message, OSError) and message.errno in FULL else WRONG
    if isinstance(message, OSError) and message.strerror:
        message = _file_message(message)
    print(f"error: {one_line(_with_short_quotes(str(message)))}", file=sys.stderr)
    return status


def _file_message(error: OSError) -> str:
    """Return the message of a file error, with the argument that names the file and a remedy."""
    remedy = FILE_REMEDIES.get(error.errno or 0, "name another file")
    if error.filename is None:
        return f"output must be usable, got {error.strerror} ({remedy})"
    path = os.fsdecode(error.filename)
    return f"{_argument_of(path)} must be usable, got {path}: {error.strerror} ({remedy})"


def _argument_of(path: str) -> str:
    """Return the name of the argument that gives the file or the file's folder, or else "path"."""
    command, words = _call.get((None, ()))
    parameters = command.params if command is not None else []
    options = {name for p in parameters if not getattr(p, "is_flag", False) for name in p.opts}
    metavars = [p.human_readable_name for p in parameters if isinstance(p, click.Argument)]
    for before, word in pairwise(["", *words]):
        option, _, value = word.partition("=") if word.startswith("--") else (before, "", word)
        if value and (path == value or path.startswith(f"{value.rstrip('/')}/")):
            metavar = re.split(r"[ |]", metavars[0])[-1] if metavars else "path"
            return option if option in options else metavar.strip("[].")
    return "path"


def _with_short_quotes(message: str) -> str:
    """Return the message with long arguments of the command and other long words truncated."""
    if len(message) <= MAX_QUOTED:
        return message
    _, argv = _call.get((None, ()))
    for part in {part for argument in argv for part in (argument, argument.partition("=")[2])}:
        for text in (part, repr(part)[1:-1]):
            if len(text) > MAX_QUOTED // 2:
                message = message.replace(text, cut(text, MAX_QUOTED // 2))
    return re.sub(rf"\S{{{MAX_QUOTED},}}", lambda result: cut(result[0], MAX_QUOTED // 2), message)


def fail_for_memory(error: MemoryError, what: str = "sites") -> int:
    """Report with `fail` that a scene has too many ``what`` for the memory; return the status."""
    if limit := interruption.stated_memory():
        return fail(f"{command_name()} {limit}")
    return fail(f"{what} must fit in memory, got a scene that does not: {error} (take fewer)")


def one_line(message: object) -> str:
    r"""Return the message in one line of at most ``MAX_ERROR``, with control characters escaped.

    >>> print(one_line("two\nlines, \x1b[31mred"))
    two lines, \x1b[31mred
    """
    return printable(cut(" ".join(str(message).split()), MAX_ERROR))


def check_and_announce(
    work: str, seconds: float, memory: float = 0.0, cheaper: str = "take less at once"
) -> None:
    """Announce the expected time of ``work``; raise OverBudgetError if it exceeds the limits."""
    request_limits.check_request(work, request_limits.ExpectedCost(seconds, memory), cheaper)
    announce(work, seconds)
