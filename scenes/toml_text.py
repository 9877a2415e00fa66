"""Tables written as TOML, so that reading gives the same tables: numbers to the last bit."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from numbers import Integral, Real

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def toml_text(document: Mapping[str, object]) -> str:
    """The document as TOML: values first, then its tables, each with all that is in it inline.

    A value is a text, a truth value, a number, a list or a table; ValueError for any other.

    >>> print(toml_text({"wave": "kink", "lattice": {"K2": 0.1}, "times": [0, 1e-5]}), end="")
    wave = "kink"
    times = [0, 1e-05]
    <BLANKLINE>
    [lattice]
    K2 = 0.1
    """
    tables = {name: value for name, value in document.items() if isinstance(value, Mapping)}
    lines = [_line(name, value) for name, value in document.items() if name not in tables]
    for name, table in tables.items():
        lines += ["", f"[{_key(name)}]", *(_line(*entry) for entry in table.items())]
    return "\n".join(lines).lstrip("\n") + "\n"


def _line(name: str, value: object) -> str:
    return f"{_key(name)} = {_value(value)}"


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else _text(name)


def _value(value: object) -> str:
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Integral):
        return str(int(value))
    if isinstance(value, Real):
        return repr(float(value))
    if isinstance(value, Mapping):
        return f"{{{', '.join(_line(*entry) for entry in value.items())}}}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    raise ValueError(
        f"a value of TOML must be a text, a number, a list or a table, got {type(value).__name__} "
        "(leave it out)"
    )


def _text(text: str) -> str:
    """A text in quotes; JSON writes what TOML reads, but for one sign that steers terminals."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
