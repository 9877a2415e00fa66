"""Reading of files named by the user, and safe quoting of their content in messages.

Only regular files are read, up to a size, as UTF-8 with or without a byte order mark; ``-`` is the
standard input. Content that is nested or dotted too deep for its parser is refused before it costs
time.
"""

from __future__ import annotations

import os
import re
import stat
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

StatusCheck = Callable[[os.stat_result], object]
"""Function of a file's status that raises an error if the file must not be read."""

STANDARD_INPUT = "-"

MAX_DEPTH = 100
"""Largest number of levels of nested tables and lists."""

QUOTED = 200
"""Largest number of characters that an error quotes of a file's name or of a library's message."""

DEEP_KEY = re.compile(
    rb"""(?:^|[\[{,])[ \t]*(?:(?:[\w-]{1,99}|"[^"\n]{0,99}"|'[^'\n]{0,99}')[ \t]*\.[ \t]*){20}""",
    re.MULTILINE,
)
"""Pattern of a key with many dots, for which tomllib's time and memory grow with the square of
their number: 1.2 GB for 50 000."""

FILE_KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


def shown(value: object) -> str:
    """Return the value as messages show it: as short text on one line, whatever it contains.

    >>> shown(10**5000)
    'an integer of 16610 bits'
    """
    if isinstance(value, int) and value.bit_length() > 1000:
        return f"an integer of {value.bit_length()} bits"
    try:
        line = " ".join(repr(value).split())
    except RecursionError:
        return f"a {type(value).__name__} that is nested too deep"
    return cut(line, 60)


def cut(text: str, length: int) -> str:
    """Return the text, truncated to at most ``length`` characters.

    >>> cut("a long text", 8)
    'a lon...'
    """
    return text if len(text) <= length else f"{text[: length - 3]}..."


def shown_path(path: str | Path) -> str:
    r"""Return the path as errors show it: short, with control characters escaped.

    >>> print(shown_path("a\x1b[31m\n.toml"))
    a\x1b[31m\n.toml
    """
    text = str(path)
    if len(text) > QUOTED:
        text = f"{text[: QUOTED // 2]}...{text[3 - QUOTED // 2 :]}"
    return on_one_line(text)


def on_one_line(text: str) -> str:
    r"""Return the text with line ends and control characters escaped.

    >>> print(on_one_line("kept in a\n.nc"))
    kept in a\n.nc
    """
    return printable(text).replace("\n", "\\n")


def reason_of(error: BaseException) -> str:
    """Return a library's error message, which may quote a user's file, as one short line.

    >>> len(reason_of(ValueError(1000 * "x")))
    200
    """
    return cut(on_one_line(str(error)), QUOTED)


def printable(text: str) -> str:
    r"""Return the text with control characters escaped, except line ends.

    >>> print(printable("red: \x1b[31m"))
    red: \x1b[31m
    """
    return "".join(c if c.isprintable() or c == "\n" else ascii(c)[1:-1] for c in text)


def file_stem(path: str | Path) -> str:
    """Return the file's name without folder and suffix; "stdin" for ``-``."""
    return "stdin" if str(path) == STANDARD_INPUT else Path(path).stem


def read_bytes(
    path: str | Path, label: str, max_bytes: int, check: StatusCheck = lambda _: None
) -> bytes:
    """Return the content of a regular file, or of the standard input for ``-``.

    ``label`` names the kind of file in errors, such as "scene". ``check`` is called with the status
    of the opened file. Raises ValueError if it is not a regular file or has more than
    ``max_bytes``, OSError if it cannot be opened, and errors of ``check``.
    """
    if str(path) == STANDARD_INPUT:
        content = sys.stdin.buffer.read(max_bytes + 1)
    else:
        # without O_NONBLOCK, opening a pipe would wait for a writer; its kind is checked after that
        if "\0" in str(path):
            raise ValueError(
                f"{label} must be a file's name, got {shown_path(path)} (leave out \\x00)"
            )
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
        try:
            state = os.fstat(handle)
            kind = FILE_KINDS.get(stat.S_IFMT(state.st_mode))
            if kind is not None:
                raise ValueError(
                    f"{label} must be a regular file, got {shown_path(path)}, {kind} "
                    "(- reads from the standard input)"
                )
            check(state)
            with open(handle, "rb", closefd=False) as file:
                content = file.read(max_bytes + 1)
        finally:
            os.close(handle)
    if len(content) > max_bytes:
        raise ValueError(
            f"{label} must have at most {max_bytes:.0f} bytes, got {shown_path(path)} with more "
            "(name a shorter file)"
        )
    return content


def read_text(
    path: str | Path, label: str, max_bytes: int, check: StatusCheck = lambda _: None
) -> str:
    """Return the text of a file, read by `read_bytes`; raise ValueError also if it is not UTF-8."""
    return _text(read_bytes(path, label, max_bytes, check), path, label)


def read_toml(path: str | Path, label: str, max_bytes: int) -> dict[str, Any]:
    """Return the tables of a TOML file; raise errors as `read_bytes` and `parse_toml` do."""
    return parse_toml(read_bytes(path, label, max_bytes), path, label)


def parse_toml(content: bytes, path: str | Path, label: str) -> dict[str, Any]:
    """Return the tables in ``content``; raise ValueError if it is not TOML or nested too deep."""
    if DEEP_KEY.search(content):
        raise ValueError(
            f"{label} must have plain keys, got one with 20 or more dots in {shown_path(path)} "
            "(write tables)"
        )
    text = _text(content, path, label)
    try:
        document = tomllib.loads(text)
        deep = is_deep(document)
    except RecursionError:
        deep = True
    except tomllib.TOMLDecodeError as error:
        reason = cut(" ".join(str(error).split()), QUOTED)
        raise ValueError(
            f"{label} must be a TOML file, got {shown_path(path)}: {reason} (mend it)"
        ) from None
    except ValueError:
        raise ValueError(
            f"{label} must have numbers of some digits, got one of thousands in {shown_path(path)} "
            "(shorten it)"
        ) from None
    if deep:
        raise ValueError(
            f"{label} must be nested at most {MAX_DEPTH} deep, got {shown_path(path)} with more "
            "(flatten it)"
        )
    return document


def toml_value(text: str) -> Any:
    """Parse a text as a TOML value; return the text itself if it is not a TOML value, or is a date.

    >>> toml_value("0.05"), toml_value("[0, 1]"), toml_value("kink"), toml_value('"pi/2"')
    (0.05, [0, 1], 'kink', 'pi/2')
    """
    if "\n" in text:
        return text
    try:
        document = parse_toml(f"value = {text}".encode(), "--set", "--set")
    except ValueError:
        return text
    value = document["value"]
    plain = len(document) == 1 and isinstance(value, bool | int | float | str | list | dict)
    return value if plain else text


def is_deep(data: object) -> bool:
    """Return whether mappings and lists are nested more than ``MAX_DEPTH`` levels deep.

    >>> is_deep({"a": [1, {"b": []}]})
    False
    """
    level = [data]
    for _ in range(MAX_DEPTH):
        inner: list[object] = []
        for entry in level:
            if isinstance(entry, dict):
                inner += entry.values()
            elif isinstance(entry, list | tuple):
                inner += entry
        level = inner
    return bool(level)


def _text(content: bytes, path: str | Path, label: str) -> str:
    """Decode UTF-8; raise ValueError that names the first byte that is not UTF-8."""
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(
            f"{label} must be a text in UTF-8, got {shown_path(path)} with the byte "
            f"0x{content[error.start]:02x} at {error.start} (save it as UTF-8)"
        ) from None
