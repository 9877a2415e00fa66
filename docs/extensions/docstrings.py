"""Docstrings as reStructuredText: they are plain text with `code`, lists and doctests in it."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

_CODE = re.compile(r"(``.+?``|`[^`]+`)")
_SPECIAL = re.compile(r"[|*]|(?<=\w)_(?!\w)")
_BULLET = re.compile(r"\s*[*] ")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register `as_restructured_text` for every docstring."""
    app.connect("autodoc-process-docstring", _process)
    return {"parallel_read_safe": True}


def as_restructured_text(lines: list[str]) -> list[str]:
    r"""Escape what is mathematics in the docstring and would be markup: |x|, x*, p_ .

    >>> as_restructured_text(["``|x|`` is |x|:", "* p_i and p_", "", ">>> 2 * 3", "6"])
    ['``|x|`` is \\|x\\|:', '* p_i and p\\_', '', '>>> 2 * 3', '6']
    >>> as_restructured_text(["rows::", "", "  a | b", "", "|a|"])
    ['rows::', '', '  a | b', '', '\\|a\\|']
    """
    result, doctest = [], False
    deeper: int | None = None  # indentation of the line with :: while what belongs to it goes on
    for line in lines:
        indentation = len(line) - len(line.lstrip())
        if deeper is not None and line.strip() and indentation <= deeper:
            deeper = None
        doctest = line.lstrip().startswith(">>>") or (doctest and bool(line.strip()))
        if doctest or deeper is not None:
            result.append(line)
            continue
        result.append(_escaped(line))
        if line.endswith("::"):
            deeper = indentation
    return result


def _escaped(line: str) -> str:
    bullet = _BULLET.match(line)
    head = bullet[0] if bullet else ""
    parts = _CODE.split(line[len(head) :])
    plain = [_SPECIAL.sub(r"\\\g<0>", part) if i % 2 == 0 else part for i, part in enumerate(parts)]
    return head + "".join(plain)


def _process(app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    lines[:] = as_restructured_text(lines)
