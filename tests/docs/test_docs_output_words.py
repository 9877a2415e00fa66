"""The page on words in outputs has each heading, key and label that its commands print."""

import json
import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from house import HOUSE
from longwave.__main__ import main
from longwave.cli.scene_command import COLUMNS
from longwave.derive import LATTICES
from longwave.derive.normal_form import NORMAL_EQUATIONS
from longwave.verify.verdict import Outcome
from snippets import commands, snippets

PAGE = (HOUSE / "docs" / "output-words.md").read_text(encoding="utf-8")
SECTIONS = re.split(r"(?m)^## ", PAGE)[1:]
LONG = ("longwave converge", "longwave sweep", "longwave run")
"""Sections whose commands take more than a few seconds."""

BY_DATA = {
    *("aicc", "constants", "corrections", "definitions", "dimensions", "observed", "obstruction"),
    *("orders", "parameters", "remainders", "set", "values", "witness"),
}
"""Keys of tables whose own keys are names and numbers of the user's lattice or scene."""

LABELLED = ("derive", "fit", "run", "converge", "sweep")
"""Commands whose lines begin with labels; those of the others begin with names and verdicts."""

BEGINNINGS = ("ansatz", "carrier", "a linear lattice", "agrees", "  " + 10 * " ")
"""First words behind the lattice's own equations."""

FRAMES = ("│", "┏", "┡", "└", "├", "┗")

CUT = re.compile(
    r":| = |\(|,| at (?!most)| [-\d]|±| (?:i )?U_| (?:the term|smooth curves|neighbours) "
)
"""Where the label of a line ends."""


def words_of_json(data: Any, by_data: bool = False) -> Iterator[str]:
    """Yield the keys of a document; those of a scene, and those the user named, are left out."""
    if isinstance(data, list):
        for entry in data:
            yield from words_of_json(entry)
    if isinstance(data, dict):
        for key, value in data.items():
            if not by_data:
                yield key
            if key != "scene":
                named = key in BY_DATA or (key == "terms" and isinstance(value, dict))
                yield from words_of_json(value, named and not by_data)


def words_of_text(line: str, text: str) -> Iterator[str]:
    """Yield headings of tables, and labels of the lines around them, of a command's output."""
    lines = text.splitlines()
    if " derive " in line:
        begins = (n for n, found in enumerate(lines) if found.startswith(BEGINNINGS))
        lines = lines[next(begins, 0) :]
    labelled = line.split()[1] in LABELLED
    for number, found in enumerate(lines):
        if found.startswith("┃"):
            yield from (re.sub(r"eps\^\d", "eps", head.strip()) for head in found.split("┃")[1:-1])
        elif found.split()[:2] in (["k", "omega"], ["k", "p"]):
            yield from re.split(r"\s{2,}", found.strip())
        elif found.startswith("stencil, "):
            yield from cost_parts(found)
        elif labelled and (number or " run " not in line) and not found.startswith(FRAMES):
            yield from label(found)


def cost_parts(line: str) -> Iterator[str]:
    for part in re.split(r"[,;()]", line.partition(": ")[2]):
        if part.strip():
            yield re.sub(r"\d[\d.e+-]*", "...", part.strip())


def label(line: str) -> Iterator[str]:
    cut = CUT.search(line.strip())
    found = line.strip()[: cut.start()].strip() if cut else ""
    found = re.sub(r"^eps\^\d+$", "eps^N", re.sub(r"^([RG])\d+$", r"\1N", found))
    if (
        re.match(r"[A-Za-z]", found)
        and " +" not in found
        and not found.startswith("pi")
        and found not in LATTICES
    ):
        yield "of ..." if found.startswith("of ") else found


def printed_words(line: str, capsys: pytest.CaptureFixture[str]) -> set[str]:
    main(shlex.split(line)[1:])
    out = capsys.readouterr().out
    if out.lstrip().startswith(("{", "[")):
        return {*words_of_json(json.loads(out))}
    return {*words_of_text(line, out)}


def words_on_page(section: str) -> set[str]:
    rows = re.findall(r"(?m)^\| (`.+?`) \| ", section)
    return {word.replace(r"\|", "|") for row in rows for word in re.findall(r"`(.+?)`", row)}


def commands_of(section: str) -> list[str]:
    """Return the commands that a section shows, and those of paragraphs with Also or Type."""
    shown = [c.line for s in snippets(section) if s.kind == "console" for c in commands(s.text)]
    also = re.findall(r"(?ms)^(?:Also|Type) (.*?)\n\n", section)
    return shown + [
        line for text in also for line in re.findall(r"`(longwave [^`]+?)`", " ".join(text.split()))
    ]


def named(section: str) -> Any:
    title = section.partition("\n")[0].replace("`", "")
    marks = pytest.mark.slow if title.startswith(LONG) else ()
    return pytest.param(section, id=title, marks=marks)


@pytest.mark.slow
@pytest.mark.parametrize("section", [named(section) for section in SECTIONS])
def test_the_words_are_those_that_are_printed(
    section: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Catches: a heading, key or label without a line on the page, and one that is gone."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    for snippet in snippets(PAGE):
        if snippet.caption:
            Path(snippet.caption).write_text(snippet.text, encoding="utf-8")
    lines = commands_of(section)
    assert lines
    printed = set().union(*(printed_words(line, capsys) for line in lines))
    assert printed - words_on_page(section) == set()
    assert words_on_page(section) - printed == set()


def test_all_outcomes_normal_forms_and_columns_have_a_line() -> None:
    """Those that no command above happens to print."""
    assert set(re.findall(r"(?m)^\| ([A-Z]+) \|", PAGE)) == {*Outcome} | {"NLS", "KP"}
    for name, equation in NORMAL_EQUATIONS.items():
        assert f"| {name} | `{equation.text}` |" in PAGE.replace(r"\|", "|")
    for column in COLUMNS.values():
        assert f"`{column.format(unit='eps')}`" in PAGE
