"""What the project says of itself outside its code: citation, changelog, types."""

import os
import re
import subprocess
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

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


GROUPS = [PROJECT["project"]["dependencies"]] + [
    packages
    for name, packages in PROJECT["project"]["optional-dependencies"].items()
    if name != "bench"
]
REQUIRED = [text for group in GROUPS for text in group if not text.startswith("longwave")]


def test_every_library_has_a_floor_and_the_version_that_was_tested() -> None:
    """Guards rely on what a library does from some version on; `make` installs what was tested."""
    lines = (HOUSE / "tools" / "constraints.txt").read_text(encoding="utf-8").splitlines()[1:]
    tested = dict(line.split("==") for line in lines)
    assert list(tested) == sorted(tested)
    for text in REQUIRED:
        found = Requirement(text)
        assert any(part.operator == ">=" for part in found.specifier), text
        version = tested[canonicalize_name(found.name)]
        assert found.specifier.contains(version), (text, version)


def test_apt_is_asked_for_nothing_that_is_there_and_may_be_forbidden(tmp_path: Path) -> None:
    (tmp_path / "apt-get").write_text("#!/bin/sh\ntouch asked\n")
    (tmp_path / "apt-get").chmod(0o755)

    def status(test: str, **environment: str) -> int:
        words = ["sh", str(HOUSE / "tools" / "apt.sh"), test, "package"]
        path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
        environment = {"PATH": path, **environment}
        return subprocess.run(
            words, cwd=tmp_path, env=environment, capture_output=True, check=False
        ).returncode

    assert status("true") == 0
    assert status("command -v nowhere", LONGWAVE_NO_APT="1") == 1
    assert not (tmp_path / "asked").exists()
    texts = [HOUSE / ".ci" / "run", HOUSE / "Makefile", *(HOUSE / "tools").glob("*.sh")]
    direct = [path.name for path in texts if "apt-get -" in path.read_text(encoding="utf-8")]
    assert direct == ["apt.sh"]
    if os.geteuid() == 0:
        assert status("command -v nowhere") == 1
        assert (tmp_path / "asked").exists()
