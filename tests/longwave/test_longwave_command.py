"""The command `longwave`: one tree, fast start, one line and status 2 for wrong input."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import pytest

import longwave.cli.accuracy
import longwave.cli.command_tree as tree
import longwave.cli.inventory
import longwave.cli.scene_command
import longwave.cli.statements
import longwave.cli.sweep_command
import longwave.cli.verdicts
import longwave.derive.output.printout
import longwave.reports.build
from longwave.__main__ import main
from longwave.derive.__main__ import CONSTANTS
from longwave.derive.models.lattices import FPUT_STRAIN
from longwave.derive.output.derive_options import DeriveOptions
from longwave.runs import load_run
from longwave.scenes.description.named_scenes import FOLDER_NAMES, shipped_scenes
from snippets import SLOW

Output = pytest.CaptureFixture[str]
HOUSE = Path(__file__).parents[2]
WORDS = tuple(tree.longwave.commands)


def commands(group: click.Group, name: str = "") -> Iterator[tuple[str, click.Command]]:
    """Yield every command of the tree with its words."""
    for word, command in group.commands.items():
        yield f"{name} {word}".strip(), command
        if isinstance(command, click.Group):
            yield from commands(command, f"{name} {word}".strip())


ALL = dict(commands(tree.longwave))


@pytest.mark.parametrize("argv", [[], ["--help"], ["-h"]])
def test_help_names_every_command(argv: list[str], capsys: Output) -> None:
    assert main(argv) == 0
    printed = capsys.readouterr().out
    assert all(f"  {word} " in printed for word in WORDS)


@pytest.mark.parametrize("words", ALL)
def test_each_command_has_a_help_with_an_example_and_a_line_that_is_not_cut(
    words: str, capsys: Output
) -> None:
    assert main([*words.split(), "--help"]) == 0
    printed = capsys.readouterr().out
    example = printed.partition("Example:\n")[2].splitlines()[0].split()
    assert example[0] == "longwave"
    assert set(words.split()) <= set(example)
    assert "..." not in ALL[words].get_short_help_str(60)


@pytest.mark.parametrize(
    "words", [command.epilog.splitlines()[2] for command in ALL.values() if command.epilog]
)
def test_the_examples_are_read_as_they_stand(words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    called: list[str] = []
    for command in ALL.values():
        if not isinstance(command, click.Group):
            name = str(command.name)
            monkeypatch.setattr(command, "callback", lambda name=name, **_: called.append(name))
    monkeypatch.setattr(ALL["verify"], "callback", lambda **_: called.append("verify"))
    assert main(words.split()[1:]) == 0
    assert called[-1] in words.split()


def test_a_wrong_word_is_one_line_and_status_2(capsys: Output) -> None:
    assert main(["vreify"]) == 2
    error = capsys.readouterr().err
    known = f"did you mean verify? one of {', '.join(WORDS)}"
    assert error == f"error: COMMAND must be a known one, got vreify ({known})\n"


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["--bogus"], "no such option"),
        (["vreify\n\x1b[31m"], r"got vreify \x1b[31m (one of"),
        (["verify", "walk"], "COMMAND must be a known one, got walk (one of recheck, "),
        (["derive", "--orders", "many"], "--order must be a whole number from 0 to 13, got 'many'"),
        (["derive", "--k2", "__import__('os')"], "K2: expected a formula, got '_'"),
        (["derive", "--k4", "--"], "K4: expected a number, a name or '('"),
        (["derive", "--json", "--latex"], "--json must not be given with --latex"),
        (["prove"], "--equation or FILE.toml must be given, got neither"),
        (["prove", "--library"], "no such option --library (write longwave library; see longwave"),
        (["prove", "--certificate", "x"], "--certificate (--output FILE writes certificates, long"),
        (["prove", "--limt", "3"], "no such option --limt (did you mean --limit? "),
        (["prove", "kink"], "got kink (a closed form: longwave verify --only kink; a published"),
        (["prove", "peakon.tml"], "FILE must end in .toml, got peakon.tml"),
        (["library", "--certificate", "x"], "--output FILE writes certificates"),
        (["library", "kdv_positn"], "got 'kdv_positn' (did you mean kdv_positon"),
        (["library", "--json", "--latex"], "--json must not be given with --latex, got both"),
        (["check", "x", "--output", "y"], "--output must be given with --export, got it alone"),
        (["check", "x", "--export", "coq"], "--export must be given with --output FILE, got no"),
        (["check", "/nowhere/x"], "/nowhere/x: No such file or directory"),
        (["verify", "kink"], "got kink (one of recheck, mutations, accuracy; --only NAME takes a"),
        (["verify", "--only", "kinck"], "'kinck' (did you mean kink? one of 38 names"),
        (["verify", "--certificate", "x"], "--output FILE writes certificates"),
        (["verify", "--only", "kink", "--output", "/nowhere/x"], "must lie in an existing folder"),
        (["verify", "--only", "peakon"], "'peakon' (one of rational_1, "),
        (["verify", "--digits", "30,x"], "digits must be integers with commas between"),
        (["verify", "--points", "many"], "'many' is not a valid integer (see longwave verify"),
        (["verify", "--method", "guess"], "invalid value for '--method': 'guess'"),
        (["verify", "--seed", "1", "--stable"], "--stable must not be given with the method"),
        (["check"], "missing argument 'FILE'"),
        (["verify", "mutations", "--only", "peakon"], "'peakon' (one of rational_1, "),
        (["verify", "accuracy", "--jobs", "0"], "--jobs must satisfy 1 <= --jobs <= 1000, got 0"),
        (["verify", "--json", "mutations"], "--json must stand after the command to which it"),
        (["verify", "--only"], "requires an argument (see longwave verify --help)"),
        (["run"], "missing argument 'SCENE' (see longwave run --help)"),
        (["run", "nowhere"], "scene must be a TOML file or a shipped scene, got 'nowhere'"),
        (["run", "[/nope]"], "got '[/nope]'"),
        (["run", "rogue_cn_k_0.5", "--tolerance", "-1"], "tolerance must satisfy tolerance > 0"),
        (["report", "--workers", "many"], "'many' is not a valid integer (see longwave report"),
        (["converge", "toda_soliton", "--eps", "0.1,x"], "--eps must be numbers with commas"),
        (["converge", "toda_soliton", "--eps", "0.1,0.1,0.2"], "eps must be 3 to 20 different"),
        (["converge", "toda_soliton", "--output", "rate.txt"], "must be a path ending in .png"),
        (["converge", "rogue_cn_k_0.5"], "tolerance must be given for this, got a stated step"),
        (["run", "toda_soliton", "--engine", "steam"], "got 'steam' (one of stencil, spectral)"),
        (["list", "wavse"], "'wavse' is not one of 'lattices', 'waves'"),
        (["list", "wavse"], "(did you mean waves? see longwave list --help)"),
        (["--completion", "tcsh"], "'tcsh' is not one of 'bash', 'zsh', 'fish'"),
    ],
)
def test_wrong_input_is_one_line_and_status_2(
    argv: list[str], message: str, capsys: Output
) -> None:
    assert main(argv) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.startswith("error: ")
    assert output.err.count("\n") == 1
    assert message in output.err


def test_declared_options_match_the_parameters_of_the_rooms() -> None:
    assert tuple(str(constant) for constant in FPUT_STRAIN.constants) == CONSTANTS
    assert tree.scene_names() == sorted(
        name for kind in FOLDER_NAMES for name in shipped_scenes(kind)
    )


NOTHING = (None, False, (), {})


def test_options_reach_the_rooms(monkeypatch: pytest.MonkeyPatch) -> None:
    got: list[Any] = []

    def keep(*given: object, **options: object) -> int:
        got.append((*given, options))
        return 1

    monkeypatch.setattr(longwave.derive.output.printout, "print_derivation", keep)
    monkeypatch.setattr(longwave.cli.statements, "prove_and_print", keep)
    monkeypatch.setattr(longwave.cli.statements, "decide_library_and_print", keep)
    monkeypatch.setattr(longwave.cli.verdicts, "print_verdicts", keep)
    monkeypatch.setattr(longwave.cli.verdicts, "print_mutations", keep)
    monkeypatch.setattr(longwave.cli.scene_command, "run_and_print", keep)
    monkeypatch.setattr(longwave.cli.sweep_command, "sweep_and_print", keep)
    monkeypatch.setattr(longwave.cli.accuracy, "print_accuracy", keep)
    monkeypatch.setattr(longwave.reports.build, "write_report", keep)
    for line in (
        "derive --k4 -1/2 --orders 5 --latex",
        "prove a.toml --limit 3 --output c.json",
        "library kdv_positon --json",
        "verify --only kink --digits 20,40 --seed 3",
        "verify mutations --only kink",
        "verify accuracy --only kink --jobs 2 --json",
        "run x.toml --tolerance 1e-3 --engine stencil --output x.nc",
        "sweep x.toml --processes 2",
        "report --output there --full --workers 3",
    ):
        assert main(line.split()) == 1
    given = [
        (*where, {k: v for k, v in named.items() if v not in NOTHING}) for *where, named in got
    ]
    assert given == [
        (DeriveOptions(constants={"K4": "-1/2"}, orders="5", form="latex"), {}),
        ("longwave prove", ("a.toml",), {"limit": 3.0, "output": "c.json"}),
        ("longwave library", ("kdv_positon",), {"json_wanted": True}),
        ("longwave verify", {"only": ("kink",), "digits": "20,40", "seed": 3}),
        (("kink",), False, "longwave verify mutations", {}),
        (("kink",), 2, None, True, "longwave verify accuracy", {}),
        (
            *("x.toml", "longwave run"),
            {"tolerance": 1e-3, "engine": "stencil", "output": "x.nc"},
        ),
        ("x.toml", "longwave sweep", {"processes": 2}),
        (Path("there"), "longwave report", {"full": True, "workers": 3}),
    ]


def test_a_proof_is_written_and_checked(tmp_path: Path, capsys: Output) -> None:
    path = tmp_path / "kink.json"
    assert main(["verify", "--only", "kink", "--json", "--output", str(path)]) == 0
    (proved,) = json.loads(capsys.readouterr().out)
    assert (proved["name"], proved["outcome"]) == ("kink", "PROVED")
    assert main(["check", str(path)]) == 0
    assert capsys.readouterr().out.endswith("kink: accepted\n")
    assert main(["check", str(path), "--json"]) == 0
    (accepted,) = json.loads(capsys.readouterr().out)
    assert accepted["name"] == "kink"
    assert "A*tanh(" in accepted["statement"]


def test_a_rejected_certificate_gives_status_1_and_json_without_it(
    tmp_path: Path, capsys: Output
) -> None:
    path = tmp_path / "c.json"
    path.write_text("{}", encoding="utf-8")
    assert main(["check", str(path), "--json"]) == 1
    output = capsys.readouterr()
    assert json.loads(output.out) == []
    assert "rejected: " in output.err


def test_derive_prints_coefficients_as_json(capsys: Output) -> None:
    assert main(["derive", "--k2", "4", "--k4", "-1/2", "--json"]) == 0
    assert isinstance(json.loads(capsys.readouterr().out), dict)


def command(*words: str, **settings: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "longwave", *words],
        capture_output=True,
        text=True,
        cwd=HOUSE,
        env=os.environ | settings,
        check=False,
    )


def test_it_runs_as_a_module() -> None:
    assert command("--version").stdout.startswith("longwave ")


@pytest.mark.parametrize("words", [["--help"], ["run", "--help"], ["--completion", "zsh"]])
def test_help_and_completion_import_nothing_that_computes(words: list[str]) -> None:
    script = (
        "import sys; from longwave.__main__ import main; main(sys.argv[1:]);"
        "rooms = {f'longwave.{room}' for room in ('solutions', 'lattice', 'verify.proof')};"
        "heavy = {'sympy', 'numpy', 'rich', 'numba'} | rooms;"
        "sys.exit(', '.join(heavy & set(sys.modules)) or 0)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, *words], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("shell", tree.SHELLS)
def test_the_completion_script_uses_the_variable_that_is_read(shell: str, capsys: Output) -> None:
    assert main(["--completion", shell]) == 0
    assert f"{tree.COMPLETION}={shell}_complete" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("longwave ver", ["verify"]),
        ("longwave run rogue_cn_k_0.5", ["rogue_cn_k_0.5", "rogue_cn_k_0.5_long"]),
        ("longwave verify --only rog", ["rogue_cn"]),
        ("longwave library kdv_pos", ["kdv_positon", "kdv_positon_speed"]),
        ("longwave list sc", ["schemes", "scenes"]),
        ("longwave verify --me", ["--method"]),
        ("longwave run mine/", ["mine/"]),
    ],
)
def test_words_and_names_are_completed(line: str, expected: list[str]) -> None:
    place = str(len(line.split()) - 1)
    requested = {tree.COMPLETION: "bash_complete", "COMP_WORDS": line, "COMP_CWORD": place}
    done = command(**requested)
    assert [answer.partition(",")[2] for answer in done.stdout.split()] == expected


def test_a_closed_pipe_is_no_traceback() -> None:
    words = [sys.executable, "-m", "longwave", "list", "lattices", "--json"]
    with subprocess.Popen(
        words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=HOUSE
    ) as running:
        assert running.stdout is not None
        assert running.stderr is not None
        running.stdout.close()
        assert SLOW.sub("", running.stderr.read()) == ""
    assert running.returncode == 141


SHORT = {
    "chain.toml": """
