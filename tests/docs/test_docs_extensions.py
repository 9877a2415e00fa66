"""What writes the site: mathematics, docstrings, tables, reference, gallery."""

import doctest
import importlib
import json
import re
from itertools import chain
from pathlib import Path

import pytest

import gallery
import library_pages
import lists
import longwave
from docstrings import as_restructured_text
from house import HOUSE, ROOMS, modules, packages
from longwave import CATALOGUE
from longwave.lattice.schemes import SCHEMES
from longwave.scenes.description.bench import KEYS
from longwave.scenes.description.named_scenes import shipped_scenes
from longwave.verify.kernel.table import RULES
from longwave.verify.published import published
from reference import write_reference
from snippets import snippets

RATIO = r"$\displaystyle a &lt; b$"

NAMED = re.compile(r"(?m)^(?:### |\* \*\*[A-Z]+\*\* )`(\w+)`")
"""The name of a statement on a page of the library."""


@pytest.mark.parametrize(
    "name", ["docstrings", "library_pages", "lists", "mathml", "notebook", "paper_map", "snippets"]
)
def test_the_examples_in_docstrings(name: str) -> None:
    if name in ("mathml", "notebook"):
        pytest.importorskip("myst_parser", reason="make docs installs it")
    result = doctest.testmod(importlib.import_module(name))
    assert result.attempted
    assert not result.failed


@pytest.mark.parametrize("latex", [r"\nosuch{x}", r"a & b", r"x^"])
def test_latex_that_is_not_understood_is_an_error(latex: str) -> None:
    pytest.importorskip("sphinx", reason="make docs installs it")
    mathml = importlib.import_module("mathml").mathml
    with pytest.raises(ValueError, match="formula must be LaTeX"):
        mathml(latex)


def test_a_notebook_is_a_page_with_its_outputs() -> None:
    pytest.importorskip("myst_parser", reason="make docs installs it")
    kept: list[bytes] = []
    modules = {name: importlib.import_module(name) for name in ("mathml", "notebook")}
    outputs = [
        {"output_type": "stream", "name": "stdout", "text": ["a\n", "b\n"]},
        {"output_type": "stream", "name": "stderr", "text": ["half done"]},
        {"output_type": "display_data", "data": {"image/png": "eA==", "text/plain": "<Figure>"}},
        {
            "output_type": "execute_result",
            "data": {"text/html": ["<b>$1</b>", RATIO], "text/plain": "1"},
        },
        {
            "output_type": "execute_result",
            "data": {"text/latex": "$\\frac{1}{2}$", "text/plain": "0.5"},
        },
        {"output_type": "error", "ename": "ValueError", "evalue": "k", "traceback": ["long"]},
    ]
    cells = [
        {"cell_type": "markdown", "source": "# A title"},
        {"cell_type": "code", "source": ["x = 1\n", "x"], "outputs": outputs},
    ]

    def keep(picture: bytes) -> str:
        kept.append(picture)
        return "/p.png"

    made = modules["notebook"].markdown(json.dumps({"cells": cells}), keep)
    drawn = modules["mathml"].mathml(r"\displaystyle a < b")
    assert kept == [b"x"]
    assert made.split("\n\n") == [
        "# A title",
        "```python\nx = 1\nx\n```",
        "```text\na\nb\n```",
        "![output](/p.png)",
        f"```{{raw}} html\n<b>$1</b>{drawn}\n```",
        "$$\n\\frac{1}{2}\n$$",
        "```text\nValueError: k\n```",
    ]


def test_code_and_doctests_are_left_as_they_are() -> None:
    text = ["``|x|`` and |x|*2", ">>> a | b", "1*", "", "b_ and b_i"]
    assert as_restructured_text(text) == [
        r"``|x|`` and \|x\|\*2",
        ">>> a | b",
        "1*",
        "",
        r"b\_ and b_i",
    ]


def rule_names() -> list[str]:
    answers = (rule.answer for rule in RULES.rows)
    return [f"{a.__module__.rpartition('.')[2]}.{a.__name__}" for a in answers]


