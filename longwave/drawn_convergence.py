"""The convergence of a scene as a session in Python has it: measured with progress, and drawn."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from longwave.cli.converge import convergence_figure
from longwave.reports.pictures.shown import ShownFigure
from longwave.reports.pictures.style import save, styled
from longwave.scenes.convergence import SceneConvergence, scene_convergence
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.session import Told, shown_progress
from longwave.support.console import picture_path


class Convergence(SceneConvergence):
    """The errors of a scene at several eps and their rate, which can be drawn."""

    def plot(self, output: str | Path | None = None) -> ShownFigure:
        """Draw the errors over eps; write the figure to ``output`` (PNG, PDF, SVG) if given."""
        path = None if output is None else picture_path(output)
        with styled():
            figure = convergence_figure(self)
            if path is not None:
                save(figure, path)
        return figure


def converge(
    scene: Scene | str | Path,
    eps: Sequence[float] = (),
    tolerance: float | None = None,
    progress: Told | None = None,
) -> Convergence:
    """Run a scene at several eps and fit the rate at which lattice and wave come together.

    Without ``eps`` at four values about the scene's own. Raises ValueError in one line as
    `scenes.convergence.scene_convergence` does.
    """
    asked = scene if isinstance(scene, Scene) else load_scene(scene)
    if tolerance is not None:
        asked = asked.with_tolerance(tolerance)
    with shown_progress(asked.name, progress, None) as (share, tell):
        found = scene_convergence(asked, eps, share, tell or (lambda _: None))
    return Convergence(**vars(found))
