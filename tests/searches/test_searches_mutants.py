"""The search for mutants that no test notices."""

from pathlib import Path

import pytest

from searches.mutants import HOUSE, Copy, Mutant

FILE = Path("support/known_names.py")


@pytest.mark.slow
def test_what_is_tested_is_the_changed_file_of_the_copy(tmp_path: Path) -> None:
    """Catches: a copy without the links in `longwave/`, whose tests import the original."""
    tree = Copy(tmp_path, ["test_one.py"], 100.0)
    (tmp_path / "test_one.py").write_text(
        "import longwave.support.known_names\ndef test_nothing(): pass\n", "utf-8"
    )
    source = (HOUSE / FILE).read_text("utf-8")
    assert tree.survives(None)
    assert not tree.survives(Mutant(FILE, 1, "", "", source + "raise RuntimeError\n"))
    assert (tmp_path / FILE).read_text("utf-8") == source
