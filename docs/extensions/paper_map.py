"""The paper's map: each numbered equation and figure of the paper -> the objects that hold it.

Nothing is entered here. An object holds an equation when its own text says so: its docstring names
the number (`the paper's eq. (7)`, `the paper's eqs. (12) and (13)`, `the paper's eqs. (26) to
(28)`), or it is a record with the label in it, as a closed form's reference or a figure's label.
"""

import ast
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from house import dotted_name
from longwave.reports.paper import EQUATIONS, FIGURES, UNNUMBERED, cited

_NUMBERS = re.compile(r"[Tt]he paper's eqs?\. (\(\d+\)(?:(?:,| and| to|, and) \(\d+\))*)")
_RANGE = re.compile(r"\((\d+)\)(?: to \((\d+)\))?")

Statement = ast.stmt
Documented = ast.Module | ast.ClassDef | ast.FunctionDef


@dataclass(frozen=True)
class Holder:
    """An object whose source names the equations or figures of the paper that it implements.

    `name` is its dotted name inside `module`, empty for the module itself; `lines` are the first
    and the last line of its text in `path`, and `kind` is that of a Sphinx role. `described` is
    False for a record that has no docstring of its own.
    """

    path: Path
    module: str
    name: str
    kind: str
    lines: tuple[int, int]
    described: bool = True

    @property
    def target(self) -> str:
        """Return the dotted name under which the object is imported."""
        return f"{self.module}.{self.name}" if self.name else self.module


@dataclass(frozen=True)
class Row:
    """One line of the map: `place` as in "eq. (7)", the paper's label, and who holds it."""

    place: str
    label: str
    holders: tuple[Holder, ...]


def paper_map(house: Path, rooms: Sequence[str]) -> list[Row]:
    """Return a row for every numbered equation, every label and every figure, in their order."""
    known = list(_claims(house, rooms))
    labels = sorted((*EQUATIONS, *UNNUMBERED), key=lambda label: _place(label)[1])
    return [
        Row(_place(label)[0], label, _holders(_place(label)[0], known))
        for label in (*labels, *FIGURES)
    ]


def numbers_in(text: str) -> set[int]:
    """Return the numbers of the paper's equations that a docstring names.

    >>> sorted(numbers_in("as in the paper's eqs. (2), (3) and (26) to (28); eq. (9) of Kahan"))
    [2, 3, 26, 27, 28]
    """
    flat = " ".join(text.split())
    found: set[int] = set()
    for listed in _NUMBERS.findall(flat):
        for first, last in _RANGE.findall(listed):
            found |= set(range(int(first), int(last or first) + 1))
    return found


def _place(label: str) -> tuple[str, int]:
    """Return the label's printed name, and its number."""
    text = cited(label).replace("~", " ")
    return text, int(re.sub(r"\D", "", text))


def _holders(place: str, known: Sequence[tuple[str, Holder]]) -> tuple[Holder, ...]:
    """Return the holders of an equation; a module only if no object inside it is one."""
    found = [holder for claimed, holder in known if claimed == place]
    inner = {holder.module for holder in found if holder.name}
    return tuple(holder for holder in found if holder.name or holder.module not in inner)


def _claims(house: Path, rooms: Sequence[str]) -> Iterator[tuple[str, Holder]]:
    """Yield (place, holder) for all equations and figures named in the rooms' sources."""
    own = house / "reports" / "paper.py"
    for path in sorted(path for room in rooms for path in (house / room).rglob("*.py")):
        if path != own:
            text = path.read_text(encoding="utf-8")
            module = dotted_name(path, house)
            yield from _said(ast.parse(text), path.relative_to(house), module)


def _said(tree: ast.Module, path: Path, module: str) -> Iterator[tuple[str, Holder]]:
    """Yield (place, holder) of one file, in the order of the text."""
    for place in _by_docstring(ast.get_docstring(tree)):
        yield place, Holder(path, module, "", "mod", (1, 1))
    for name, kind, node, text in _objects(tree.body, ""):
        for place in sorted({*_by_docstring(text), *_by_label(node)}):
            lines = node.lineno, node.end_lineno or node.lineno
            yield place, Holder(path, module, name, kind, lines, text is not None)


def _by_docstring(text: str | None) -> list[str]:
    return [f"eq. ({number})" for number in sorted(numbers_in(text or ""))]


def _by_label(node: Statement) -> Iterator[str]:
    """Yield the labels in a record, an assignment at the top of a module."""
    if isinstance(node, ast.Assign | ast.AnnAssign):
        for part in ast.walk(node):
            if isinstance(part, ast.Constant) and part.value in (*EQUATIONS, *UNNUMBERED, *FIGURES):
                yield _place(str(part.value))[0]


def _objects(
    body: Sequence[Statement], prefix: str
) -> Iterator[tuple[str, str, Statement, str | None]]:
    """Yield (name, kind, node, docstring) of classes, functions, methods and named values."""
    for node, after in zip(body, [*body[1:], None], strict=True):
        if isinstance(node, ast.ClassDef):
            yield prefix + node.name, "class", node, ast.get_docstring(node)
            yield from _objects(node.body, f"{prefix}{node.name}.")
        elif isinstance(node, ast.FunctionDef):
            kind = "meth" if prefix else "func"
            yield prefix + node.name, kind, node, ast.get_docstring(node)
        elif not prefix and isinstance(node, ast.Assign | ast.AnnAssign):
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            if isinstance(target, ast.Name):
                yield target.id, "data", node, _text(after)


def _text(node: Statement | None) -> str | None:
    """Return the docstring below an assignment."""
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
        return node.value.value if isinstance(node.value.value, str) else None
    return None
