"""The library of published solutions: a page for each family of equations, formulas rendered."""

from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path

from lists import linked, table
from longwave.verify.problem_file import ProblemText
from longwave.verify.proof.statement_latex import equations_latex, formulas_latex, scope_latex
from longwave.verify.published import published, source_of

LONGEST = 700
"""Characters of LaTeX beyond which a formula is shown as typed text."""

MISPRINTS = "misprints"
"""File of misprints found in publications; their equations have files of their own."""


def write_pages(folder: Path) -> None:
    """Write a page for each file of the library into the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, equations in families().items():
        path, text = folder / f"{name}.md", _page(name, equations)
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


@cache
def families() -> dict[str, tuple[str, ...]]:
    """Return the files of the library in alphabetical order, each with its equations.

    >>> families()["korteweg_de_vries"][0]
    'cylindrical Korteweg-de Vries'
    """
    homes: dict[str, str] = {}
    for text in published():
        name = Path(text.where.partition(", problem ")[0]).stem
        if homes.setdefault(text.equation_name, name) == MISPRINTS:
            homes[text.equation_name] = name
    return {
        name: tuple(equation for equation, home in homes.items() if home == name)
        for name in sorted(set(homes.values()))
    }


def contents() -> str:
    """Return a table of the pages: equations, and numbers of correct and wrong formulas."""
    rows = [
        [
            f"[{_title(name)}](generated/library/{name}.md)",
            "; ".join(equations),
            str(sum(text.expect == "PROVED" for text in _of(equations))),
            str(sum(text.expect == "REFUTED" for text in _of(equations))),
        ]
        for name, equations in families().items()
    ]
    return table(["page", "equations", "right", "wrong"], rows)


def _of(equations: Sequence[str]) -> list[ProblemText]:
    return [text for text in published() if text.equation_name in equations]


def _title(name: str) -> str:
    title = name.replace("_de_vries", "-de Vries").replace("klein_gordon", "Klein-Gordon")
    for person in ("schroedinger", "korteweg"):
        title = title.replace(person, person.capitalize())
    title = title.replace("_", " ")
    return f"{title[0].upper()}{title[1:]}"


def _page(name: str, equations: Sequence[str]) -> str:
    parts = [f"# {_title(name)}"]
    for equation in equations:
        parts.append(f"## {equation[0].upper()}{equation[1:]}")
        texts = _of([equation])
        for text in texts:
            if not text.variant_of:
                parts += _statement(text)
                parts += [_variant(v, text) for v in texts if v.variant_of == text.name]
    return "\n\n".join(parts) + "\n"


def _statement(text: ProblemText) -> Iterator[str]:
    """Yield heading, equations, formulas, domain and source of a statement."""
    statement = text.problem().statement
    yield f"### `{text.name}`"
    yield from _displayed(equations_latex(statement), text.equation)
    yield from _displayed(formulas_latex(statement), text.solution)
    note = f" {text.note[0].upper()}{text.note[1:]}." if text.note else ""
    source = linked(source_of(text), text.looked_up)
    yield f"**{text.expect}** {scope_latex(statement)}. {source}.{note}"


def _variant(text: ProblemText, original: ProblemText) -> str:
    """Return a list item with the difference of a wrong variant from its original."""
    statement = text.problem().statement
    found = f" {linked(source_of(text), text.looked_up)}" if text.misprint_in else ""
    note = f": {text.note}" if text.note else ""
    parts = [f"* **{text.expect}** `{text.name}`{found}{note}"]
    if text.equation != original.equation:
        parts += _displayed(equations_latex(statement), text.equation)
    if text.solution != original.solution:
        parts += _displayed(formulas_latex(statement), text.solution)
    return "\n\n".join(parts).replace("\n", "\n  ")


def _displayed(latex: str, typed: Sequence[str]) -> Iterator[str]:
    """Yield the formulas, each in its own line; long ones as typed text."""
    if len(latex) > LONGEST:
        yield "```text\n" + "\n".join(typed) + "\n```"
    else:
        yield from (f"$$\n{line}\n$$" for line in latex.split(r",\quad "))
