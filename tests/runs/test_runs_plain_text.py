"""A scene's title and name are printed unchanged: no markup, no emoji."""

from pathlib import Path

import pytest
from rich.console import Console
from rich.progress import TextColumn

from longwave.__main__ import main
from longwave.cli import scene_command as cli
from longwave.scenes.description.named_scenes import load_scene
from longwave.support import console

SCENE = """
title = {title}
wave = "soliton_sech"
eps = 0.2
t0 = 0
snapshots = [0, 5]
[lattice]
K2 = 1
K4 = 1
[parameters]
A = 1
[scheme]
step = 0.5
[domain]
kind = "ring"
sites = 256
compared = 50
"""


@pytest.mark.parametrize("title", ["[/nope]", "[bold]x[/bold]", ":smile:", r"50 % of $K_2 \[a]"])
def test_a_title_is_printed_as_it_is(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], title: str
) -> None:
    path = tmp_path / "[red].toml"
    path.write_text(SCENE.format(title=f"'{title}'"), encoding="utf-8")
    assert main(["run", str(path)]) == 0
    assert title in capsys.readouterr().out


def test_a_title_has_no_terminal_control_codes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(SCENE.format(title=r'"\u001b[3m \u0085"'), encoding="utf-8")
    assert main(["run", str(path)]) == 0
    assert r"\x1b[3m \x85" in capsys.readouterr().out


def test_the_bars_label_is_no_markup(monkeypatch: pytest.MonkeyPatch) -> None:
    columns: list[TextColumn] = []

    class Noted(TextColumn):
        def __init__(self, *words: str, **options: bool) -> None:
            super().__init__(*words, **options)  # type: ignore[arg-type]
            columns.append(self)

    monkeypatch.setattr(console, "TextColumn", Noted)
    terminal = Console(force_terminal=True, stderr=True)
    monkeypatch.setattr(console, "plain_console", lambda **_: terminal)
    monkeypatch.setattr(cli, "record_scene", lambda *_: None)
    cli._run_with_bar(load_scene("rogue_cn_k_0.5"), None, "the work")
    assert [column.markup for column in columns] == [False]
