"""The wheel, installed into an empty environment, works outside the checkout."""

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path
from zipfile import ZipFile

import pytest

from house import HOUSE, ROOMS

SCENE = "rogue_cn_k_0.5"
KERNELS = "longwave/support/compiled/kernel_texts/"
PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check")


def call(*words: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(
        [str(word) for word in words],
        cwd=cwd,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the wheel from a copy of the sources."""
    base = tmp_path_factory.mktemp("wheel")
    unwanted = shutil.ignore_patterns(".*", "build", "*.egg-info", "__pycache__", "tests", "docs")
    shutil.copytree(HOUSE, base / "source", ignore=unwanted)
    call(*PIP, "wheel", base / "source", "--no-deps", "--wheel-dir", base, cwd=base)
    shutil.rmtree(base / "source")
    (built,) = base.glob("longwave-*.whl")
    return built


@pytest.fixture(scope="module")
def installed(wheel: Path) -> Path:
    """Return the scripts' folder of an environment with the wheel and its dependencies."""
    base = wheel.parent
    venv.create(base / "env")
    python = base / "env" / "bin" / "python"
    call(*PIP, "--python", python, "install", "--no-deps", "--no-index", wheel, cwd=base)
    (packages,) = (base / "env" / "lib").glob("python*/site-packages")
    (packages / "needed.pth").write_text(sysconfig.get_path("purelib"), encoding="utf-8")
    return python.parent


@pytest.mark.slow
def test_the_wheel_holds_every_source_and_every_file_that_is_read(wheel: Path) -> None:
    read = (".py", ".toml", ".j2", ".gp", ".mac", ".v", "py.typed")
    expected = {
        str(path.relative_to(HOUSE) if room == "longwave" else "longwave" / path.relative_to(HOUSE))
        for room in ROOMS
        for path in (HOUSE / room).rglob("*")
        if path.name.endswith(read) and "build" not in path.parts
    }
    assert "longwave/py.typed" in expected
    with ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if ".dist-info/" not in name}
        (top,) = (name for name in archive.namelist() if name.endswith("/top_level.txt"))
        assert archive.read(top) == b"longwave\n"
    kernels = {name for name in names if name.startswith(KERNELS) and name.endswith(".ll.z")}
    assert kernels, "the build wrote no compiled kernels"
    assert names - kernels == expected


@pytest.mark.slow
def test_the_files_of_a_user_are_theirs_beside_the_installed_package(
    installed: Path, tmp_path: Path
) -> None:
    (tmp_path / "runs").mkdir()
    for own in ("lattice.py", "solutions.py", "runs/__init__.py"):
        (tmp_path / own).write_text("MINE = True\n", encoding="utf-8")
    (tmp_path / "script.py").write_text(
        "import lattice\n"
        "import longwave\n"
        "import runs, solutions\n"
        "assert lattice.MINE and runs.MINE and solutions.MINE\n"
        "print(longwave.closed_form('kink').name, longwave.solutions.__name__)\n",
        encoding="utf-8",
    )
    done = call(installed / "python", "-W", "error", "script.py", cwd=tmp_path)
    assert done.stdout == "kink longwave.solutions\n"


@pytest.mark.slow
def test_the_installed_command_runs_and_plots(installed: Path, tmp_path: Path) -> None:
    (tmp_path / "solutions.py").write_text("raise SystemExit('by mistake')", encoding="utf-8")
    for room in ROOMS[:-1]:
        code = f"from longwave import {room}; print({room}.__file__)"
        where = call(installed / "python", "-P", "-c", code, cwd=tmp_path)
        assert Path(where.stdout.strip()).is_relative_to(installed.parent)
    command = installed / "longwave"
    ran = call(command, "run", SCENE, "--output", "run.nc", cwd=tmp_path)
    assert "Rogue wave on the cn wave" in ran.stdout
    assert (
        call(command, "plot", "run.nc", "--output", "run.pdf", cwd=tmp_path).stdout == "run.pdf\n"
    )
    assert (tmp_path / "run.pdf").read_bytes().startswith(b"%PDF")
    call(command, "plot", SCENE, "--kind", "snapshots", cwd=tmp_path)
    assert (tmp_path / f"{SCENE}.png").read_bytes().startswith(b"\x89PNG")
