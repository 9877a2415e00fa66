"""The functions of `longwave.session`: arguments, results, and how these are displayed."""

import io
import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import longwave
import longwave.support.progress_line as progress_line
from longwave.lattice import Model, State
from longwave.runs.sweep_file import Sweep
from longwave.scenes.engines.methods import record_scene
from longwave.session import as_sweep

GRID = {"eps": np.array([0.3, 0.4]), "parameters.kappa": [0.5, 1]}
SCENE = longwave.Scene.of(
    name="short", lattice="toda", constants={"a": 1, "b": 1}, eps=0.3, wave="kdv_soliton",
    parameters={"kappa": 1}, slow_times=[0, 0.1], half_width=4, tolerance=1e-3,
)  # fmt: skip


@pytest.fixture(scope="module")
def result() -> Any:
    return longwave.run(SCENE)


def test_a_run_is_the_same_by_name_file_and_scene(tmp_path: Path, result: Any) -> None:
    path = tmp_path / "short.toml"
    path.write_text(SCENE.toml(), "utf-8")
    for given in (path, str(path), SCENE):
        assert np.array_equal(longwave.run(given).strain, result.strain)


INSTEAD: Mapping[str, tuple[Callable[[], Any], str]] = {
    "a run": (lambda: longwave.run(SCENE), "load_run"),
    "a run's file": (lambda: "made.nc", "load_run"),
    "a sweep": (lambda: as_sweep(SCENE, GRID), "longwave.sweep"),
    "a sweep's name": (lambda: "growth_over_k", "longwave.sweep"),
    "a wave": (lambda: longwave.CATALOGUE["kink"], "Scene.of(wave="),
    "a lattice": (lambda: longwave.LATTICES["toda"], "Scene.of(lattice="),
    "numbers": (lambda: Model(1.0, 0.0, 1.0).lattice, "integrate"),
    "a state": (lambda: State(0.0, np.zeros((1, 8)), np.zeros((1, 8))), "integrate"),
    "keywords": (lambda: {"wave": "kink"}, "Scene.of(**"),
    "nothing": (lambda: None, "such as"),
}
"""What is no scene, and what is to be called."""


@pytest.mark.parametrize("kind", INSTEAD)
def test_an_argument_that_is_no_scene_names_the_right_function(kind: str) -> None:
    make, instead = INSTEAD[kind]
    with pytest.raises(ValueError, match=r"scene must be a scene, its name or its file") as output:
        longwave.run(make())
    assert instead in str(output.value)
    assert "\n" not in str(output.value)


