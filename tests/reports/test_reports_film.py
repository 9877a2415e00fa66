"""Films: frames show the snapshots, files hold all frames, and no partial file remains."""

import shutil
import signal
import stat
import subprocess
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from PIL import Image

from longwave.reports.pictures import film_files
from longwave.reports.pictures.film import ChainFilm, PlaneFilm
from longwave.reports.pictures.film_files import film_path, has_ffmpeg, save_film
from longwave.reports.pictures.style import styled

OFFSET = np.arange(-20.0, 21.0)
ERRORS = np.array([0.0, 0.1, np.nan, 0.3])
NEED_FFMPEG = pytest.mark.skipif(not has_ffmpeg(), reason="there is no ffmpeg")


@pytest.fixture(autouse=True)
def _style() -> Iterator[None]:
    with styled():
        yield


def bump(height: float) -> np.ndarray:
    return height * np.exp(-((OFFSET / 4.0) ** 2))


def placed_run(strain: np.ndarray, wave: np.ndarray, errors: np.ndarray, *axes: str) -> xr.Dataset:
    over = ("time", *axes)
    data = {"strain": (over, strain), "analytic": (over, wave), "error": ("time", errors)}
    places = {"time": np.arange(float(len(errors))), **dict.fromkeys(axes, OFFSET)}
    offset = {"offset": (over[:2], np.tile(OFFSET, (len(errors), 1)))}
    return xr.Dataset(data, {**places, **offset}, {"wave": "wave"})


def chain(count: int = 4, title: str = "A bump", dpi: float = 40.0) -> ChainFilm:
    strain, wave = (np.array([bump(t + add) for t in range(count)]) for add in (1.0, 0.5))
    return ChainFilm(placed_run(strain, wave, ERRORS[:count], "site"), title, dpi)


def plane() -> PlaneFilm:
    values = np.array([np.outer(bump(t + 1.0), bump(1.0)) for t in range(3)])
    return PlaneFilm(placed_run(values, 0.9 * values, ERRORS[:3], "site", "row"), "A bump", 40.0)


def test_a_frame_shows_the_lattice_the_wave_and_the_time_of_its_place() -> None:
    film = chain()
    film.frame(3)
    upper = film._ax
    lattice, wave = upper.lines
    assert np.array_equal(lattice.get_ydata(), bump(4.0))
    assert np.array_equal(wave.get_ydata(), bump(3.5))
    assert upper.texts[0].get_text() == "$t = 3.0$\nerror 0.300"
    assert upper.get_ylim()[1] > 4.0
    assert film._past.get_xydata().tolist()[:2] == [[0.0, 0.0], [1.0, 0.1]]
    assert film._now.get_xydata().tolist() == [[3.0, 0.3]]


def test_frames_do_not_depend_on_those_shown_before() -> None:
    film, again = chain(), chain()
    for place in (0, 3, 1):
        film.frame(place)
    assert np.array_equal(film.frame(2), again.frame(2))
    assert not np.array_equal(film.frame(2), film.frame(3))


def test_a_frame_is_what_the_figure_is_when_drawn_at_once() -> None:
    film = chain()
    quick = film.frame(2).astype(int)
    for artist in film._moving:
        artist.set_animated(False)
    film._agg.draw()
    whole = np.asarray(film._agg.buffer_rgba())[:, :, :3].astype(int)
    assert np.mean(np.abs(quick - whole).max(axis=2) > 64) < 2e-3


def test_on_two_axes_map_and_contours_are_those_of_the_frame() -> None:
    film = plane()
    film.frame(2)
    assert np.array_equal(film._mesh.get_array(), film._strain[2].T)
    top = max(path.vertices[:, 0].max() for path in film._lines.get_paths() if len(path.vertices))
    film.frame(0)
    assert len(film._ax.collections) == 2
    assert max(p.vertices[:, 0].max() for p in film._lines.get_paths() if len(p.vertices)) < top


@pytest.mark.parametrize("values", [np.zeros(41), np.full(41, 1e300), np.full(41, -3.0)])
def test_constant_fields_and_one_snapshot_make_a_film(values: np.ndarray) -> None:
    one_snapshot = placed_run(values[None], values[None], np.array([np.nan]), "site")
    film = ChainFilm(one_snapshot, "50 % of $x_ [/nope] \\frac{", 40.0)
    assert film.frame(0).ndim == 3


