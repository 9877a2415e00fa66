"""Problem files: statements in TOML, the input of ``longwave prove FILE.toml``.

[[problem]]
name = "KdV soliton"
equation = "u_t + 6*u*u_x + u_xxx"          # or a list
solution = "u = 2*k**2*sech(k*(x - 4*k**2*t))**2"
parameters = "k: k>0"
domain = "t > 0"
solve = "k"                                 # parameters to solve for
variables = "x, t"                          # needed for names other than x, y, z, t and n
weak = true                                 # check as a weak solution, across jumps or corners
source = "free text"
expect = "PROVED"

[[problem]]
name = "KdV soliton, wrong speed"
variant_of = "KdV soliton"                  # missing keys are taken from that problem
solution = "u = 2*k**2*sech(k*(x - 2*k**2*t))**2"
note = "what is wrong"
expect = "REFUTED"
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from longwave.derive.algebra.formula_text import FormulaError
from longwave.support.known_names import one_of
from longwave.support.user_files import file_stem, read_toml, shown, shown_path
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.typed_statement import Statement
from longwave.verify.verdict import Outcome

FILE_BYTES, PROBLEMS = 5_000_000, 10_000

NAME_LENGTH = 100

FORMULAS = ("equation", "solution")
"""Keys whose value is a text or a list of texts."""

TAKEN = (
    *("equation", "solution", "parameters", "domain", "variables", "weak"),
    *("source", "equation_name", "looked_up"),
)
"""Keys that a variant without them takes from its original."""

EXPECTED = (Outcome.PROVED, Outcome.REFUTED, Outcome.UNDECIDED)


@dataclass(frozen=True)
class StatedProblem:
    """A statement with its expected verdict (may be empty) and its source."""

    statement: Statement
    expect: str = ""
    source: str = ""


@dataclass(frozen=True)
class UnreadableProblem:
    """A problem whose formulas cannot be read, and the error."""

    name: str
    error: FormulaError
    expect: str = ""
    source: str = ""


@dataclass(frozen=True)
class ProblemText:
    """A problem as written in the file, before its formulas are parsed.

    ``looked_up`` is the address of a text with the formula, up to names and scales; it is empty if
    the formula is written from memory.  ``variant_of`` names the problem of which this is a wrong
    variant, ``note`` describes the error, and ``misprint_in`` names a publication that has it.
    """

    where: str
    name: str
    equation: tuple[str, ...]
    solution: tuple[str, ...]
    parameters: str = ""
    domain: str = ""
    solve: str = ""
    variables: str = ""
    source: str = ""
    expect: str = ""
    equation_name: str = ""
    looked_up: str = ""
    variant_of: str = ""
    misprint_in: str = ""
    note: str = ""
    weak: bool = False

    def problem(self) -> StatedProblem:
        """Parse the formulas; raises FormulaError with the problem's number and name."""
        texts = self.equation, self.solution, self.parameters, self.domain
        names = {"name": self.name, "solve": self.solve, "variables": self.variables}
        try:
            statement = read_statement(*texts, **names, weak=self.weak)
            return StatedProblem(statement, self.expect, self.source)
        except FormulaError as error:
            raise error.within(f"{self.where} ({self.name})") from None

    def problem_or_error(self) -> StatedProblem | UnreadableProblem:
        """Return `problem`, or the error as an `UnreadableProblem`."""
        try:
            return self.problem()
        except FormulaError as error:
            return UnreadableProblem(self.name, error, self.expect, self.source)


def problem_texts(path: Path) -> list[ProblemText]:
    """Return the problems of a TOML file (``-`` is the standard input) with unparsed formulas.

    Raises ValueError with the problem's number, and OSError if the file cannot be opened.
    """
    name, stem = shown_path(path), file_stem(path)
    data = read_toml(path, "problem file", FILE_BYTES)
    tables = data.get("problem")
    if set(data) != {"problem"} or not isinstance(tables, list) or not tables:
        got = ", ".join(map(shown, data)) or "nothing"
        raise ValueError(f"{name} must hold [[problem]] tables and nothing else, got {got}")
    if len(tables) > PROBLEMS:
        raise ValueError(f"{name} must have at most {PROBLEMS} problems, got {len(tables)}")
    problems: list[ProblemText] = []
    for number, table in enumerate(tables, 1):
        earlier = {text.name: text for text in problems}
        problems.append(_problem(f"{name}, problem {number}", f"{stem} {number}", table, earlier))
    return problems


def _problem(
    where: str, unnamed: str, table: Any, earlier: Mapping[str, ProblemText]
) -> ProblemText:
    if not isinstance(table, dict):
        raise ValueError(f"{where} must be a table, got {shown(table)} (begin with [[problem]])")
    known = [key.name for key in fields(ProblemText) if key.name != "where"]
    for key in table:
        if key not in known:
            got = f"{shown(key)} ({one_of(key, known)})"
            raise ValueError(f"{where}: keys must be known ones, got {got}")
    original, texts = table.get("variant_of"), dict[str, Any](table)
    if isinstance(original, str) and original in earlier:
        texts = {key: getattr(earlier[original], key) for key in TAKEN} | texts
    elif original is not None:
        words = "variant_of must be the name of a problem above"
        raise ValueError(f"{where}: {words}, got {shown(original)}")
    for key in known:
        if key in FORMULAS:
            texts[key] = _formula_texts(where, key, texts.get(key))
        elif key == "weak":
            if not isinstance(texts.setdefault(key, False), bool):
                got = shown(texts[key])
                raise ValueError(f"{where}: weak must be true or false, got {got} (without quotes)")
        elif not isinstance(text := texts.setdefault(key, ""), str):
            raise ValueError(f"{where}: {key} must be text, got {shown(text)} (put it in quotes)")
    texts["name"] = name = texts["name"] or unnamed
    if not name.isprintable() or len(name) > NAME_LENGTH:
        words = f"one printable line of {NAME_LENGTH} characters at most"
        raise ValueError(f"{where}: name must be {words}, got {shown(name)}")
    if texts["expect"] not in ("", *EXPECTED):
        words = ", ".join(EXPECTED)
        raise ValueError(f"{where}: expect must be one of {words}, got {shown(texts['expect'])}")
    return ProblemText(where, **texts)


def _formula_texts(where: str, key: str, given: Any) -> tuple[str, ...]:
    texts = [given] if isinstance(given, str) else given
    if not isinstance(texts, list | tuple) or not texts:
        texts = [None]
    if not all(isinstance(text, str) for text in texts):
        got = "nothing" if given is None else shown(given)
        raise ValueError(f"{where}: {key} must be text or a list of texts, got {got}")
    return tuple(texts)
