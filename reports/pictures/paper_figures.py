"""The paper's figures: which scenes each shows, and drawing them from the scenes' runs."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from longwave.reports.pictures.drawing import (
    ErrorCurve,
    Snapshot,
    error_figure,
    save,
    snapshot_figure,
    styled,
)
from longwave.scenes.scene import Scene

Runs = Mapping[str, xr.Dataset]


@dataclass(frozen=True)
class SnapshotFigure:
    """A figure of the paper with one row of panels for each scene.

    `half_width` is how many sites are shown to either side of the site nearest to c t; `label`
    is the figure's label in the paper.
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


SNAPSHOT_FIGURES = (
    SnapshotFigure(
        "rational_2",
        "Second-order solns comparison",
        ("rational_2_eps_0.05", "rational_2_eps_0.075"),
        120,
    ),
    SnapshotFigure(
        "rational_3",
        "Third-order solns comparison",
        ("rational_3_eps_0.05", "rational_3_eps_0.075"),
        120,
    ),
    SnapshotFigure("breather_sn", "dark-breather on dn-background", ("breather_sn_k_0.7",), 300),
    SnapshotFigure(
        "soliton_dn", "soliton solution on the dn-wave background", ("soliton_dn_k_0.7",), 300
    ),
    SnapshotFigure("rogue_cn", "rogue-wave on cn-background comparison", ("rogue_cn_k_0.5",), 300),
)

ERROR_FIGURES = (
    ErrorFigure(
        "rational_errors",
        "L_inf loss plot",
        tuple(
            (
                rf"({letter})  $\epsilon={eps}$",
                tuple((f"$Y_{j}$", f"rational_{j}_eps_{eps}") for j in (2, 3)),
            )
            for letter, eps in (("A", "0.05"), ("B", "0.075"))
        ),
    ),
    ErrorFigure(
        "breather_errors",
        "DB error plot",
        (
            (
                r"dark breather, $\epsilon=0.05$",
                tuple((f"$k={k}$", f"breather_sn_k_{k}") for k in ("0.5", "0.6", "0.7")),
            ),
        ),
    ),
)


def draw_all(runs: Runs, scenes: Mapping[str, Scene], folder: Path) -> Iterator[Path]:
    """Draw every figure of the paper as PDF into the folder, yielding each path when written."""
    with styled():
        for figure in SNAPSHOT_FIGURES:
            yield save(draw_snapshots(figure, runs, scenes), folder / f"{figure.name}.pdf")
        for curves in ERROR_FIGURES:
            yield save(draw_errors(curves, runs), folder / f"{curves.name}.pdf")


def draw_snapshots(figure: SnapshotFigure, runs: Runs, scenes: Mapping[str, Scene]) -> Figure:
    """Draw one snapshot figure from its runs."""
    return snapshot_figure(
        [list(snapshots(runs[name], scenes[name], figure.half_width)) for name in figure.scenes]
    )


def snapshots(run: xr.Dataset, scene: Scene, half_width: int) -> Iterator[Snapshot]:
    """Yield the run's snapshots, cut to the sites shown."""
    speed = scene.model.sound_speed()
    for time in run["time"].values:
        at = run.sel(time=time, site=slice(-half_width, half_width))
        offset = at["n"].values - speed * time
        yield Snapshot(float(time), scene.eps, offset, at["strain"].values, at["analytic"].values)


def draw_errors(figure: ErrorFigure, runs: Runs) -> Figure:
    """Draw one figure of error curves from its runs."""
    return error_figure([(title, list(_curves(pairs, runs))) for title, pairs in figure.panels])


def _curves(pairs: Iterable[tuple[str, str]], runs: Runs) -> Iterator[ErrorCurve]:
    """Yield the error curves of the (label, scene) pairs."""
    for label, name in pairs:
        curve = runs[name]["error_curve"]
        yield ErrorCurve(label, curve["curve_time"].values, curve.values)
