"""Writing a film: MP4 by ffmpeg, GIF by Pillow, the same bytes for the same frames.

A file appears when it is whole; Ctrl-C, a full disk or a failing ffmpeg leave none.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import chain
from pathlib import Path
from typing import IO, Any

import numpy as np
from PIL import Image as PillowImage

from longwave.reports.pictures.film import Film, Image
from longwave.support.atomic_file import write_atomically

SUFFIXES = (".mp4", ".gif")
"""File suffixes with which a film can be written."""

GIF_COLOURS = 64
"""Number of colours of a GIF: enough for lines in four colours with smooth edges, or a map."""

MIN_WHITE = 246
"""Least value, 0 to 255, of red, green and blue of a colour that is replaced by white."""

PALETTE_FRAMES = 5
"""Number of frames from which the colours of a GIF are taken."""

MAX_GIF_PIXELS = 4e8
"""Largest number of pixels in all frames of a GIF; they are all in memory, one byte each."""

Show = Callable[[float], object]
"""Progress callback, called with the fraction of frames that are written."""


def has_ffmpeg() -> bool:
    """Return whether ffmpeg, which writes MP4, is installed."""
    return shutil.which("ffmpeg") is not None


def film_path(output: str | Path) -> Path:
    """Return ``output`` as a path; ValueError with a remedy if such a film cannot be written."""
    path = Path(output)
    if path.suffix.lower() not in SUFFIXES:
        got = f"{path.name!r} (such as 'run.gif')"
        raise ValueError(f"output must be a path ending in {', '.join(SUFFIXES)}, got {got}")
    if path.suffix.lower() == ".mp4" and not has_ffmpeg():
        got = f"{path.name!r} (take '{path.with_suffix('.gif').name}', or install ffmpeg)"
        raise ValueError(f"output must end in .gif where there is no ffmpeg, got {got}")
    return path


def save_film(film: Film, path: Path, fps: float, show: Show = lambda _: None) -> None:
    """Write a film to a path, as MP4 or GIF by its suffix.

    ``show`` is called with the fraction of frames that are written. Raises OSError if the file
    cannot be written, ValueError for a GIF that does not fit into memory.
    """
    write = _write_gif if path.suffix.lower() == ".gif" else _write_mp4
    write_atomically(path, lambda draft: write(film, draft, fps, show))


def _frames(film: Film, show: Show) -> Iterator[Image]:
    for index in range(len(film)):
        yield film.frame(index)
        show((index + 1) / len(film))


def _write_gif(film: Film, path: Path, fps: float, show: Show) -> None:
    samples = [film.frame(p) for p in np.linspace(0, len(film) - 1, PALETTE_FRAMES).astype(int)]
    pixels = len(film) * samples[0].shape[0] * samples[0].shape[1]
    if pixels > MAX_GIF_PIXELS:
        raise ValueError(
            f"a GIF must have at most {MAX_GIF_PIXELS:.0e} pixels in all frames, got {pixels:.1e} "
            "(take fewer dpi, frames a second or seconds, or write MP4)"
        )
    colours = _palette(np.concatenate(samples))
    none = PillowImage.Dither.NONE
    images = (
        PillowImage.fromarray(image).quantize(palette=colours, dither=none)
        for image in _frames(film, show)
    )
    first = next(images)
    first.save(
        path, "GIF", save_all=True, append_images=images, loop=0, disposal=1,
        duration=frame_milliseconds(len(film), fps),
    )  # fmt: skip


def _palette(pixels: Image) -> PillowImage.Image:
    """Return an image with a palette for a GIF: the colours of these pixels, near-white made white.

    Pillow maps colours to the palette with an error of a few units, so a white background could
    become any near-white colour.
    """
    image = PillowImage.fromarray(pixels).quantize(GIF_COLOURS)
    colours = np.array(image.getpalette()).reshape(-1, 3)
    colours[colours.min(axis=1) >= MIN_WHITE] = 255
    image.putpalette(colours.ravel().tolist())
    return image


def frame_milliseconds(count: int, fps: float) -> list[int]:
    """Return how long each frame of a GIF stays, in multiples of 10 ms, the unit of the format.

    The rounding errors do not add up over the film.

    >>> frame_milliseconds(4, 30.0)
    [30, 40, 30, 30]
    """
    ends = np.rint(100.0 * np.arange(count + 1) / fps).astype(int)
    return [10 * max(1, int(step)) for step in np.diff(ends)]


def _write_mp4(film: Film, path: Path, fps: float, show: Show) -> None:
    frames = _frames(film, show)
    first = next(frames)
    height, width, _ = first.shape
    command = [
        "ffmpeg", "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24",
        "-s", f"{width}x{height}", "-r", f"{fps:.6g}", "-i", "-", "-an",
        "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white", "-pix_fmt", "yuv420p",
        "-fflags", "+bitexact", "-flags:v", "+bitexact", "-movflags", "+faststart",
        "-f", "mp4", str(path),
    ]  # fmt: skip
    with tempfile.TemporaryFile() as messages, ThreadPoolExecutor(1) as pool:
        processes: list[subprocess.Popen[bytes]] = []

        def start_encoder() -> None:  # in its own session: Ctrl-C reaches only this process
            streams = {"stdin": subprocess.PIPE, "stdout": messages, "stderr": messages}
            options: Any = streams | {"start_new_session": True}
            processes.append(subprocess.Popen(command, **options))

        try:
            # In a thread, as Ctrl-C within Popen would lose the running ffmpeg.
            pool.submit(start_encoder).result()
            _feed(processes[0], chain([first], frames))
            status = processes[0].wait()
        except BaseException:
            pool.shutdown()
            for encoder in processes:
                encoder.kill()
                encoder.communicate()
            raise
        if status != 0:
            raise OSError(f"ffmpeg could not write it: {_last_line(messages)}")


def _feed(encoder: subprocess.Popen[bytes], frames: Iterator[Image]) -> None:
    """Write the frames to ffmpeg's input; stop without an error if ffmpeg has ended."""
    assert encoder.stdin is not None
    try:
        with encoder.stdin as pipe:
            for image in frames:
                pipe.write(image.tobytes())
    except BrokenPipeError:
        return


def _last_line(messages: IO[bytes]) -> str:
    messages.seek(0)
    lines = messages.read().decode(errors="replace").split("\n")
    return next((line for line in reversed(lines) if line.strip()), "it ended without a message")
