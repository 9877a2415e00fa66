"""`python -m longwave.reports.pictures FILE`: the README's figure, the third-order rational wave.

As .gif or .mp4 it is a film of how the wave rises and falls.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import click
import numpy as np
from matplotlib.figure import Figure

from longwave.reports.pictures.animation import film_of
from longwave.reports.pictures.drawing import save, snapshot_panels, styled
from longwave.reports.pictures.film import Film
from longwave.reports.pictures.film_files import SUFFIXES, film_path, save_film
from longwave.reports.pictures.run_data import snapshots
from longwave.scenes import run
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
    scene = load_scene(SCENE).changed(observables=("strain",))
    return snapshot_panels([snapshots(run(scene), HALF_WIDTH)]).figure()


def readme_film() -> Film:
    """Run the scene for the film's frames and show them with the time and the error."""
    times = tuple(np.linspace(*TIMES, FRAMES).tolist())
    title = "Third-order rogue wave on the FPUT lattice"
    scene = load_scene(SCENE).changed(title=title, observables=("strain",), snapshots=times)
    return film_of(run(scene), DPI, HALF_WIDTH)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit status."""
    return run_words(figure, "python -m longwave.reports.pictures", argv)


if __name__ == "__main__":
    sys.exit(main())
