"""`longwave fit`: from measured points to a lattice file whose coefficients have intervals."""

import json
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

from longwave.__main__ import main
from longwave.derive import read_lattice

Output = pytest.CaptureFixture[str]

STRETCH = np.linspace(-0.5, 0.5, 41)
FORCE = STRETCH + 0.5 * STRETCH**3 + 0.005 * np.random.default_rng(5).normal(size=41)


@pytest.fixture
def points(tmp_path: Path) -> Path:
    path = tmp_path / "force.csv"
    rows = [f"{x:.4f},{f:.6f},0.005" for x, f in zip(STRETCH, FORCE, strict=True)]
    path.write_text("\n".join(["stretch,force,deviation", *rows]), "utf-8")
    return path


def test_a_law_is_fitted_written_and_drawn(points: Path, capsys: Output) -> None:
    lattice, picture = points.with_name("chain.toml"), points.with_name("fit.png")
    words = ["--output", str(lattice), "--plot", str(picture), "--law", "K2*x + K4*x**3"]
    assert main(["fit", str(points), *words]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("F(x) = K2*x + K4*x**3, fitted to 41 points of force.csv\n")
    assert "│ K2       │ 0.9902 +- 0.0066 │ 0.9772 .. 1.0032 │ 1.00    │ -0.92   │" in printed
    assert "chi^2 30.42 for 39 degrees of freedom, 0.78 each, p = 0.84" in printed
    assert "warning" not in printed
    assert matplotlib.image.imread(picture).shape[1] == 680
    assert lattice.read_text("utf-8").startswith("# force law of 41 points of force.csv\n# chi^2 ")
    found = read_lattice(lattice).measured
    assert found is not None
    assert found.deviations["K2"] == pytest.approx(0.0066, abs=5e-5)
    assert main(["derive", str(lattice)]) == 0
    assert "  of Y^2 Y_X: 0.827 +- 0.061, 0.708 .. 0.946\n" in capsys.readouterr().out


def test_a_chosen_law_has_wider_intervals_for_the_other_laws(points: Path, capsys: Output) -> None:
    assert main(["fit", str(points)]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("F(x) = K2*x + K4*x**3, fitted to 41 points of force.csv\n")
    assert "│ K2       │ 0.9902 +- 0.0066 │" not in printed
    assert "AICc above the least: K2 201.4, K2 K3 201.8, K2 K3 K4 1.2, K2 K4 0.7, " in printed
    assert "the deviations include those of the other laws, weighted by exp(-AICc/2)" in printed
    assert "warning: the points do not determine the law, and other laws that describe" in printed


def test_a_wrong_law_is_fitted_with_a_warning(points: Path, capsys: Output) -> None:
    lattice = points.with_name("chain.toml")
    assert main(["fit", str(points), "--law", "K2*x", "--output", str(lattice)]) == 0
    printed = capsys.readouterr().out
    assert "\nwarning: the law differs from the points by more than their deviations" in printed
    assert "\nwarning: the residuals follow a smooth curve along the stretch" in printed
    assert "\n# warning: the law differs from" in lattice.read_text("utf-8")


def test_constants_are_fixed(points: Path, capsys: Output) -> None:
    words = ["fit", str(points), "--law", "K2*x + K4*x**3", "--fix", "K4=1/2", "--json"]
    assert main(words) == 0
    data = json.loads(capsys.readouterr().out)
    assert list(data["constants"]) == ["K2"]
    assert data["covariance"] == [[pytest.approx(data["constants"]["K2"]["deviation"] ** 2)]]
    assert data["degrees_of_freedom"] == 40
    assert data["noise"] is None
    assert data["warnings"] == []


def test_json_has_null_instead_of_nan(points: Path, capsys: Output) -> None:
    """Catches: NaN in JSON, and a chi^2 without stated deviations."""
    lines = points.read_text("utf-8").splitlines()
    points.write_text("\n".join(line.rpartition(",")[0] for line in lines), "utf-8")
    assert main(["fit", str(points), "--json"]) == 0
    printed = capsys.readouterr().out
    assert "NaN" not in printed
    data = json.loads(printed)
    assert data["p_value"] is data["chi_squared"] is None
    assert data["noise"] == pytest.approx(0.005, rel=0.3)
    assert data["aicc"]["K2 K4"] < data["aicc"]["K2"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--law", "K2*z"], "law must be a formula in the stretch x and constants"),
        (
            ["--law", "table", "--fix", "K2=1"],
            "fixed constants must come with a formula, got K2 and table (state the law)",
        ),
        (["--fix", "K4"], "--fix must be NAME=VALUE, got 'K4'"),
        (["--fix", "K4=1"], "fixed constants must come with a formula, got K4 and none"),
        (["--units", "mm"], "--units must be a length and a force, got 'mm'"),
        (["--output", "chain.nc"], "--output must end in .toml, got 'chain.nc'"),
        (["--plot", "/nowhere/fit.png"], "--plot must lie in an existing folder"),
        (["--plot", "fit.txt"], "--plot must end in .png or .pdf or .svg, got 'fit.txt'"),
    ],
)
def test_wrong_options_are_a_one_line_error(
    words: list[str], message: str, points: Path, capsys: Output, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(points.parent)
    assert main(["fit", "force.csv", *words]) == 2
    output = capsys.readouterr()
    assert output.err.startswith("error: ")
    assert output.err.count("\n") == 1
    assert message in output.err
    assert output.out == ""
    assert [path.name for path in points.parent.iterdir()] == ["force.csv"]


def test_a_file_without_a_force_law_is_a_one_line_error(tmp_path: Path, capsys: Output) -> None:
    assert main(["fit", str(tmp_path / "none.csv")]) == 2
    assert "none.csv: No such file or directory" in capsys.readouterr().err
    (tmp_path / "\x1b[31m.csv").write_text("stretch,force\n1,\x1b[31m\n", "utf-8")
    assert main(["fit", str(tmp_path / "\x1b[31m.csv")]) == 2
    error = capsys.readouterr().err
    assert "\x1b" not in error
    assert "line 2 must hold finite numbers" in error
