"""`python -m longwave.reports.pictures FILE`: the README's figure, the third-order rational wave.

As .gif or .mp4 it is a film of how the wave rises and falls.
"""

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import click
import numpy as np
from matplotlib.figure import Figure

from longwave.reports.pictures.drawing import save, snapshot_figure, styled
from longwave.reports.pictures.film import ChainFilm, Film, FilmWords
from longwave.reports.pictures.film_files import SUFFIXES, film_path, save_film
from longwave.reports.pictures.paper_figures import snapshots
from longwave.scenes.chain.scene_run import run
from longwave.scenes.named_scenes import load_scene
from longwave.support.command_line import called_by, fail, interrupted, run_words

SCENE = "rational_3_eps_0.05"
HALF_WIDTH = 120

TIMES, FRAMES, FPS, DPI = (-4000, 4000), 161, 20, 110
"""Of the film: first and last time, frames, frames a second, pixels an inch."""


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
def figure(file: Path) -> int:
    """Draw the README's figure, the third-order rational wave, as .png, .pdf or .svg.

    As .gif or .mp4 it is a film.
    """
    try:
        with styled():
            if file.suffix.lower() in SUFFIXES:
                save_film(readme_film(), film_path(file), FPS)
            else:
                save(readme_figure(), file)
    except KeyboardInterrupt:
        return interrupted(called_by(), f"{file} was not written")
    except (OSError, ValueError) as error:
        return fail(error)
    return 0


def readme_figure() -> Figure:
    """Run the scene for its snapshots alone and draw them."""
    scene = replace(load_scene(SCENE), observables=("strain",))
    return snapshot_figure([list(snapshots(run(scene), scene, HALF_WIDTH))])


def readme_film() -> Film:
    """Run the scene for the film's frames and show them with the time and the error."""
    times = tuple(np.linspace(*TIMES, FRAMES).tolist())
    scene = load_scene(SCENE).changed(observables=("strain",), snapshots=times)
    found = run(scene)
    errors = found["error"].values
    clock = [f"$t = {t:.0f}$\nerror {error:.3f}" for t, error in zip(times, errors, strict=True)]
    words = FilmWords("Third-order rogue wave on the FPUT lattice", "mKdV wave", clock)
    frames = list(snapshots(found, scene, HALF_WIDTH))
    return ChainFilm(frames, errors, words, DPI, float(found["background"].mean()))


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit status."""
    return run_words(figure, "python -m longwave.reports.pictures", argv)


if __name__ == "__main__":
    sys.exit(main())
