"""`python -m reports.figures FILE`: draw the README's figure, the third-order rational wave."""

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from matplotlib.figure import Figure

from derive.command_line import OneLineParser, fail, interrupted
from reports.figures.drawing import save, snapshot_figure, styled
from reports.figures.paper import snapshots
from verify.comparison import load_scene, run

SCENE = "rational_3_eps_0.05"
HALF_WIDTH = 120


def main(argv: Sequence[str] | None = None) -> int:
    """Run the scene and write its figure; return the exit status."""
    parser = OneLineParser(prog="python -m reports.figures", description=__doc__)
    parser.add_argument("file", type=Path, help="the picture to write: .png, .pdf or .svg")
    path = parser.parse_args(argv).file
    try:
        with styled():
            save(readme_figure(), path)
    except KeyboardInterrupt:
        return interrupted("python -m reports.figures", f"{path} was not written")
    except (OSError, ValueError) as error:
        return fail(error)
    return 0


def readme_figure() -> Figure:
    """Run the scene for its snapshots alone and draw them."""
    scene = replace(load_scene(SCENE), observables=("strain",))
    return snapshot_figure([list(snapshots(run(scene), scene, HALF_WIDTH))])


if __name__ == "__main__":
    sys.exit(main())
