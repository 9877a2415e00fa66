"""Every snippet of every page runs, and prints what the page says."""

import doctest
import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

from snippets import SLOW, Command, commands, snippets

HOUSE = Path(__file__).parents[2]
DOCS = HOUSE / "docs"
PAGES = sorted(
    path
    for path in DOCS.rglob("*.md")
    if not {"generated", "build"} & set(path.relative_to(DOCS).parts)
    and path.name != "many-runs.md"  # is one session of a shell, and has a test of its own
)
LONG = (
    "chain-on-a-bench.md",
    "how-to/bench.md",
    "how-to/command-line.md",
    "how-to/derive.md",
    "how-to/exact-waves.md",
    "how-to/disorder.md",
    "how-to/fit.md",
    "how-to/lattice-scene.md",
    "how-to/limits.md",
    "how-to/pictures.md",
    "how-to/prove-your-own.md",
    "how-to/run-files.md",
    "how-to/scene.md",
    "how-to/scheme.md",
    "how-to/stores.md",
    "how-to/sweeps.md",
    "lattice-file.md",
    "library.md",
    "output-words.md",
    "tutorial.md",
)
"""Pages whose commands take 1 to 20 s of a processor."""

FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
TARGETS = re.findall(r"^([\w-]+):", (HOUSE / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)


def run_session(text: str, names: dict[str, Any], page: str) -> None:
    test = doctest.DocTestParser().get_doctest(text, names, page, page, 0)
    said: list[str] = []
    runner = doctest.DocTestRunner(optionflags=FLAGS)
    runner.run(test, out=said.append, clear_globs=False)
    names.update(test.globs)
    assert not runner.failures, "".join(said)


def run_command(command: Command) -> None:
    """What CI runs itself (`make`) is only looked up; everything else is run."""
    words = shlex.split(command.line)
    if words[0] == "make":
        assert words[1] in TARGETS
        return
    if words[0] == ".":
        return
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": str(HOUSE),
        "COLUMNS": "200",
    }
    done = subprocess.run(
        words, capture_output=True, text=True, env=environment, check=False, timeout=1800
    )
    got = SLOW.sub("", done.stderr if done.returncode == 2 else done.stdout)
    assert doctest.OutputChecker().check_output(command.output, got, FLAGS), got


def name_of(page: Path) -> str:
    return str(page.relative_to(DOCS))


def long_is_slow(page: Path) -> Any:
    name = name_of(page)
    return pytest.param(page, id=name, marks=pytest.mark.slow if name in LONG else ())


@pytest.mark.parametrize("page", [long_is_slow(page) for page in PAGES])
def test_snippets_print_what_the_page_says(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    for snippet in snippets(page.read_text(encoding="utf-8")):
        if snippet.kind == "pycon":
            run_session(snippet.text, names, page.name)
        elif snippet.kind == "console":
            for command in commands(snippet.text):
                run_command(command)
        else:
            assert snippet.kind == "toml" or snippet.caption, (
                f"{snippet.kind} blocks are not run: use pycon or console, or let it be a file"
            )
            if snippet.kind == "toml":
                tomllib.loads(snippet.text)
            Path(snippet.caption).write_text(snippet.text, encoding="utf-8")


def test_a_wrong_output_is_noticed() -> None:
    with pytest.raises(AssertionError, match="Expected"):
        run_session(">>> 1 + 1\n3\n", {}, "page")
    with pytest.raises(AssertionError):
        run_command(Command("longwave --version", "shortwave\n"))


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_no_block_escapes_the_reader(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert text.count("```") == 2 * len(re.findall(r"^```\S", text, re.MULTILINE))
