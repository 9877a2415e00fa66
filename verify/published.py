"""Library of published solutions: the problem files in ``solutions/library``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import cache
from importlib.resources import as_file, files

from rich.table import Table

from longwave.support.console import table_console
from longwave.support.known_names import did_you_mean
from longwave.support.user_files import shown
from longwave.verify.problem_file import ProblemText, problem_texts

FOLDER = files("longwave.solutions.library")

FROM_MEMORY = "not looked up"
"""Mark after a source that was not looked up in a text."""


@cache
def published() -> tuple[ProblemText, ...]:
    """Return all statements of the library, sorted by equation, variants after their originals.

    >>> "kdv_one_soliton" in {text.name for text in published()}
    True
    """
    statements: list[ProblemText] = []
    for entry in sorted(FOLDER.iterdir(), key=lambda entry: entry.name):
        if entry.name.endswith(".toml"):
            with as_file(entry) as path:
                statements += problem_texts(path)
    return tuple(sorted(statements, key=lambda text: text.equation_name.lower()))


def chosen(names: Sequence[str] = (), others: Sequence[str] = ()) -> list[ProblemText]:
    """Return the statements with these names or equations; without ``names``, all of them.

    Raises ValueError for an unknown name and suggests a similar one, also from ``others``.

    >>> [text.name for text in chosen(["kdv_one_soliton"])]
    ['kdv_one_soliton']
    """
    known = {word for text in published() for word in (text.name, text.equation_name)}
    for name in names:
        if name not in known:
            similar = did_you_mean(name, (*sorted(known), *others))
            words = "name must be a statement or equation of the library"
            remedy = similar or "longwave list --library shows them"
            raise ValueError(f"{words}, got {shown(name)} ({remedy})")
    requested = {*names} or known
    return [text for text in published() if requested & {text.name, text.equation_name}]


def source_of(text: ProblemText) -> str:
    """Return the source, marked if it was not looked up; for a wrong variant, its origin."""
    if text.misprint_in:
        return f"misprint in {text.misprint_in}"
    if text.variant_of:
        return f"variant of {text.variant_of}"
    return text.source if text.looked_up else f"{text.source} ({FROM_MEMORY})"


def records() -> list[dict[str, object]]:
    """Return the library as plain data, without empty values."""
    tables = (vars(text).items() for text in published())
    return [{key: value for key, value in t if value and key != "where"} for t in tables]


def print_library() -> None:
    """Print name, equation, source and expected verdict of all statements, sorted by equation."""
    table = Table(title="library", title_justify="left")
    for heading in ("name", "equation", "source", "expected"):
        table.add_column(heading, no_wrap=heading == "name")
    before = ""
    for text in published():
        if before and text.equation_name != before:
            table.add_section()
        shown_name = text.equation_name if text.equation_name != before else ""
        table.add_row(text.name, shown_name, source_of(text), text.expect)
        before = text.equation_name
    console = table_console()
    console.print(table)
    counts = Counter(text.expect for text in published())
    equations = len({text.equation_name for text in published()})
    numbers = "; ".join(f"{count} {expect}" for expect, count in counts.items())
    console.print(f"{len(published())} statements over {equations} equations: {numbers}")
