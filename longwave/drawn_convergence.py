"""The result of `longwave.converge`: a convergence study with a method that draws it."""

from __future__ import annotations

from pathlib import Path

from longwave.cli.converge import convergence_figure
from longwave.reports.pictures.shown import ShownFigure
from longwave.reports.pictures.style import save, styled
from longwave.scenes.convergence import SceneConvergence
from longwave.support.console import picture_path


class Convergence(SceneConvergence):
    """Errors of a scene at several eps and their fitted rate, with a plot."""

    def plot(self, output: str | Path | None = None) -> ShownFigure:
        """Draw the errors over eps; write the figure to ``output`` (PNG, PDF, SVG) if given."""
        path = None if output is None else picture_path(output)
        with styled():
            figure = convergence_figure(self)
            if path is not None:
                save(figure, path)
        return figure
