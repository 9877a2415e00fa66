"""Items of a reviewer's check list, and their places in the repository.

``python tools/review_checklist.py`` prints each item of the check list of the Journal of Open
Source Software with the place that answers it, and ends with 1 if something is missing. The items
on conflicts of interest and on authorship are the reviewer's own and are left out.
"""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

HOUSE = Path(__file__).resolve().parents[1]

Place = tuple[str, str]
"""A file, and a regular expression that must match in it; "" asks for the file alone."""


@dataclass(frozen=True)
class Item:
    """A question of the check list under its heading, and the places that answer it."""

    heading: str
    question: str
    places: tuple[Place, ...]


ITEMS = (
    Item("General", "a plain-text licence that OSI approves", (("LICENSE", "^MIT License"),)),
    Item(
        "Functionality",
        "installation proceeds as documented",
        (("docs/install.md", r"pip install \."), ("tests/longwave/test_longwave_wheel.py", "")),
    ),
    Item(
        "Functionality",
        "the claims of the software can be confirmed",
        (("docs/overview.md", "^## Measured"), ("searches/estimates.py", "")),
    ),
    Item(
        "Functionality",
        "claims of performance can be confirmed",
        (("docs/overview.md", r"same_lattice\.py"), ("benchmarks/same_lattice.py", "")),
    ),
    Item(
        "Documentation",
        "a statement of need: which problems, for whom",
        (("README.md", "^## For whom"), ("docs/overview.md", "^## For whom")),
    ),
    Item(
        "Documentation",
        "installation instructions, dependencies handled by a package manager",
        (("docs/install.md", "^## With pip"), ("pyproject.toml", "^dependencies = ")),
    ),
    Item(
        "Documentation",
        "examples of use on real problems",
        (
            ("docs/tutorial.md", ""),
            ("docs/chain-on-a-bench.md", ""),
            ("docs/gallery.md", ""),
        ),
    ),
    Item(
        "Documentation",
        "core functionality documented, methods included",
        (("docs/extensions/reference.py", ""), ("docs/index.md", "^generated/reference/index$")),
    ),
    Item(
        "Documentation",
        "automated tests, and how to run them",
        (("Makefile", "^test:"), ("CONTRIBUTING.md", "make test"), (".ci/run", "make test")),
    ),
    Item(
        "Documentation",
        "how to contribute, to report problems and to seek support",
        (
            ("CONTRIBUTING.md", "^## Questions, problems, changes"),
            ("CODE_OF_CONDUCT.md", ""),
            (".github/ISSUE_TEMPLATE/wrong-result.md", ""),
            (".github/pull_request_template.md", ""),
        ),
    ),
    Item("Software paper", "authors with affiliations", (("paper/paper.md", "^affiliations:"),)),
    Item("Software paper", "a summary", (("paper/paper.md", "^# Summary$"),)),
    Item("Software paper", "a statement of need", (("paper/paper.md", "^# Statement of need$"),)),
    Item(
        "Software paper", "the state of the field", (("paper/paper.md", "^# State of the field$"),)
    ),
    Item(
        "Software paper",
        "references, all of them cited",
        (("paper/paper.md", "^# References$"), ("paper/paper.bib", "^@")),
    ),
    Item(
        "Release",
        "how to cite, and what has changed",
        (("CITATION.cff", "^references:"), ("CHANGELOG.md", r"^## \[\d")),
    ),
)


def missing(house: Path, place: Place) -> str:
    """Return the fault of a place, in words; "" if it is there."""
    path, pattern = place
    if not (house / path).is_file():
        return f"{path} is not there"
    if pattern and not re.search(pattern, (house / path).read_text(encoding="utf-8"), re.MULTILINE):
        return f"{path} has nothing like {pattern!r}"
    return ""


def disagreements(house: Path) -> Iterator[str]:
    """Yield contradictions between files: versions, and citations of the paper."""
    version = tomllib.loads(_text(house, "pyproject.toml"))["project"]["version"]
    if not re.search(
        rf"^version: {re.escape(version)}$", _text(house, "CITATION.cff"), re.MULTILINE
    ):
        yield f"CITATION.cff must have the version of pyproject.toml, {version}"
    if f"## [{version}]" not in _text(house, "CHANGELOG.md"):
        yield f"CHANGELOG.md must have a section of version {version}"
    cited = set(re.findall(r"(?<![\w.])@([a-z]\w*)", _text(house, "paper/paper.md")))
    listed = set(re.findall(r"^@\w+\{(\w+),", _text(house, "paper/paper.bib"), re.MULTILINE))
    for name in sorted(cited - listed):
        yield f"paper/paper.bib must have {name}, which paper/paper.md cites"
    for name in sorted(listed - cited):
        yield f"paper/paper.md must cite {name}, which paper/paper.bib has"


def _text(house: Path, path: str) -> str:
    """Return the file's text; "" for a missing file, which an item reports."""
    return (house / path).read_text(encoding="utf-8") if (house / path).is_file() else ""


def main(house: Path = HOUSE) -> int:
    """Print the list; 1 if something is missing."""
    faults = list(disagreements(house))
    heading = ""
    for item in ITEMS:
        if item.heading != heading:
            heading = item.heading
            print(f"{heading}:")
        wrong = [fault for fault in (missing(house, place) for place in item.places) if fault]
        faults += wrong
        print(
            f"  [{' ' if wrong else 'x'}] {item.question}: {', '.join(p for p, _ in item.places)}"
        )
    for fault in faults:
        print(f"missing: {fault}", file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
