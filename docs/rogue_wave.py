"""Draw the README's figure, the third-order rational wave: ``python docs/rogue_wave.py FILE``.

A .png, .pdf or .svg file shows three moments, a .gif or .mp4 file a film of the wave.
"""

import sys
from pathlib import Path

import numpy as np

from longwave.reports.pictures.animation import film_of
from longwave.reports.pictures.drawing import snapshot_panels
from longwave.reports.pictures.film_files import SUFFIXES, film_path, save_film
from longwave.reports.pictures.run_data import snapshots
from longwave.reports.pictures.style import save, styled
from longwave.scenes import run
from longwave.scenes.description.named_scenes import load_scene

SCENE = load_scene("rational_3_eps_0.05")
OBSERVABLES = ("strain", "time_step_error", "domain_error")
"""Of the picture, which has the run's own error as a band."""

HALF_WIDTH = 120

TIMES, FRAMES, FPS, DPI = (-4000, 4000), 161, 20, 110
"""Of the film: first and last time, frames, frames a second, pixels an inch."""


def write(path: Path) -> None:
    """Run the scene for what is drawn, and write it."""
    with styled():
        if path.suffix.lower() not in SUFFIXES:
            found = run(SCENE.changed(observables=OBSERVABLES))
            save(snapshot_panels([snapshots(found, HALF_WIDTH)]).figure(), path)
            return
        times = tuple(np.linspace(*TIMES, FRAMES).tolist())
        title = "Third-order rogue wave on the FPUT lattice"
        film = film_of(
            run(SCENE.changed(title=title, snapshots=times, observables=("strain",))),
            DPI,
            HALF_WIDTH,
        )
        save_film(film, film_path(path), FPS)


if __name__ == "__main__":
    write(Path(sys.argv[1]))
