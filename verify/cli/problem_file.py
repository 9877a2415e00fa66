"""Problem files: statements in TOML, as ``longwave prove FILE.toml`` takes them.

[[problem]]
name = "KdV soliton"
equation = "u_t + 6*u*u_x + u_xxx"          # or a list
solution = "u = 2*k**2*sech(k*(x - 4*k**2*t))**2"
parameters = "k: k>0"
domain = "t > 0"
source = "free text"
expect = "PROVED"
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from derive.algebra.exact_numbers import shown
from derive.algebra.formula_text import FormulaError
from verify.proof.statement_text import Statement, read_statement
from verify.verdict import Outcome

FILE_BYTES, PROBLEMS = 5_000_000, 10_000

NAME_LENGTH = 100

TEXTS = ("name", "parameters", "domain", "source", "expect")
"""The keys of a problem with one text; equation and solution may be lists."""

EXPECTED = (Outcome.PROVED, Outcome.REFUTED, Outcome.UNDECIDED)


@dataclass(frozen=True)
class StatedProblem:
    """A statement with what a file says beside it; ``expect`` is a verdict or empty."""

    statement: Statement
    expect: str = ""
    source: str = ""


def read_problems(path: Path) -> list[StatedProblem]:
    """The problems of a TOML file, in order.

    Raises ValueError, for a formula FormulaError, with the problem's name, and OSError as opening
    does.
    """
    with path.open("rb") as file:
        content = file.read(FILE_BYTES + 1)
    if len(content) > FILE_BYTES:
        raise ValueError(f"{path} must have at most {FILE_BYTES} bytes, got more (split it)")
    try:
        data = tomllib.loads(content.decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} must be a TOML file, got another text ({error})") from None
    tables = data.get("problem")
    if set(data) != {"problem"} or not isinstance(tables, list) or not tables:
        got = ", ".join(map(shown, data)) or "nothing"
        raise ValueError(f"{path} must hold [[problem]] tables and nothing else, got {got}")
    if len(tables) > PROBLEMS:
        raise ValueError(f"{path} must have at most {PROBLEMS} problems, got {len(tables)}")
    return [_problem(path, number, table) for number, table in enumerate(tables, 1)]


def _problem(path: Path, number: int, table: Any) -> StatedProblem:
    where = f"{path}, problem {number}"
    if not isinstance(table, dict):
        raise ValueError(f"{where} must be a table, got {shown(table)} (begin with [[problem]])")
    known = ("equation", "solution", *TEXTS)
    for key in table:
        if key not in known:
            raise ValueError(f"{where}: keys must be among {', '.join(known)}, got {shown(key)}")
    for key in ("equation", "solution"):
        _check_texts(where, key, table.get(key))
    texts = {key: table.get(key, "") for key in TEXTS}
    for key, text in texts.items():
        if not isinstance(text, str):
            raise ValueError(f"{where}: {key} must be text, got {shown(text)} (put it in quotes)")
    name = texts["name"] or f"{path.stem} {number}"
    if not name.isprintable() or len(name) > NAME_LENGTH:
        words = f"one printable line of {NAME_LENGTH} characters at most"
        raise ValueError(f"{where}: name must be {words}, got {shown(name)}")
    if texts["expect"] not in ("", *EXPECTED):
        words = ", ".join(EXPECTED)
        raise ValueError(f"{where}: expect must be one of {words}, got {shown(texts['expect'])}")
    try:
        statement = read_statement(
            table["equation"], table["solution"], texts["parameters"], texts["domain"], name=name
        )
    except FormulaError as error:
        raise error.within(f"{where} ({name})") from None
    return StatedProblem(statement, texts["expect"], texts["source"])


def _check_texts(where: str, key: str, given: Any) -> None:
    texts = given if isinstance(given, list) else [given]
    if not texts or not all(isinstance(text, str) for text in texts):
        got = "nothing" if given is None else shown(given)
        raise ValueError(f"{where}: {key} must be text or a list of texts, got {got}")
