"""The paper's figures: the scenes that each shows, and functions that draw them from runs."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from matplotlib.figure import Figure

from longwave.reports.pictures.drawing import error_panels, snapshot_panels
from longwave.reports.pictures.error_curve import ErrorCurve
from longwave.reports.pictures.run_data import snapshots
from longwave.reports.pictures.style import page_width
from longwave.support.labelled_arrays import Labelled


@dataclass(frozen=True)
class SnapshotFigure:
    """A figure of the paper with one row of panels for each scene.

    ``half_width`` is the number of sites to either side of the one nearest to c t; ``label`` is
    the figure's label in the paper.
    """

    name: str
    label: str
    scenes: tuple[str, ...]
    half_width: int


@dataclass(frozen=True)
class ErrorFigure:
    """A figure of error curves: for each panel its title and (curve label, scene) pairs."""

    name: str
    label: str
    panels: tuple[tuple[str, tuple[tuple[str, str], ...]], ...]


SNAPSHOT_FIGURES = tuple(
    SnapshotFigure(name, label, tuple(scenes.split()), half_width)
    for name, label, scenes, half_width in (
        ("rational_2", "Second-order solns comparison",
         "rational_2_eps_0.05 rational_2_eps_0.075", 120),
        ("rational_3", "Third-order solns comparison",
         "rational_3_eps_0.05 rational_3_eps_0.075", 120),
        ("breather_sn", "dark-breather on dn-background", "breather_sn_k_0.7", 300),
        ("soliton_dn", "soliton solution on the dn-wave background", "soliton_dn_k_0.7", 300),
        ("rogue_cn", "rogue-wave on cn-background comparison", "rogue_cn_k_0.5", 300),
    )
)  # fmt: skip

_RATIONAL_PANELS = tuple(
    (title, tuple((f"$Y_{j}$", f"rational_{j}_eps_{eps}") for j in (2, 3)))
    for title, eps in ((r"(A)  $\epsilon=0.05$", "0.05"), (r"(B)  $\epsilon=0.075$", "0.075"))
)
_BREATHER_CURVES = tuple((f"$k={k}$", f"breather_sn_k_{k}") for k in ("0.5", "0.6", "0.7"))
ERROR_FIGURES = (
    ErrorFigure("rational_errors", "L_inf loss plot", _RATIONAL_PANELS),
    ErrorFigure(
        "breather_errors", "DB error plot", ((r"dark breather, $\epsilon=0.05$", _BREATHER_CURVES),)
    ),
)


def paper_figures(runs: Mapping[str, Labelled]) -> Iterator[tuple[str, Figure]]:
    """Yield the name of every figure of the paper and the figure, drawn from its scenes' runs."""
    for figure in SNAPSHOT_FIGURES:
        rows = [snapshots(runs[name], figure.half_width) for name in figure.scenes]
        yield figure.name, snapshot_panels(rows).figure()
    for curves in ERROR_FIGURES:
        panels = {
            title: {label: ErrorCurve.of(runs[name], "error_curve") for label, name in pairs}
            for title, pairs in curves.panels
        }
        width = page_width() if len(panels) > 1 else 0.5 * page_width()
        yield curves.name, error_panels(panels).figure(width)
