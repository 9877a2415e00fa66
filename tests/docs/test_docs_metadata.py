"""What the project says of itself outside its code: citation, changelog, types."""

import re
import tomllib
from pathlib import Path

import pytest

HOUSE = Path(__file__).parents[2]
PROJECT = tomllib.loads((HOUSE / "pyproject.toml").read_text(encoding="utf-8"))
CITATION = (HOUSE / "CITATION.cff").read_text(encoding="utf-8")
CHANGELOG = (HOUSE / "CHANGELOG.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("key", ["version", "license"])
def test_the_citation_agrees_with_the_project(key: str) -> None:
    said = re.search(rf"^{key}: (.*)$", CITATION, re.MULTILINE)
    assert said is not None
    assert said[1] == PROJECT["project"][key]


def test_the_citation_has_the_projects_authors_and_keywords() -> None:
    head = CITATION.partition("references:")[0]
    for author in PROJECT["project"]["authors"]:
        assert f'name: "{author["name"]}"' in head
    listed = re.findall(r"^  - (\w[\w ]*)$", head, re.MULTILINE)
    assert listed == PROJECT["project"]["keywords"]


def test_the_changelog_begins_with_what_is_not_released_and_knows_the_version() -> None:
    headings = re.findall(r"^## \[?([^\]\n]+)", CHANGELOG, re.MULTILINE)
    assert headings[0] == "Unreleased"
    assert PROJECT["project"]["version"] in CHANGELOG
    kinds = set(re.findall(r"^### (.*)$", CHANGELOG, re.MULTILINE))
    assert kinds <= {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}


def test_the_package_ships_its_types() -> None:
    assert (HOUSE / "longwave" / "py.typed").is_file()
    assert "py.typed" in PROJECT["tool"]["setuptools"]["package-data"]["*"]
