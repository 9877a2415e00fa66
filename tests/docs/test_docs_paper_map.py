"""The paper's map is complete, and what it points to exists and says so itself."""

import importlib
import re
from pathlib import Path

import pytest

from house import ROOMS
from longwave.reports.paper import EQUATIONS, FIGURES, UNNUMBERED, cited
from paper_map import Holder, Row, numbers_in, paper_map

HOUSE = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def rows() -> tuple[Row, ...]:
    return tuple(paper_map(HOUSE, ROOMS))


def test_every_label_and_every_number_is_a_row(rows: tuple[Row, ...]) -> None:
    labels = [row.label for row in rows]
    assert sorted(labels) == sorted((*EQUATIONS, *UNNUMBERED, *FIGURES))
    assert [row.place for row in rows if row.label == "Eq.2 first-order"] == ["eq. (9)"]


def test_every_row_is_held_by_something(rows: tuple[Row, ...]) -> None:
    assert not [(row.place, row.label) for row in rows if not row.holders]


def test_what_holds_it_can_be_imported_and_says_so(rows: tuple[Row, ...]) -> None:
    held = [(row, holder) for row in rows for holder in row.holders]
    assert not [(row, holder) for row, holder in held if not says_so(row, holder)]


def says_so(row: Row, holder: Holder) -> bool:
    """Whether the holder, which is imported, has the number in its words."""
    number = int(re.sub(r"\D", "", row.place))
    found = importlib.import_module(holder.module)
    for part in filter(None, holder.name.split(".")):
        found = getattr(found, part)
    if not holder.name:
        return number in numbers_in(found.__doc__)
    first, last = holder.lines
    text = "\n".join(
        (HOUSE / holder.path).read_text(encoding="utf-8").splitlines()[first - 1 : last + 3]
    )
    return f'"{row.label}"' in text or number in numbers_in(text)


def tree(folder: Path, text: str) -> Path:
    (folder / "derive").mkdir()
    (folder / "derive" / "lattice.py").write_text(text, encoding="utf-8")
    return folder


def test_a_number_elsewhere_or_of_another_work_is_no_claim(tmp_path: Path) -> None:
    text = '"""Eq. (7) of Kahan."""\n\nA = 1  # the paper\'s eq. (7)\n\nB = "standard mKdV (1)"\n'
    assert not any(row.holders for row in paper_map(tree(tmp_path, text), ["derive"]))


def test_objects_are_found_by_docstring_and_by_label(tmp_path: Path) -> None:
    text = f'''"""The paper's eqs. (2) and (3)."""

FORM = record("x", "{EQUATIONS[0]}")

MEAN = 0
"""The paper's
eq. (3)."""


class Scaling:
    """A class."""

    def speed(self):
        """The paper's eqs. (4) to (6)."""
'''
    held = {
        row.place: [holder.target for holder in row.holders]
        for row in paper_map(tree(tmp_path, text), ["derive"])
    }
    assert held["eq. (1)"] == ["longwave.derive.lattice.FORM"]
    assert held["eq. (2)"] == ["longwave.derive.lattice"]
    assert held["eq. (3)"] == ["longwave.derive.lattice.MEAN"]
    assert held["eq. (5)"] == held["eq. (6)"] == ["longwave.derive.lattice.Scaling.speed"]
    assert held["eq. (7)"] == []


def test_the_unnumbered_line_goes_with_its_numbered_one() -> None:
    assert cited("Eq.2 first-order") == cited("Eq.1 first-order") == "eq.~(9)"
