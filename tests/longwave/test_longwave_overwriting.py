"""Catches: a file that a command overwrites without --force, or an unwritable one reported late."""

from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from longwave.__main__ import main
from longwave.cli.command_tree import longwave

WRITING = {"output", "plot", "certificate"}
"""Options that name what is written."""

UNASKED: dict[tuple[str, str], str] = {}
"""Such options of commands without --force, and why they need none."""

PATHS_READ = {
    ("run", "store"),
    ("sweep", "store"),
    ("report", "estimates"),
    ("prove", "lines"),
    ("library", "lines"),
}
"""Options with a path that is read, appended to, or holds files none of which is overwritten."""


def commands(group: click.Group, above: str = "") -> Iterator[tuple[str, click.Command]]:
    """Yield all commands of the tree with their words."""
    for name, command in group.commands.items():
        yield f"{above}{name}", command
        if isinstance(command, click.Group):
            yield from commands(command, f"{above}{name} ")


def test_every_option_that_writes_a_file_has_force_beside_it() -> None:
    found = set()
    for words, command in commands(longwave):
        options = {str(o.name): o for o in command.params if isinstance(o, click.Option)}
        writing = {n for n, o in options.items() if isinstance(o.type, click.Path)}
        writing -= {option for word, option in PATHS_READ if word == words}
        assert writing <= WRITING, words
        assert not writing or "force" in options or (words, *writing) in UNASKED, words
        found |= {words} if writing else set()
    written = {"run", "sweep", "plot", "animate", "report", "converge", "fit", "wave", "orbit"}
    assert found == {"prove", "library", "check", "verify"} | written


@pytest.mark.parametrize(
    ("words", "name"),
    [
        ("library --output", "c.json"),
        ("check c.json --export coq --output", "c.v"),
        ("prove --equation u_t+u_x --solution u=sin(x-t) --output", "c.json"),
        ("prove --equation u_t+u_x --solution u=sin(x-t) --export coq --output", "c.v"),
        ("verify --only kink --output", "c.json"),
        ("verify --only kink --export pari --output", "c.gp"),
        ("plot rogue_cn_k_0.5_long --output", "c.png"),
        ("animate rogue_cn_k_0.5_long --output", "c.gif"),
        ("converge toda_soliton --output", "c.png"),
        ("fit force.csv --output", "c.toml"),
        ("fit force.csv --plot", "c.png"),
    ],
)
def test_nothing_is_overwritten_unasked(
    words: str, name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    older = tmp_path / name
    older.write_text("older")
    assert main([*words.split(), str(older)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert f"must name a new file, got {older}, which exists (--force overwrites it)" in error
    assert older.read_text() == "older"


def test_a_picture_by_its_usual_name_is_not_overwritten_either(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("toda_soliton.png").touch()
    assert main(["plot", "toda_soliton"]) == 2
    assert "got toda_soliton.png, which exists (--force overwrites it)" in capsys.readouterr().err


def test_force_overwrites(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "c.json"
    path.write_text("older")
    assert main(["verify", "--only", "kink", "--output", str(path), "--force"]) == 0
    assert path.read_text().startswith("[")
    transport = ["--equation", "u_t+u_x", "--solution", "u=sin(x-t)"]
    assert main(["prove", *transport, "--output", str(path), "--force"]) == 0
    assert "sin" in path.read_text()


def test_numbered_scripts_are_looked_for_before_the_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "s_1.gp").write_text("older")
    words = ["verify", "--only", "kink", "--export", "pari", "--output", str(tmp_path / "s.gp")]
    assert main(words) == 2
    assert "next to the existing file s_1.gp (--force overwrites it)" in capsys.readouterr().err
    assert main([*words, "--force"]) == 0
