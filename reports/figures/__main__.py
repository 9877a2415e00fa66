"""`python -m reports.figures FILE`: draw the README's figure, the third-order rational wave."""

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import click
from matplotlib.figure import Figure

from derive.command_line import called_by, fail, interrupted, run_words
from reports.figures.drawing import save, snapshot_figure, styled
from reports.figures.paper_figures import snapshots
from verify.comparison import load_scene, run

SCENE = "rational_3_eps_0.05"
HALF_WIDTH = 120


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
def figure(file: Path) -> int:
    """Draw the README's figure, the third-order rational wave, as .png, .pdf or .svg."""
    try:
        with styled():
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


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit status."""
    return run_words(figure, "python -m reports.figures", argv)


if __name__ == "__main__":
    sys.exit(main())
