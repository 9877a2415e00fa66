"""The page on lattice files names every key that is read, and its examples are lattices."""

import re
import tomllib
from typing import Any

import pytest

from house import HOUSE
from longwave.derive import lattice_of
from longwave.derive.lattice_file import (
    FUNCTIONS,
    KEYS,
    LARGEST_FILE,
    LONGEST_NAME,
    LONGEST_TITLE,
    MAX_ENTRIES,
)
from longwave.derive.symbols import RESERVED
from snippets import snippets

PAGE = (HOUSE / "docs" / "lattice-file.md").read_text(encoding="utf-8")
TOP = "Top of the file"
REFUSED = "no_action.toml"
EXAMPLES = {s.caption: s.text for s in snippets(PAGE) if s.kind == "toml"}


def read(name: str) -> dict[str, Any]:
    """Return the tables of an example."""
    return tomllib.loads(EXAMPLES[name])


def section(title: str) -> str:
    """Return the text below a heading, up to the next one of its level."""
    return re.split(r"(?m)^## ", PAGE.partition(f"\n## {title}\n")[2])[0]


def keys_on_page(title: str) -> list[str]:
    """Return the first cells of the section's first table."""
    table = re.split(r"(?m)^\|---.*\n", section(title))[1].partition("\n\n")[0]
    return re.findall(r"(?m)^\| `(\w+)` \|", table)


@pytest.mark.parametrize("kind", KEYS)
def test_every_key_has_a_line(kind: str) -> None:
    """Catches: a key that is read and not on the page, and one that is no longer read."""
    keys = keys_on_page(f"`[[{kind}]]`" if kind else TOP)
    assert len(keys) == len(set(keys))
    assert set(keys) == KEYS[kind]


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        ("", "measured.toml"),
        ("spring", "chain.toml"),
        ("site", "pendulums.toml"),
        ("bond", "strain.toml"),
    ],
)
def test_what_the_page_calls_required_is(kind: str, name: str) -> None:
    """Catches: a line that says `required` of a key with a default, or the other way round."""
    title = f"`[[{kind}]]`" if kind else TOP
    for key in {*keys_on_page(title)} - {"spring", "constants"}:  # others of the example need them
        document = read(name)
        (document[kind][0] if kind else document).pop(key, None)
        line = re.search(rf"(?m)^\| `{key}` \|.*$", section(title))
        assert line is not None
        if "| required" in line[0]:
            with pytest.raises(ValueError, match=" must "):
                lattice_of(document)
        else:
            lattice_of(document)


@pytest.mark.parametrize("name", EXAMPLES)
def test_every_example_is_a_lattice(name: str) -> None:
    document = read(name)
    if name == REFUSED:
        with pytest.raises(ValueError, match="action must name fields"):
            lattice_of(document)
    else:
        assert lattice_of(document).equations()


def test_functions_names_and_limits_are_those_of_the_reader() -> None:
    functions = section("Forces").partition("* The functions are ")[2].partition(". Powers")[0]
    assert set(re.findall(r"`(\w+)`", functions)) == {*FUNCTIONS}
    reserved = re.search(r"The names (.*?) are reserved", PAGE)
    assert reserved is not None
    assert set(re.findall(r"`(\w+)`", reserved[1])) == {*RESERVED}
    top = section(TOP)
    assert f"at most {LONGEST_NAME} characters each" in top
    assert top.count(f"at most {LONGEST_TITLE} characters") == 2
    assert re.search(rf"at most {MAX_ENTRIES} of each, at most\s{MAX_ENTRIES} fields", top)
    assert f"{LARGEST_FILE // 1000} kB" in top


def test_springs_and_sites_are_the_bonds_that_the_page_says() -> None:
    rows = re.findall(r"`stretch = \"(.+?)\"`, `action = \{u = \"(.+?)\"\}`", section("`[[bond]]`"))
    bonds = [{"stretch": stretch, "action": {"u": act}, "force": "x"} for stretch, act in rows]
    short = {
        "spring": [{"between": ["u[n]", "u[n+1]"], "force": "x"}],
        "site": [{"field": "u", "force": "x"}],
    }
    expected = lattice_of({"fields": ["u"], **short})
    assert lattice_of({"fields": ["u"], "bond": bonds}).bonds == expected.bonds
    assert not expected.missing_energies