@pytest.mark.slow
def test_a_sweep_of_a_scene_is_one_data_set(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, result: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    output: list[float] = []
    found = longwave.sweep(SCENE, GRID, processes=1, progress=output.append)
    assert found.error.dims == ("eps", "kappa")
    assert found.status.values.tolist() == [["done"] * 2] * 2
    assert found.error.sel(eps=0.3, kappa=1).item() == pytest.approx(result.error.max().item())
    assert output[-1] == 1.0
    assert (tmp_path / "short.store").is_dir()
    again = longwave.sweep(SCENE, GRID, processes=1, progress=output.append)
    assert again.identical(found)


def test_a_sweep_is_given_by_tables_name_or_object() -> None:
    tables = {"scene": "toda_soliton", "grid": {"eps": [0.1, 0.2]}}
    sweep = as_sweep(tables)
    assert isinstance(sweep, Sweep)
    assert as_sweep(sweep) is sweep
    assert len(as_sweep("growth_over_k")) == 84


@pytest.mark.parametrize(
    ("source", "grid", "output"),
    [
        (3, None, "source must be a sweep, its name, its file or its tables, got 3"),
        ("toda_soliton", {"eps": 0.1}, "eps in grid must be a list of values, got 0.1"),
        ("toda_soliton", {"eps": "many"}, "eps in grid must be a list of values, got 'many'"),
        ({"scene": "toda_soliton"}, {"eps": [0.1]}, "grid must be given with a scene, got it with"),
        ("toda_solitn", {"eps": [0.1]}, "did you mean toda_soliton"),
    ],
)
def test_an_argument_that_is_no_sweep_is_an_error(source: Any, grid: Any, output: str) -> None:
    with pytest.raises(ValueError, match=output) as refused:
        as_sweep(source, grid)
    assert "\n" not in str(refused.value)


@pytest.mark.slow
def test_a_script_without_a_guard_may_sweep(tmp_path: Path) -> None:
    """Catches: worker processes that run the user's script again and start a sweep each."""
    script = tmp_path / "mine.py"
    script.write_text(
        "import longwave\nprint('once')\n"
        "found = longwave.sweep('toda_soliton', {'eps': [0.3, 0.4], 'slow_times': [[0, 0.1]]},"
        " processes=1)\nprint(found.status.values.ravel().tolist())\n",
        "utf-8",
    )
    done = subprocess.run(
        [sys.executable, "-P", str(script)], capture_output=True, text=True, cwd=tmp_path,
        check=True, env=environment(),
    )  # fmt: skip
    assert done.stdout.splitlines() == ["once", "['done', 'done']"]


def environment() -> dict[str, str]:
    return os.environ | {"PYTHONPATH": str(Path(longwave.__file__).parents[1])}


def test_a_convergence_is_drawn_and_shown(tmp_path: Path) -> None:
    found = longwave.converge(SCENE, [0.4, 0.35, 0.3])
    assert repr(found).startswith("<Convergence of short: rate ")
    assert found._repr_html_().count("<tr>") == 4
    figure = found.plot(tmp_path / "rate.svg")
    assert (tmp_path / "rate.svg").read_bytes().startswith(b"<?xml")
    shown, size = figure._repr_png_()
    pixels = np.array(Image.open(io.BytesIO(shown)).size)
    assert np.abs(pixels - 2 * np.array([size["width"], size["height"]])).max() <= 2
    assert longwave.plot(found).get_suptitle() == figure.get_suptitle()


def test_a_picture_shows_itself(result: Any) -> None:
    shown, size = longwave.plot(result)._repr_png_()
    assert shown.startswith(b"\x89PNG")
    assert 500 < size["width"] < 800


def test_a_film_shows_itself_without_a_file(tmp_path: Path, result: Any) -> None:
    stored = longwave.animate(result, duration=0.2, dpi=40)
    saved = longwave.animate(result, tmp_path / "film.gif", duration=0.2, dpi=40)
    assert stored.frames == saved.frames == result.sizes["time"]
    assert "data:image/gif;base64," in (saved._repr_html_() or "")
    assert repr(saved) == f"<Film of {stored.frames} frames in {tmp_path / 'film.gif'}>"
    assert "base64" in (stored._repr_html_() or "")
    (tmp_path / "film.gif").unlink()
    assert saved._repr_html_() is None


def test_objects_are_shown_in_one_line_and_as_tables(result: Any) -> None:
    fitted = longwave.fit_force([-2, -1, 0, 1, 2], [-2.1, -0.9, 0.1, 1.0, 1.9], law="K2*x")
    proved = longwave.prove("u_t + u_x", "u = sech(x - t)")
    refuted = longwave.prove("u_t + u_x", "u = sech(x + t)")
    record = record_scene(SCENE)
    for thing in (SCENE, fitted, proved, refuted, record, as_sweep(SCENE, GRID)):
        assert "\n" not in repr(thing)
        assert len(repr(thing)) < 400
        table = thing._repr_html_()
        assert table.startswith("<table>")
        assert table.endswith("</table>")
        assert " at 0x" not in table
    assert "K2 = " in repr(fitted)
    assert "$" in SCENE._repr_html_()  # the formula
    assert "$" in proved._repr_html_()
    assert "REFUTED" in refuted._repr_html_()
    assert "&lt;" in SCENE.changed(title="a < b")._repr_html_()


def test_a_scene_takes_a_lattice_or_its_tables() -> None:
    tables = {
        "fields": ["u"], "masses": ["m"], "positive": ["m", "a"],
        "spring": [{"between": ["u[n]", "u[n+1]"], "force": "a*x + b*x**2"}],
    }  # fmt: skip
    own = longwave.derive.lattice_of({"name": "mine", **tables})
    values = {"m": 1, "a": 1, "b": 1}
    errors = [
        longwave.run(SCENE.changed(lattice=lattice, constants=values)).error.max().item()
        for lattice in (own, tables)
    ]
    assert errors[0] == pytest.approx(errors[1], rel=1e-9)
    assert SCENE.changed(lattice=longwave.LATTICES["toda"]) == SCENE
    with pytest.raises(ValueError, match="lattice must be a name, a Lattice or its tables, got 3"):
        SCENE.changed(lattice=3)


def test_a_very_long_formula_is_not_shown() -> None:
    assert longwave.closed_form("rogue_cn")._repr_latex_() is None
    assert longwave.closed_form("kink")._repr_latex_() is not None


def test_a_progress_line_is_overwritten_and_ends_with_done(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(progress_line, "SILENT", 0.0)
    monkeypatch.setattr(progress_line, "TICK", 0.01)
    with progress_line.ProgressLine("toda_soliton") as line:
        line.left.share(0.0)
        line.left.share(0.5)
        line._thread.join(0.2)
    message = capsys.readouterr().err
    assert message.count("\n") == 1
    first, *_, last = message.split("\r")[1:]
    assert first.startswith("toda_soliton: 50 %, ")
    assert last.startswith("toda_soliton: done in ")


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "openpty"), reason="there are no such terminals")
def test_a_terminal_shows_a_bar_that_goes_away(tmp_path: Path) -> None:
    ours, theirs = os.openpty()
    call = "import longwave; longwave.run('toda_soliton')"
    words = [sys.executable, "-P", "-c", call]
    child = subprocess.Popen(words, stderr=theirs, env=environment() | {"TERM": "xterm"})
    os.close(theirs)
    message = b""
    with suppress(OSError):  # what is read from a terminal that nobody holds any more
        while found := os.read(ours, 4096):
            message += found
    os.close(ours)
    assert child.wait() == 0
    assert b"toda_soliton" in message
    assert message.endswith(b"\x1b[2K")


def test_a_short_call_shows_no_progress(capsys: pytest.CaptureFixture[str]) -> None:
    with progress_line.ProgressLine("quick"):
        pass
    assert capsys.readouterr().err == ""
