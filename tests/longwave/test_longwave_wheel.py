"""The wheel, installed into an empty environment, works from outside the checkout."""

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

HOUSE = Path(__file__).parents[2]
SCENE = "rogue_cn_k_0.5"


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
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The scripts' folder of an environment with the wheel, and the packages that it needs."""
    base = tmp_path_factory.mktemp("wheel")
    unwanted = shutil.ignore_patterns(".*", "build", "*.egg-info", "__pycache__", "tests", "docs")
    shutil.copytree(HOUSE, base / "source", ignore=unwanted)
    pip = (sys.executable, "-m", "pip", "--disable-pip-version-check")
    call(*pip, "wheel", base / "source", "--no-deps", "--wheel-dir", base, cwd=base)
    shutil.rmtree(base / "source")
    venv.create(base / "env")
    python = base / "env" / "bin" / "python"
    (wheel,) = base.glob("longwave-*.whl")
    call(*pip, "--python", python, "install", "--no-deps", "--no-index", wheel, cwd=base)
    (packages,) = (base / "env" / "lib").glob("python*/site-packages")
    (packages / "needed.pth").write_text(sysconfig.get_path("purelib"), encoding="utf-8")
    return python.parent


@pytest.mark.slow
def test_the_installed_command_runs_plots_and_reports(installed: Path, tmp_path: Path) -> None:
    (tmp_path / "solutions.py").write_text("raise SystemExit('by mistake')", encoding="utf-8")
    where = call(
        installed / "python", "-P", "-c", "import verify; print(verify.__file__)", cwd=tmp_path
    )
    assert Path(where.stdout.strip()).is_relative_to(installed.parent)
    ran = call(installed / "longwave", "run", SCENE, "--output", "run.nc", cwd=tmp_path)
    assert "Rogue wave on the cn wave" in ran.stdout
    drawing = "import longwave; longwave.plot('run.nc', 'run.pdf')"
    call(installed / "python", "-P", "-c", drawing, cwd=tmp_path)
    assert (tmp_path / "run.pdf").read_bytes().startswith(b"%PDF")
    said = call(installed / "longwave", "report", "--help", cwd=tmp_path)
    assert "longwave-report" in said.stdout
