"""A reviewer's check list is answered, and what is missing or contradicts itself is told."""

import shutil
from pathlib import Path

import pytest

from tools.review_checklist import HOUSE, ITEMS, main

Output = pytest.CaptureFixture[str]


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """The files that the list names and compares, in another folder."""
    named = {path for item in ITEMS for path, _ in item.places}
    for path in named:
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(HOUSE / path, tmp_path / path)
    return tmp_path


def test_every_item_is_answered(capsys: Output) -> None:
    assert main() == 0
    out, err = capsys.readouterr()
    assert out.count("[x]") == len(ITEMS)
    assert err == ""


def test_a_file_or_section_that_is_not_there_is_told(copy: Path, capsys: Output) -> None:
    (copy / "LICENSE").unlink()
    readme = (copy / "README.md").read_text(encoding="utf-8")
    (copy / "README.md").write_text(readme.replace("## For whom", "## Who"), encoding="utf-8")
    assert main(copy) == 1
    out, err = capsys.readouterr()
    assert out.count("[ ]") == 2
    assert "missing: LICENSE is not there" in err
    assert "missing: README.md has nothing like '^## For whom'" in err


def test_versions_and_references_that_disagree_are_told(copy: Path, capsys: Output) -> None:
    for path, old, new in (
        ("pyproject.toml", 'version = "', 'version = "9'),
        ("paper/paper.bib", "@article{zabusky1965,", "@article{zabusky1956,"),
    ):
        text = (copy / path).read_text(encoding="utf-8")
        assert old in text
        (copy / path).write_text(text.replace(old, new, 1), encoding="utf-8")
    assert main(copy) == 1
    err = capsys.readouterr().err
    assert err.count("missing: ") == 4
    for fault in ("CITATION.cff must", "CHANGELOG.md must", "have zabusky1965", "cite zabusky1956"):
        assert fault in err