wave = "soliton_sech"
eps = 0.1
t0 = 0
snapshots = [0, 20]
tolerance = 1e-3
lattice = { K2 = 1, K4 = 1 }
parameters = { A = 1 }
domain = { compared = 60 }
""",
    "growth.toml": """
lattice = "fput"
wave = "perturbed_plane"
eps = 0.2
order = "slaved"
tolerance = 1e-2
constants = { K2 = 1, K3 = 0.5, K4 = 1 }
parameters = { amplitude = 0.3 }
envelope = { k = 2 }
""",
}


@pytest.mark.parametrize(
    "scene", [pytest.param(s, marks=[pytest.mark.slow] * (s == "growth.toml")) for s in SHORT]
)
def test_a_run_is_written_though_nobody_reads_what_it_prints(scene: str, tmp_path: Path) -> None:
    (tmp_path / scene).write_text(SHORT[scene], encoding="utf-8")
    words = [sys.executable, "-m", "longwave", "run", scene, "--output", "run.nc"]
    with subprocess.Popen(
        words,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(HOUSE)},
    ) as running:
        assert running.stdout is not None
        assert running.stderr is not None
        running.stdout.close()
        errors = running.stderr.read()
    assert running.returncode == 141, errors
    assert "error" not in errors
    assert {path.name for path in tmp_path.iterdir()} == {"run.nc", scene}
    assert load_run(tmp_path / "run.nc").attrs["title"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_full_disk_is_no_traceback() -> None:
    words = [sys.executable, "-m", "longwave", "list", "lattices"]
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run(words, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 1
    error = "error: output must be usable, got No space left on device (free some space, or write"
    assert SLOW.sub("", done.stderr).startswith(error)


def test_ctrl_c_while_a_room_is_imported_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: Output
) -> None:
    def stop(_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(longwave.cli.inventory, "inventory", stop)
    assert main(["list", "waves"]) == 130
    assert capsys.readouterr().err == "longwave list: interrupted\n"


def test_ctrl_c_as_early_as_can_be_is_one_line_and_status_130(press_ctrl_c: Any) -> None:
    words = ["longwave", "verify", "mutations", "--only", "rational_12"]
    done = press_ctrl_c(words, 0.0)
    assert done.status == 130
    assert done.announced.startswith("the misprints of rational_12: about")
    assert done.errors.startswith("longwave verify")
    assert done.errors.count("\n") == 1
    assert ": interrupted" in done.errors


@pytest.mark.slow
def test_a_slow_command_is_announced_in_a_real_process() -> None:
    """Catches: a notice that is missing if the arguments come from ``sys.argv``."""
    script = (
        "import sys, time\n"
        "import longwave.support.slow_work as slow_work\n"
        "import longwave.cli.inventory as inventory\n"
        "from longwave.__main__ import main\n"
        "slow_work.EVERY = 0.6\n"
        "inventory.print_tables = lambda *_: time.sleep(1.0)\n"
        "sys.argv = ['longwave', 'list']\n"
        "sys.exit(main())\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert re.match(r"longwave list: \S+ s so far \(Ctrl-C stops it\)\n", done.stderr)