def test_a_gif_holds_all_frames_with_white_paper_for_the_whole_time(tmp_path: Path) -> None:
    path, shares = tmp_path / "film.gif", []
    save_film(chain(), path, 30.0, shares.append)
    with Image.open(path) as image:
        assert image.n_frames == 4
        durations = []
        for place in range(4):
            image.seek(place)
            durations.append(image.info["duration"])
            assert image.convert("RGB").getpixel((1, 1)) == (255, 255, 255)
    assert durations == [30, 40, 30, 30]
    assert shares == [0.25, 0.5, 0.75, 1.0]
    first = path.read_bytes()
    save_film(chain(), path, 30.0)
    assert path.read_bytes() == first


@NEED_FFMPEG
def test_an_mp4_holds_all_frames(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    save_film(chain(dpi=41.0), path, 10.0)
    output = subprocess.run(
        ["ffprobe", "-v", "error", "-count_frames", "-show_entries",
         "stream=nb_read_frames,r_frame_rate", "-of", "csv=p=0", str(path)],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert output.stdout.strip() == "10/1,4"


class Interrupted(ChainFilm):
    """A film whose frames are interrupted by Ctrl-C."""

    def frame(self, place: int) -> np.ndarray:
        if place == 2 and getattr(self, "begun", False):
            raise KeyboardInterrupt
        self.begun = True
        return super().frame(place)


@pytest.mark.parametrize("suffix", [".gif", pytest.param(".mp4", marks=NEED_FFMPEG)])
def test_ctrl_c_leaves_the_older_file_and_nothing_else(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"film{suffix}"
    path.write_bytes(b"older")
    film = chain()
    film.__class__ = Interrupted
    with pytest.raises(KeyboardInterrupt):
        save_film(film, path, 10.0)
    assert [(file.name, file.read_bytes()) for file in tmp_path.iterdir()] == [
        (path.name, b"older")
    ]


def test_the_message_of_a_failing_ffmpeg_is_one_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "bin" / "ffmpeg"
    program.parent.mkdir()
    program.write_text("#!/bin/sh\necho 'No such codec' >&2\nexit 1\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", f"{program.parent}:/usr/bin:/bin")
    assert shutil.which("ffmpeg") == str(program)
    with pytest.raises(OSError, match=r"film\.mp4: .*No such codec$"):
        save_film(chain(), tmp_path / "film.mp4", 10.0)
    assert not list(tmp_path.glob("*.mp4"))


@pytest.fixture
def begun(monkeypatch: pytest.MonkeyPatch) -> list[subprocess.Popen[bytes]]:
    """Return the list of processes that the test starts."""
    found: list[subprocess.Popen[bytes]] = []
    start = subprocess.Popen

    def noted(*words: Any, **settings: Any) -> subprocess.Popen[bytes]:
        found.append(start(*words, **settings))
        return found[-1]

    monkeypatch.setattr(subprocess, "Popen", noted)
    return found


@NEED_FFMPEG
def test_ctrl_c_while_ffmpeg_starts_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, begun: list[subprocess.Popen[bytes]]
) -> None:
    start = subprocess.Popen

    def pressed(*words: Any, **settings: Any) -> Any:
        encoder = start(*words, **settings)
        signal.raise_signal(signal.SIGINT)
        time.sleep(0.2)  # time for the press to come where it comes
        return encoder

    monkeypatch.setattr(subprocess, "Popen", pressed)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # of a job in the background
    try:
        with pytest.raises(KeyboardInterrupt):
            save_film(chain(), tmp_path / "film.mp4", 10.0)
    finally:
        signal.signal(signal.SIGINT, before)
    assert begun[0].returncode == -signal.SIGKILL
    assert not list(tmp_path.iterdir())


@NEED_FFMPEG
def test_ctrl_c_before_ffmpeg_is_known_to_run_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, begun: list[subprocess.Popen[bytes]]
) -> None:
    class Interrupted(ThreadPoolExecutor):
        def submit(self, *call: Any, **named: Any) -> Any:
            super().submit(*call, **named)
            raise KeyboardInterrupt

    monkeypatch.setattr(film_files, "ThreadPoolExecutor", Interrupted)
    with pytest.raises(KeyboardInterrupt):
        save_film(chain(), tmp_path / "film.mp4", 10.0)
    assert begun[0].returncode == -signal.SIGKILL
    assert not list(tmp_path.iterdir())


def test_without_ffmpeg_a_gif_is_the_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(ValueError, match=r"got 'run\.mp4' \(take 'run\.gif', or install ffmpeg\)$"):
        film_path("run.mp4")
    assert film_path("run.GIF") == Path("run.GIF")


def test_a_gif_that_does_not_fit_the_memory_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("longwave.reports.pictures.film_files.MAX_GIF_PIXELS", 1e4)
    with pytest.raises(ValueError, match=r"^a GIF must have at most 1e\+04 pixels"):
        save_film(chain(), tmp_path / "film.gif", 10.0)
    assert not list(tmp_path.iterdir())
