"""Sixty wrong inputs, at the command line and in files: one line with the remedy, no traceback.

Catches: an input that ends in a traceback, several lines, status 0, or a message without a remedy;
an error that is reported only after something was loaded or run.
"""

import errno
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from longwave.__main__ import main
from longwave.runs import run_output, run_store
from longwave.runs.run_file import load_run, save_run
from longwave.scenes.description.named_scenes import load_scene
from longwave.support import atomic_file
from tests.longwave.cli.short_chain import CHAIN

Output = pytest.CaptureFixture[str]

LATTICE = """
fields = ["u1", "u2"]
masses = ["m1", "m2"]
[[spring]]
between = ["u1[n]", "u2[n]"]
force = "K*x + g*x**2"
[[spring]]
between = ["u2[n]", "u1[n+1]"]
force = "K*x + g*x**2"
"""
ONE = """
fields = ["u"]
[[spring]]
between = ["u[n]", "u[n+1]"]
force = "K*x + g*x**2"
"""
SWEEP = 'scene = "chain.toml"\n[grid]\neps = [0.2, 0.25]\n'
FIT = "stretch,force\n0,0\n1,1\n2,3\n3,7\n4,12\n"

FILES = {"chain.toml": CHAIN, "lattice.toml": LATTICE, "sweep.toml": SWEEP, "force.csv": FIT}
FILES["one.toml"] = ONE

