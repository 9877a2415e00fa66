"""What the commands of all rooms share: errors, long work and Ctrl-C, each told in one line.

A room declares its words with click, next to what they do; `run_words` is the way into any of them.
"""

import errno
import math
import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from typing import Any, TypeVar

import click

from longwave.support.interruption import (
    call_it,
    ended_after,
    ended_beyond,
    interrupted,
    interruptible,
    owns_process,
    stated_memory,
    was_interrupted,
)
from longwave.support.known_names import did_you_mean, one_of
from longwave.support.request_limits import (
    USUAL_SECONDS,
    ExpectedCost,
    RequestLimits,
    check_request,
    duration,
    enforced_memory,
    memory_text,
    request_limits,
)
from longwave.support.slow_work import announce, time_told
from longwave.support.user_files import cut, printable, toml_value

WRONG, BROKEN = 2, 1
"""Exit status after wrong input, and where the disk did not take what was to be written."""

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
"""What a disk says that takes no more."""

NO_READER = 141
"""Exit status where the reader of the output has gone: 128 + the signal."""

QUOTED, LONGEST = 200, 4000
"""Most characters of the input that an error quotes, and of an error with all that it lists."""

_ARGV = "longwave.argv"

Wrapped = TypeVar("Wrapped", bound=Callable[..., Any])
Number = TypeVar("Number", int, float)

force_option = click.option(
    "--force", is_flag=True, help="Overwrite what is written, if it is there."
)
json_option = click.option("--json", "json_wanted", is_flag=True, help="Print JSON.")


def path_option(name: str, metavar: str, said: str) -> Callable[[Wrapped], Wrapped]:
    """Give a command an option that names a file or a folder."""
    return click.option(name, metavar=metavar, type=click.Path(), help=said)