def test_the_tables_hold_every_object() -> None:
    for made, names in (
        (lists.scenes(), [*shipped_scenes(), *shipped_scenes("further")]),
        (lists.schemes(), [scheme.name for scheme in SCHEMES]),
        (lists.bench_keys(), [name for name, entries in KEYS.items() for _ in entries]),
        (lists.kernel_rules(), rule_names()),
    ):
        rows = made.splitlines()[2:]
        assert [re.findall("`(.+?)`", row)[0] for row in rows] == names
        assert len({len(re.findall(r"(?<!\\)\|", row)) for row in made.splitlines()}) == 1


def test_the_waves_stand_below_their_equation() -> None:
    parts = lists.waves().split("### ")[1:]
    held = {part.splitlines()[0]: re.findall("(?m)^. `(.+?)`", part) for part in parts}
    assert held["KdV"][0] == "kdv_soliton"
    assert sorted(chain.from_iterable(held.values())) == sorted(CATALOGUE.names)


@pytest.mark.slow
def test_the_library_has_a_page_for_each_family_with_every_statement(tmp_path: Path) -> None:
    library_pages.write_pages(tmp_path)
    pages = {path.stem: path.read_text(encoding="utf-8") for path in tmp_path.glob("*.md")}
    named = [name for page in pages.values() for name in re.findall(NAMED, page)]
    assert sorted(named) == sorted(text.name for text in published())
    kdv = pages["korteweg_de_vries"]
    assert "[Wikipedia, Benjamin-Bona-Mahony equation](https://" in "".join(pages.values())
    assert "u_{t} + 6 u u_{x} + u_{xxx} = 0" in kdv
    assert kdv.index("### `kdv_one_soliton`") < kdv.index("* **REFUTED** `kdv_soliton_speed`")
    contents = library_pages.contents()
    for page in pages:
        assert f"generated/library/{page}.md" in contents
    numbers = [int(n) for row in contents.splitlines()[2:] for n in row.split("|")[3:5]]
    assert sum(numbers) == len(published())


def test_the_misprints_are_listed() -> None:
    found = re.findall("(?m)^. `(.+?)`", lists.misprints())
    assert found == [text.name for text in published() if text.misprint_in]


def test_the_maps_table_names_object_file_and_scenes() -> None:
    rows = {line.split("|")[1].strip(): line for line in lists.paper_table().splitlines()}
    assert "{py:class}`~longwave.derive.scaling.Scaling`" in rows["eq.&nbsp;(7)"]
    assert "`derive/scaling.py`" in rows["eq.&nbsp;(7)"]
    assert "`rational_3_eps_0.075`" in rows["fig.&nbsp;2"]


def test_the_reference_has_every_module_and_drops_what_is_gone(tmp_path: Path) -> None:
    stale = tmp_path / "longwave.derive.gone.rst"
    stale.write_text("old", encoding="utf-8")
    write_reference(tmp_path)
    assert not stale.exists()
    text = "".join(path.read_text(encoding="utf-8") for path in tmp_path.glob("*.rst"))
    for room in ROOMS:
        for package in packages(room):
            for module in modules(package):
                assert f".. automodule:: {module}\n" in text


def test_the_reference_begins_with_the_face_and_describes_each_of_its_nouns(tmp_path: Path) -> None:
    write_reference(tmp_path)
    index = (tmp_path / "index.rst").read_text(encoding="utf-8")
    assert re.findall(r"(?m)^   (longwave\S*)$", index)[0] == "longwave"
    face = (tmp_path / "longwave.rst").read_text(encoding="utf-8")
    described = re.findall(r"(?m)^.. auto(?!module)\w+:: longwave\.(\w+)$", face)
    described += re.findall(r"(?m)^.. py:data:: longwave\.(\w+)$", face)
    assert sorted(["__version__", *described]) == sorted(longwave.__all__)


def test_every_script_of_the_gallery_is_shown_with_its_text() -> None:
    paths = gallery.scripts(HOUSE / "docs" / "gallery")
    shown = gallery.markdown(paths)
    captions = [snippet.caption for snippet in snippets(shown)]
    assert captions == [f"docs/gallery/{path.name}" for path in paths]
    assert shown.count("\n\n![") == len(paths)