LINES = [
    ("derive --order -1", "--order must be a whole number from 0 to 13, got '-1' (leave it out"),
    ("derive --order 2.5", "--order must be a whole number from 0 to 13, got '2.5'"),
    ("derive --amplitude -2", "--amplitude must be a whole number from 0 to 8, got '-2'"),
    ("derive --time 99", "--time must be a whole number from 0 to 9, got '99'"),
    ("derive --k2 -1", "K2 must be positive, got -1 (the equation is derived for such values; in"),
    ("derive --k3 0 --k4 0", "which leaves Y_XXX, a linear equation (take a nonzero cubic"),
    ("derive --k2 1/0", "K2"),
    ("derive --set K5=1", "K5"),
    ("derive todda", "(did you mean toda?"),
    ("derive toda fput", "MODEL must be one, got toda fput (derive them in turn)"),
    ("derive nowhere.toml", "nowhere.toml"),
    ("derive dimer --branch optical", "--branch"),
    ("derive --map 3", "--map"),
    ("derive square --direction x", "direction"),
    ("derive --background 1/", "background"),
    (
        "prove --equation u_t",
        "--equation must be given with --solution and no file, got no --solution",
    ),
    ("prove --equation u_t --solution u=1 --limit 0", "--limit must be 0.01 to 1e+06 seconds"),
    ("library nothing", "nothing"),
    ("check nowhere.json", "nowhere.json: No such file or directory"),
    ("verify --only kinck", "(did you mean kink?"),
    ("verify --digits 20", "digits"),
    ("verify --points -1 --method residual", "points"),
    ("verify --export coq", "--export must be given with --output"),
    ("fit nowhere.csv", "nowhere.csv"),
    ("fit force.csv --law x+", "law"),
    ("fit force.csv --fix K2", "--fix must be NAME=VALUE, got 'K2' (such as m1=1,m2=3)"),
    ("fit force.csv --units mm", "units"),
    (
        "fit force.csv --scene chain.toml",
        "--scene must be given with --free, got one of them alone",
    ),
    ("fit force.csv --output a.txt", "--output must end in .toml, got 'a.txt'"),
    ("run chain.tml", "scene must be a TOML file or a shipped scene, got 'chain.tml' ("),
    ("run toda_solitn", "(did you mean toda_soliton"),
    ("run chain.toml --tolerance 0", "tolerance must satisfy tolerance > 0, got 0 (such as 1e-4)"),
    ("run chain.toml --tolerance 1e-30", "tolerance must"),
    ("run chain.toml --engine spectal", "(did you mean spectral? one of stencil, spectral)"),
    ("run chain.toml --output run.txt", "--output must end in .nc, got 'run.txt' (such as run.nc)"),
    ("run chain.toml --output no/run.nc", "must lie in an existing folder, got no/run.nc (create"),
    ("run chain.toml --output chain.toml", "--output must end in .nc"),
    ("run chain.toml --output .", "--output must name a file, got the folder . (name run.nc in"),
    ("run chain.toml --max-time soon", "must be a positive amount, got 'soon' (such as 90s, 30min"),
    ("run chain.toml --max-memory -3G", "must be a positive amount, got '-3G'"),
    ("run chain.toml --max-memory 1k", "must fit 1 kB, got about"),
    ("run chain.toml --set eps=5", "eps must satisfy eps <= 1, got 5 (it is small, as the waves"),
    ("run chain.toml --set constants.K2=-1", "K2 must satisfy K2 > 0, got -1 (sound travels"),
    ("run chain.toml --set parameters.A=0", "A must"),
    ("run chain.toml --set observables=[strian]", "observables must"),
    ("run chain.toml --set snapshots=[]", "snapshots must be a list of at least one time"),
    ("run chain.toml --set compared=0.5", "compared must be a whole number"),
    (
        "sweep sweep.toml --processes 0",
        "--processes must be 1 to 1024, got 0 (one a core is usual)",
    ),
    ("sweep sweep.toml --processes 1 --scheduler tcp://x:1", "must not be given with --scheduler"),
    ("sweep sweep.toml --seed 3", "--seed must be given with --samples, got 3 alone"),
    ("sweep chain.toml --samples 3", "samples must be 39 to 1000000, got 3 (39 are the fewest"),
    ("sweep chain.toml", "keys must be known ones, got"),
    ("sweep error_over", "sweep must be a TOML file or a shipped sweep, got 'error_over' ("),
    ("sweep sweep.toml --output x.csv", "--output must end in .nc, got 'x.csv'"),
    ("sweep sweep.toml --output a.nc --store a.nc", "--output must differ from the folder --store"),
    ("plot chain.toml --output a.bmp", "output must be a path ending in .png, .pdf, .svg"),
    ("plot chain.toml --at eps", "--at must be NAME=VALUE, got 'eps' (such as eps=0.1)"),
    ("plot chain.toml --kind map", "'map' is not one of 'all', 'snapshots', 'space_time'"),
    ("plot nowhere.nc", "nowhere.nc"),
    ("plot run.nc --kind values", "kind must not be given for a run or a scene"),
    ("animate chain.toml --output a.avi", "output must be a path ending in .mp4, .gif"),
    ("animate chain.toml --output a.gif --fps 0", "fps must satisfy 1 <= fps <= 50, got 0"),
    ("animate chain.toml --output a.gif --duration 1e9", "duration must satisfy 0.2 <= duration"),
    (
        "animate chain.toml --output a.gif --times 5 1",
        "times must satisfy first < last, got 5 and 1",
    ),
    ("converge chain.toml --eps 0.1,0.2", "eps must be 3 to 20 different values, got [0.1, 0.2]"),
    ("converge chain.toml --eps 0.1,0.2,-0.3", "eps must satisfy eps > 0, got -0.3 (such as"),
    ("converge chain.toml --output a.nc", "output must be a path ending in .png, .pdf, .svg"),
    ("list waves --library", "--library must not be given with KIND, got waves as well"),
    ("explore --port 99999", "99999 is not in the range 0<=x<=65535"),
    ("report --workers 0 --output r", "workers"),
]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name, text in FILES.items():
        Path(name).write_text(text, encoding="utf-8")
    return tmp_path


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write the file of a run."""
    place = tmp_path_factory.mktemp("runs")
    (place / "chain.toml").write_text(CHAIN, encoding="utf-8")
    save_run(load_scene(place / "chain.toml").run(), place / "run.nc")
    return place / "run.nc"


@pytest.mark.parametrize(("line", "message"), LINES)
def test_a_wrong_input_is_a_one_line_error(
    line: str, message: str, folder: Path, saved: Path, capsys: Output
) -> None:
    (folder / "run.nc").write_bytes(saved.read_bytes())
    before = sorted(folder.iterdir())
    assert main(line.split()) in (1, 2)
    output = capsys.readouterr()
    assert output.err.startswith("error: ")
    assert output.err.count("\n") == 1
    assert message in output.err
    assert sorted(folder.iterdir()) == before


CONTENTS = [
    ("lattice.toml", "u1", "u_1", "between must be a sum of sites such as F[n+1] - 2*F[n], got"),
    ("lattice.toml", "u2", "u1", "fields must have different names of letters and digits"),
    ("one.toml", "K*x", "-1*x", "stiffness must be positive: the square of the sound speed"),
    ("lattice.toml", "K*x + g*x**2", "K*x +", "force: expected"),
    ("lattice.toml", '"u2[n]", "u1[n+1]"', '"u2[n]"', "between must be two sites"),
    ("lattice.toml", "u1[n+1]", "w[n+1]", "between must be among u1, u2, got 'w'"),
    ("lattice.toml", '"m1", "m2"', '"m1"', "masses must be a list of 2, one a field"),
    (
        "lattice.toml",
        "between",
        "betwen",
        "keys must be known ones, got 'betwen' (did you mean between?",
    ),
    ("chain.toml", "eps = 0.2", "eps = 5", "eps must satisfy eps <= 1, got 5 (it is small, as"),
    ("chain.toml", "eps = 0.2", 'eps = "small"', "eps must be a number, got 'small' (such as"),
    ("chain.toml", "eps = 0.2", "", "eps must be stated, got nothing"),
    ("chain.toml", "K2 = 1", "K2 = -1", "K2 must satisfy K2 > 0, got -1 (sound travels"),
    ("chain.toml", "K2 = 1, K4", "K2 = 1, k4", "keys in [lattice] must be known ones, got k4"),
    ("chain.toml", "A = 1", "B = 1", "parameters must be those of soliton_sech, got B"),
    ("chain.toml", "[0, 10]", "[0, nan]", "snapshots must be finite, got nan"),
    ("chain.toml", "[0, 10]", "[10, 0]", "snapshots must"),
    ("chain.toml", "soliton_sech", "soliton_sec", "did you mean soliton_sech"),
    ("chain.toml", "tolerance = 1e-3", "", "must be stated, got nothing (state it or a tolerance)"),
    ("chain.toml", "t0 = 0", "t0 = 0 0", "scene must be a TOML file, got"),
    ("sweep.toml", "[0.2, 0.25]", "0.2", "eps must be a list of values or a range, got 0.2"),
    ("sweep.toml", "[0.2, 0.25]", "[0.2, 0.2]", "eps in [grid] must have different values"),
    ("sweep.toml", "eps =", "epz =", "fields must be known ones, got 'epz' (did you mean eps?"),
    ("sweep.toml", "chain.toml", "chian.toml", "chian.toml: No such file or directory"),
    ("force.csv", "stretch", "strech", "strech"),
    ("force.csv", "3,7", "3,seven", "seven"),
]
COMMANDS = {
    "lattice.toml": "derive",
    "one.toml": "derive",
    "chain.toml": "run",
    "sweep.toml": "sweep",
}


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(("name", "right", "wrong", "message"), CONTENTS)
def test_a_wrong_file_is_a_one_line_error(
    name: str, right: str, wrong: str, message: str, capsys: Output
) -> None:
    assert right in FILES[name]
    Path(name).write_text(FILES[name].replace(right, wrong), encoding="utf-8")
    assert main([COMMANDS.get(name, "fit"), name]) in (1, 2)
    output = capsys.readouterr()
    assert output.err.startswith("error: ")
    assert output.err.count("\n") == 1
    assert message in output.err


@pytest.mark.slow
def test_an_impossible_strain_is_reported(saved: Path, folder: Path, capsys: Output) -> None:
    run = load_run(saved)
    for fault, told in (
        ("nan", "got NaN or inf in 1 of 2 snapshots"),
        ("int", "got int64"),
        ("none", "got none"),
    ):
        changed = run.copy(deep=True)
        if fault == "nan":
            changed["strain"].values[1] = np.nan
        elif fault == "int":
            changed["strain"] = changed["strain"].astype(int)
        else:
            changed = changed.drop_vars("strain")
        save_run(changed, folder / f"{fault}.nc")
        for words in (["plot"], ["run"]):
            main([*words, f"{fault}.nc"])
            errors = capsys.readouterr().err
            assert "Traceback" not in errors
            assert f"{fault}.nc: strain must be" in errors
            assert told in errors


def test_options_are_checked_before_anything_is_loaded(folder: Path) -> None:
    lines = [
        line for line, _ in LINES if re.search("output|processes|--seed|--at|--fps|--port", line)
    ]
    lines = [
        line for line in lines if line.split()[0] in ("run", "sweep", "plot", "animate", "converge")
    ]
    script = (
        "import sys\nfrom longwave.__main__ import main\n"
        f"for line in {lines!r}: assert main(line.split()) == 2, line\n"
        "heavy = {'sympy', 'numba'} & set(sys.modules)\n"
        "sys.exit(', '.join(heavy) or 0)\n"
    )
    done = subprocess.run(
        [sys.executable, "-P", "-c", script], capture_output=True, text=True, cwd=folder
    )
    assert done.returncode == 0, done.stderr


def full(*_: object, **__: object) -> None:
    raise OSError(errno.ENOSPC, "No space left on device", "there")


@pytest.mark.slow
def test_a_full_disk_has_status_1_at_every_write(
    folder: Path, saved: Path, monkeypatch: pytest.MonkeyPatch, capsys: Output
) -> None:
    (folder / "run.nc").write_bytes(saved.read_bytes())
    monkeypatch.setattr(run_output, "save_run", full)
    monkeypatch.setattr(run_store, "_save", full)
    monkeypatch.setattr(atomic_file.Path, "write_bytes", full)
    monkeypatch.setattr(atomic_file.Path, "write_text", full)
    for line in (
        "run chain.toml --output new.nc",
        "run chain.toml --store kept",
        "verify --only kink --output kink.json",
        "fit force.csv --output fitted.toml",
    ):
        assert main(line.split()) == 1, line
        told = capsys.readouterr().err.splitlines()[-1]
        assert told.startswith("error: ")
        assert "No space left on device" in told