class CommandGroup(click.Group):
    """A group of commands, in the order in which they are declared.

    An unknown one is told together with those, and with what else to write, if that is given.
    """

    def __init__(self, *arguments: Any, otherwise: str = "", **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._otherwise = f"; {otherwise}" if otherwise else ""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The command of the first argument; a UsageError lists the commands if it is none."""
        if self.get_command(ctx, args[0]) is None and not args[0].startswith("-"):
            known = one_of(args[0], self.commands) + self._otherwise
            raise click.UsageError(f"COMMAND must be a known one, got {args[0]} ({known})")
        return super().resolve_command(ctx, args)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The names of the commands."""
        return list(self.commands)


def example(line: str) -> str:
    """The end of a command's help: an example."""
    return f"\b\nExample:\n  {line}"


Limit = Callable[[str | None], AbstractContextManager[object]]


def _held(limits: Limit) -> Callable[[click.Context, click.Parameter, str | None], None]:
    """Return an option's callback: the limits that it gives hold while the command runs."""

    def hold(context: click.Context, _: click.Parameter, given: str | None) -> None:
        try:
            context.with_resource(limits(given))
        except ValueError as error:
            raise click.BadParameter(str(error).partition(" ")[2]) from None

    return hold


def _estimated_memory(given: str | None) -> AbstractContextManager[RequestLimits]:
    """Refuse requests that are estimated to take more memory."""
    return request_limits(memory=given)


def _estimated_time(given: str | None) -> AbstractContextManager[RequestLimits]:
    """Refuse requests that are estimated to take longer."""
    return request_limits(seconds=USUAL_SECONDS if given is None else given)


@contextmanager
def _enforced_memory(given: str | None) -> Iterator[None]:
    """Refuse by estimate; one that is stated fails beyond it as well, whatever the estimate."""
    with ExitStack() as held:
        limits = held.enter_context(_estimated_memory(given))
        if given and owns_process():
            allowed = limits.memory_bytes
            limit = (
                f"must fit {memory_text(allowed)} and did not (take less, or raise --max-memory)"
            )
            held.enter_context(ended_beyond(allowed, limit))
            held.enter_context(enforced_memory(allowed))
        yield


@contextmanager
def _enforced_time(given: str | None) -> Iterator[None]:
    """Refuse by estimate; one that is stated ends the command as well, whatever the estimate."""
    with _estimated_time(given) as limits:
        allowed = limits.seconds if given else math.inf
        limit = f"must end within {duration(allowed)} and had not (take less, or raise --max-time)"
        with ended_after(allowed, limit):
            yield


def limits_of_each(memory: str = "", time: str = "") -> Callable[[Wrapped], Wrapped]:
    """Give a command `--max-memory` and `--max-time`, which hold while it runs.

    Unless told they are these, of a command that has many runs in turn, or the usual ones. Limits
    of each run are compared with its estimate; stated ones of a command are enforced as well.
    """
    each = bool(memory or time)
    hold_memory = _held(_estimated_memory if each else _enforced_memory)
    hold_time = _held(_estimated_time if each else _enforced_time)

    def limited(command: Wrapped) -> Wrapped:
        for name, metavar, said, own, usual, hold in (
            ("memory", "SIZE", "more, as 4G", memory, "half of the machine's", hold_memory),
            ("time", "TIME", "longer, as 30min", time, "1h", hold_time),
        ):
            said = f"Refuse what takes {said} (default {own or usual})."
            words: dict[str, Any] = {"default": own or None, "expose_value": False}
            option = click.option(
                f"--max-{name}", metavar=metavar, help=said, callback=hold, **words
            )
            command = option(command)
        return command

    return limited


limit_options = limits_of_each()


def listed(
    name: str, text: str, part: Callable[[str], Number], what: str, usual: str
) -> tuple[Number, ...]:
    """The numbers in the text of an option, ``what`` being said of them where they are none.

    >>> listed("--eps", "0.1, 0.05", float, "numbers", "such as 0.1,0.05")
    (0.1, 0.05)
    """
    try:
        return tuple(map(part, text.split(",")))
    except ValueError:
        raise ValueError(
            f"{name} must be {what} with commas between, got {text[:60]!r} ({usual})"
        ) from None


def named_values(name: str, texts: Iterable[str], usual: str = "m1=1,m2=3") -> dict[str, str]:
    """The values in the texts of an option, by their names; an error shows what is ``usual``.

    A comma in brackets or quotes is a value's own. Raises UsageError for a name that is given
    twice.

    >>> named_values("--set", ["m1=1,m2=3", "times=[0, 1]"])
    {'m1': '1', 'm2': '3', 'times': '[0, 1]'}
    """
    found: dict[str, str] = {}
    for part in (part for text in texts for part in _parts(text)):
        word, sign, value = (piece.strip() for piece in part.partition("="))
        if not (word and sign and value):
            raise click.UsageError(f"{name} must be NAME=VALUE, got {part!r} (such as {usual})")
        if word in found:
            raise click.UsageError(
                f"{name} must give {word} one value, got {found[word]} and {value} (leave one out)"
            )
        found[word] = value
    return found


def _parts(text: str) -> list[str]:
    """What stands between the commas of a text that are in no brackets and no quotes.

    >>> _parts('a=[1, 2],b="c, d"')
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


def _fields(_: click.Context, __: click.Parameter, texts: tuple[str, ...]) -> dict[str, Any]:
    """The values of a scene's fields in the texts of `--set`, each as a scene's file has it."""
    given = named_values("--set", texts, "eps=0.05,parameters.k=0.7")
    return {field: toml_value(text) for field, text in given.items()}


set_option = click.option(
    "--set",
    "changes",
    multiple=True,
    metavar="FIELD=VALUE,...",
    callback=_fields,
    help="Other values for fields of the scene, as eps=0.05,parameters.k=0.7.",
)


def called_by() -> str:
    """What the running command was called by, as in `longwave verify mutations`."""
    return click.get_current_context().command_path


def run_words(command: click.Command, program: str, argv: Sequence[str] | None = None) -> int:
    """Run a command (by default on the arguments of the process); return its exit status.

    0 if all is well; 1 if something is refuted, undecided, rejected, missing or did not come to its
    end; 2 for wrong input, told in one line; 130 after Ctrl-C, 143 after SIGTERM; 141 if the reader
    of the output has gone. The process is watched for silence and signals as a whole if they are
    its own.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    called = _called(command, program, arguments)
    call_it(called)
    whole = argv is None
    with time_told(called) if whole else nullcontext():
        return interruptible(called, lambda: _run(command, program, called, arguments), whole)


def _called(command: click.Command, program: str, argv: Sequence[str]) -> str:
    """Return what the command of these words is called by, as in `longwave verify mutations`."""
    for word in argv:
        inner = command.commands.get(word) if isinstance(command, click.Group) else None
        if inner is None:
            break
        command, program = inner, f"{program} {word}"
    return program


def _run(command: click.Command, program: str, called: str, argv: Sequence[str]) -> int:
    try:
        with command.make_context(program, [*argv], help_option_names=["-h", "--help"]) as context:
            context.meta[_ARGV] = argv
            status = command.invoke(context)
        return _flushed(int(status or 0))
    except click.exceptions.Exit as stop:
        return _flushed(stop.exit_code)
    except click.ClickException as error:
        return _wrong(error, called, argv)
    except (click.Abort, KeyboardInterrupt):
        return interrupted(called)
    except BrokenPipeError:
        _drop_output()
        return NO_READER
    except (ValueError, OSError) as error:
        if isinstance(error, OSError) and error.filename is None:
            _drop_output()
        return fail(error)
    except MemoryError:
        if limit := stated_memory():
            return fail(f"{called} {limit}")
        return fail("the request must fit the memory, got one that does not (make it smaller)")


def _flushed(status: int) -> int:
    """The exit status, when all output is written."""
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
    """Let what is still to be written to the standard output go nowhere."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _wrong(error: click.ClickException, called: str, argv: Sequence[str]) -> int:
    """Tell a wrong command or option in one line, with the command whose help explains it."""
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
    line = " ".join(_quoting_little(message, argv).split()).removesuffix(".")
    if not line.startswith("COMMAND"):
        line = f"{line[0].lower()}{line[1:]}" if line[1:2].islower() else line
        see = f"see {context.command_path if context else called} --help"
        line += f" ({remedy} {see})" if remedy else f" ({see})"
    return fail(line)


def fail(message: object) -> int:
    """Print ``error: message`` in one line on stderr; return the exit status 2, or 1 where the disk
    is full.

    An error of a file says which file, and what is wrong with it. What the command line holds is
    quoted in at most ``QUOTED`` characters. After Ctrl-C that is told instead: what it breaks off
    may raise anything. That the reader of the output has gone is no error: it is raised again.
    """
    if was_interrupted():
        return interrupted()
    if isinstance(message, BrokenPipeError):
        raise message
    status = BROKEN if isinstance(message, OSError) and message.errno in FULL else WRONG
    if isinstance(message, OSError) and message.strerror:
        message = f"{message.filename or 'output'}: {message.strerror}"
    context = click.get_current_context(silent=True)
    argv = context.meta.get(_ARGV, ()) if context is not None else ()
    print(f"error: {one_line(_quoting_little(str(message), argv))}", file=sys.stderr)
    return status


def _quoting_little(message: str, argv: Iterable[str]) -> str:
    """The message with long arguments cut, as they are or as Python writes them, and whatever else
    is long without a space."""
    if len(message) <= QUOTED:
        return message
    for part in {part for argument in argv for part in (argument, argument.partition("=")[2])}:
        for text in (part, repr(part)[1:-1]):
            if len(text) > QUOTED // 2:
                message = message.replace(text, cut(text, QUOTED // 2))
    return re.sub(rf"\S{{{QUOTED},}}", lambda found: cut(found[0], QUOTED // 2), message)


def fail_for_memory(error: MemoryError, what: str = "sites") -> int:
    """`fail` for a scene with too many ``what``."""
    if limit := stated_memory():
        return fail(f"{called_by()} {limit}")
    return fail(f"{what} must fit the memory, got a scene that does not: {error} (take fewer)")


def one_line(message: object) -> str:
    r"""The message in one line of at most ``LONGEST``, what would steer the terminal written out.

    >>> print(one_line("two\nlines, \x1b[31mred"))
    two lines, \x1b[31mred
    """
    return printable(cut(" ".join(str(message).split()), LONGEST))


def check_and_announce(
    work: str, seconds: float, memory: float = 0.0, cheaper: str = "take less at once"
) -> None:
    """`announce` the work; OverBudgetError if it takes more than the limits allow."""
    check_request(work, ExpectedCost(seconds, memory), cheaper)
    announce(work, seconds)
