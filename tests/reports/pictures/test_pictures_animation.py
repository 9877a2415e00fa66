"""`longwave animate`: frames of a film, messages, wrong input, and files after Ctrl-C."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from PIL import Image

from longwave.__main__ import main
from longwave.reports.pictures import animation, film_files
from longwave.reports.pictures.animation import animate, bench_frames, film_of
from longwave.reports.pictures.style import styled
from longwave.runs import save_run
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines import scene_run

Output = pytest.CaptureFixture[str]

SCENE = Scene.of(
    name="soliton",
    title="One soliton, 100 % [/nope] $x_",
    wave="soliton_sech",
    parameters=(("A", 1),),
    eps=0.2,
    t0=0,
    snapshots=(0, 20),
    K2=1,
    K4=1,
    step=0.5,
    domain="ring",
    sites=512,
    compared=150,
    observables=("strain", "time_step_error"),
)


@pytest.fixture(scope="module")
def finished_run() -> xr.Dataset:
    times = tuple(float(t) for t in range(6))
    return scene_run.run(SCENE.changed(snapshots=times, observables=("strain",)))


def frames_of(path: Path) -> int:
    with Image.open(path) as image:
        return int(image.n_frames)


def test_a_run_is_shown_at_its_snapshots_between_the_times(
    finished_run: xr.Dataset, tmp_path: Path
) -> None:
    path = tmp_path / "film.gif"
    assert animate(finished_run, path, duration=1.0, dpi=40) == frames_of(path) == 6
    assert (
        animate(finished_run, path, duration=1.0, dpi=40, times=(1.0, 3.5)) == frames_of(path) == 3
    )


def test_a_film_holds_the_runs_numbers_and_says_time_and_error(finished_run: xr.Dataset) -> None:
    with styled():
        film = film_of(finished_run, 40.0)
    half_width = (film._offset.shape[1] - 1) // 2
    nearby = finished_run.sel(site=slice(-half_width, half_width))
    assert 0 < half_width < 60
    assert np.array_equal(film._offset, nearby.n - nearby.time)
    assert np.array_equal(film._strain, nearby.strain)
    assert np.array_equal(film._wave, nearby.analytic)
    assert film._clock[3] == f"$t = 3.0$\nerror {float(finished_run.error[3]):.3f}"
    assert film.figure.get_suptitle() == SCENE.title
    assert film._ax.get_xlabel() == "$n - c\\,t$  (sites)"


@pytest.mark.parametrize(
    "scene", [SCENE, pytest.param(load_scene("toda_soliton"), marks=pytest.mark.slow)]
)
def test_a_scene_is_run_for_as_many_snapshots_as_the_film_has(
    scene: Scene, finished_run: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenes: list[Any] = []

    def noted(scene: Any, *_: object) -> xr.Dataset:
        scenes.append(scene)
        return finished_run

    monkeypatch.setattr(scene_run, "run", noted)
    animate(scene, tmp_path / "film.gif", duration=1.0, fps=10.0, dpi=40.0)
    (run,) = scenes
    if scene.has_moving_wave:
        assert run.snapshots == tuple(np.linspace(0.0, 20.0, 10))
        assert run.observables == ("strain",)
        animate(scene, tmp_path / "film.gif", 1.0, 10.0, 40.0, times=(2.0, 5.0))
        assert scenes[1].snapshots == tuple(np.linspace(2.0, 5.0, 10))
    else:
        ends = scene.slow_times[0], scene.slow_times[-1]
        assert run.slow_times == tuple(np.linspace(*ends, 10))
        animate(scene, tmp_path / "film.gif", duration=30.0, fps=10.0, dpi=40.0)
        assert len(scenes[1].slow_times) == 300
        animate(scene, tmp_path / "film.gif", 1.0, 10.0, 40.0, times=(2.0, 5.0))
        begin = ends[0] / scene.eps**3
        assert scenes[2].t0 == pytest.approx(begin)
        assert scenes[2].snapshots == pytest.approx(tuple(np.linspace(2.0, 5.0, 10)))
        assert scenes[2].slow_times == ()
        with pytest.raises(
            ValueError, match=f"times must begin at t0 = {begin:g} or later, got -1e"
        ):
            animate(scene, tmp_path / "film.gif", 1.0, 10.0, 40.0, times=(-1e9, 5.0))
        assert len(scenes) == 3


def test_snapshots_that_blew_up_are_left_out(finished_run: xr.Dataset, tmp_path: Path) -> None:
    broken = finished_run.copy(deep=True)
    broken["strain"].values[4, 7] = np.nan
    broken["strain"].values[5, 7] = np.inf
    assert animate(broken, tmp_path / "film.gif", dpi=40) == 4
    broken["strain"].values[:] = np.nan
    with pytest.raises(ValueError, match=r"^source must hold a finite snapshot .* got 6 snapshots"):
        animate(broken, tmp_path / "film.gif", dpi=40)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"duration": 0.0}, r"duration must satisfy 0\.2 <= duration <= 600, got 0"),
        ({"duration": np.nan}, "duration must satisfy"),
        ({"fps": 60.0}, r"fps must satisfy 1 <= fps <= 50, got 60"),
        ({"dpi": 1e6}, "dpi must satisfy 30 <= dpi <= 400"),
        ({"duration": 600.0, "fps": 50.0}, "a film must have at most 3000 frames, got 30000"),
        ({"times": (5.0, 5.0)}, "times must satisfy first < last, got 5 and 5"),
        ({"times": (-3.0, 5.0)}, "times must begin at t0 = 0 or later, got -3"),
        ({"output": "film.png"}, r"output must be a path ending in \.mp4, \.gif, got 'film.png'"),
    ],
)
def test_wrong_input_is_one_line_before_anything_is_run(
    words: dict[str, Any], said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scene_run, "run", None)
    with pytest.raises(ValueError, match=rf"^{said}[^\n]*$"):
        animate(SCENE, **{"output": "film.gif"} | words)


def test_a_run_without_snapshots_is_one_line(finished_run: xr.Dataset, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"got none of strain \(the scene must ask for strain\)$"):
        animate(finished_run[["error"]], tmp_path / "film.gif")
    with pytest.raises(ValueError, match=r"^source must be the run of a scene, got the result of"):
        animate(finished_run.assign_attrs(sweep="{}"), tmp_path / "film.gif")


def test_the_command_says_that_a_run_has_few_snapshots(
    finished_run: xr.Dataset, tmp_path: Path, capsys: Output, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    save_run(finished_run, "run.nc")
    assert main(["animate", "run.nc", "--output", "film.gif", "--dpi", "40"]) == 0
    output = capsys.readouterr()
    assert output.out == "film.gif\n"
    assert output.err == "run.nc has 6 snapshots: so many frames (a scene has more)\n"


@pytest.mark.parametrize("there", [True, False])
def test_the_film_is_mp4_where_ffmpeg_is_and_gif_otherwise(
    there: bool, capsys: Output, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (animation, film_files):
        monkeypatch.setattr(module, "has_ffmpeg", lambda: there)
    monkeypatch.setattr(animation, "animate", lambda *_, **__: 99)
    assert main(["animate", "rogue_cn_k_0.5"]) == 0
    assert capsys.readouterr().out == f"rogue_cn_k_0.5.{'mp4' if there else 'gif'}\n"


def test_without_ffmpeg_the_remedy_is_printed_before_the_run(
    capsys: Output, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.setattr(scene_run, "run", None)
    assert main(["animate", "rogue_cn_k_0.5", "--output", "x.mp4"]) == 2
    assert "(take 'x.gif', or install ffmpeg)" in capsys.readouterr().err


def test_ctrl_c_is_one_line_and_leaves_nothing(
    tmp_path: Path, capsys: Output, monkeypatch: pytest.MonkeyPatch, finished_run: xr.Dataset
) -> None:
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    save_run(finished_run, tmp_path / "run.nc")
    monkeypatch.setattr("longwave.reports.pictures.film_files.PillowImage.fromarray", stop)
    path = tmp_path / "film.gif"
    assert main(["animate", str(tmp_path / "run.nc"), "--output", str(path)]) == 130
    assert capsys.readouterr().err == f"longwave animate: interrupted ({path} was not written)\n"
    assert [file.name for file in tmp_path.iterdir()] == ["run.nc"]


def test_a_long_film_is_announced(
    finished_run: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    announced: list[float] = []
    monkeypatch.setattr(animation, "FRAME_SECONDS", 1e9)
    animate(finished_run, tmp_path / "film.gif", dpi=40, announce=announced.append)
    assert announced
    assert announced[-1] > 1e6


@pytest.mark.slow
def test_on_two_axes_a_film_is_made_of_maps(tmp_path: Path) -> None:
    lump = load_scene("square_lump").changed(half_width=2.0, tolerance=1e-2)
    path = tmp_path / "film.gif"
    assert animate(lump, path, duration=0.4, fps=10.0, dpi=40.0) == frames_of(path) == 4


def test_a_chain_on_a_bench_is_shown_with_its_energy(tmp_path: Path) -> None:
    scene = load_scene("struck_grains").changed(times=[0, 10], tolerance=1e-4)
    path = tmp_path / "film.gif"
    assert animate(scene, path, duration=1.0, fps=6.0, dpi=40.0) == frames_of(path) == 6
    data = scene_run.run(scene.changed(observables={"state": True, "energy": True}))
    film = film_of(bench_frames(data))
    film.frame(1)
    np.testing.assert_array_equal(film._beads.get_ydata(), data.displacement[1])  # type: ignore[attr-defined]
    assert film._text.get_text() == "$t = 10$\nenergy 0.005"
    with pytest.raises(ValueError, match="source must hold the energy of all cells"):
        animate(data.drop_vars("energy"), path)
