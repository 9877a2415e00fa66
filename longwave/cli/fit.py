"""``longwave fit``: a force law from measured points, or a scene's constants from sensor records.

The result is printed and written as a lattice file; a law can be drawn.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from longwave.derive.intervals import HALF_WIDTH, rounded
from longwave.scenes.description.scene_file import toml_text
from longwave.scenes.fits.force_data import read_force
from longwave.scenes.fits.force_fit import AICC_MARGIN, ForceFit, fit_points
from longwave.scenes.fits.force_law import stated_law
from longwave.scenes.fits.least_squares import LeastSquares, probability
from longwave.scenes.fits.residual_tests import EVEN, ODD, SERIAL, SMOOTH
from longwave.scenes.fits.scene_fit import MAX_LAG, SceneFit, fit_scene
from longwave.support.atomic_file import write_atomically
from longwave.support.console import (
    SUFFIXES,
    check_output,
    plain_console,
    print_json,
    print_lines,
    table_console,
)
from longwave.support.user_files import STANDARD_INPUT, on_one_line

TEST_WORDS = {ODD: "the term", EVEN: "the term", SMOOTH: "smooth curves to", SERIAL: "neighbours"}
"""Kind of residual test -> words printed before `seeks`, the text on what the test looks for."""

MAX_CORRELATIONS = 6
"""Largest number of constants for which the table has columns of correlations."""


def fit_and_print(
    points: str,
    *,
    law: str | None,
    fixed: Mapping[str, str],
    units: str | None,
    output: str | None,
    plot: str | None,
    force: bool,
    json_wanted: bool,
) -> int:
    """Fit a force law, print it and write the requested files; ValueError for wrong input."""
    check_output(output, "chain.toml", suffixes=(".toml",), force=force, read=(points,))
    inputs = (points, output or points)
    check_output(plot, "fit.png", suffixes=SUFFIXES, force=force, option="--plot", read=inputs)
    fit = fit_points(read_force(points, units), stated_law(law, fixed))
    name = "the standard input" if points == STANDARD_INPUT else on_one_line(Path(points).name)
    origin = f"{fit.data.stretch.size} points of {name}{' in m and N' if units else ''}"
    if output is not None:
        comments = [f"force law of {origin}", *_quality_lines(fit), *_warnings(fit)]
        comments.append("masses = [1]: replace 1 by the mass of a cell, in quotes")
        _write_lattice(output, fit, comments)
    if plot is not None:
        from longwave.reports.pictures.force_picture import force_figure
        from longwave.reports.pictures.style import save, styled

        with styled():
            save(force_figure(fit, origin), Path(plot))
    if json_wanted:
        print_json(fit_data(fit))
    else:
        print_fit(fit, origin)
    return 0


def _write_lattice(output: str, fit: ForceFit | SceneFit, comments: Sequence[str]) -> None:
    """Write a fit's lattice file, with the comments at its beginning."""
    text = "\n".join([*(f"# {line}" for line in comments), toml_text(fit.document())])
    write_atomically(output, lambda draft: draft.write_text(text, encoding="utf-8"))


def fit_data(fit: ForceFit) -> dict[str, Any]:
    """Return the fit as JSON-ready data."""
    return {
        "law": fit.law.text,
        **_constants_data(fit, fit.law.free),
        "points": fit.data.stretch.size,
        "degrees_of_freedom": fit.degrees,
        "noise": float(fit.errors[0]) if fit.data.deviation is None else None,
        "chi_squared": fit.chi_squared if fit.data.deviation is not None else None,
        "p_value": None if math.isnan(fit.p_value) else fit.p_value,
        "smooth_p_value": None if math.isnan(fit.smooth_p_value) else fit.smooth_p_value,
        "residual_tests": [
            {"kind": test.kind, "seeks": test.seeks, "p_value": test.p_value}
            for test in fit.tests
            if not math.isnan(test.p_value)
        ],
        "aicc": dict(fit.evidence),
        "warnings": _warnings(fit),
    }


def _constants_data(fit: LeastSquares, names: Sequence[object]) -> dict[str, Any]:
    values = zip(names, fit.values.tolist(), fit.deviations.tolist(), strict=True)
    return {
        "constants": {
            str(name): {"value": value, "deviation": deviation} for name, value, deviation in values
        },
        "covariance": fit.covariance.tolist(),
    }


def print_fit(fit: ForceFit, origin: str) -> None:
    """Print the constants and how well the law describes the points."""
    print_lines(plain_console(), [f"F(x) = {fit.law.text}, fitted to {origin}"])
    _print_constants(fit, fit.law.free)
    print_lines(plain_console(), [*_order_lines(fit), *_quality_lines(fit), *_warnings(fit)])


def _print_constants(fit: LeastSquares, free: Sequence[object]) -> None:
    """Print a table of the constants with intervals and correlations."""
    names = [str(name) for name in free]
    others = names if 1 < len(names) <= MAX_CORRELATIONS else []
    table = Table("constant", "value", "95 % interval", *(f"with {name}" for name in others))
    rows = zip(names, fit.values, fit.deviations, fit.correlations, strict=True)
    for name, value, deviation, correlations in rows:
        low, high = (rounded(value + side * HALF_WIDTH * deviation, deviation) for side in (-1, 1))
        measured = f"{rounded(value, deviation)} +- {rounded(deviation, deviation)}"
        cells = (f"{entry:.2f}" for entry in (correlations if others else ()))
        table.add_row(name, measured, f"{low} .. {high}", *cells)
    table_console().print(table)


def fit_scene_and_print(
    records: Sequence[str],
    scene: str,
    free: str,
    *,
    output: str | None,
    force: bool,
    json_wanted: bool,
) -> int:
    """Fit a scene's constants, print, write a lattice file if asked; ValueError for wrong input."""
    check_output(output, "chain.toml", suffixes=(".toml",), force=force, read=(*records, scene))
    fit = fit_scene(scene, records, [name.strip() for name in free.split(",") if name.strip()])
    names = ", ".join(on_one_line(Path(record).name) for record in records)
    origin = f"{fit.residuals.size} readings of {names}"
    quality = [*_scene_quality_lines(fit), *_warnings(fit)]
    if output is not None:
        values = zip(fit.names, fit.values, fit.deviations, strict=True)
        scene_constants = [
            f"{name} = {rounded(value, sd)} +- {rounded(sd, sd)}: belongs in the scene"
            for name, value, sd in values
            if name not in fit.document()["constants"]
        ]
        _write_lattice(output, fit, [f"fitted to {origin}", *quality, *scene_constants])
    if json_wanted:
        data = {
            **_constants_data(fit, fit.names),
            "readings": fit.residuals.size,
            "degrees_of_freedom": fit.degrees,
            "noise": fit.noise,
            "chi_squared": fit.chi_squared if fit.has_deviations else None,
            "p_value": fit.p_value if fit.has_deviations else None,
            "serial_p_value": fit.serial_p_value,
            "warnings": _warnings(fit),
        }
        print_json(data)
        return 0
    print_lines(plain_console(), [f"{fit.model.scene.name}, fitted to {origin}"])
    _print_constants(fit, fit.names)
    print_lines(plain_console(), quality)
    return 0


def _scene_quality_lines(fit: SceneFit) -> Iterator[str]:
    yield _residual_size(fit, "a reading", fit.noise)
    serial = probability(fit.serial_p_value)
    yield f"residuals against those up to {MAX_LAG} readings later: {serial}"


def _order_lines(fit: ForceFit) -> Iterator[str]:
    """Yield lines on how AICc chose the order of the force polynomial; none if it was given."""
    if fit.evidence:
        least = min(value for _, value in fit.evidence)
        above = ", ".join(f"{names} {value - least:.1f}" for names, value in fit.evidence)
        limit = f"{AICC_MARGIN:g}"
        yield f"AICc above the least: {above}; the fewest constants within {limit} are taken"
        if fit.widening.max() > 1.0:
            yield "the deviations include those of the other laws, weighted by exp(-AICc/2)"


def _quality_lines(fit: ForceFit) -> Iterator[str]:
    yield _residual_size(fit, "a point", None if fit.has_deviations else float(fit.errors[0]))
    tests = [
        f"{TEST_WORDS[test.kind]} {test.seeks}, {probability(test.p_value)}"
        for test in fit.tests
        if not math.isnan(test.p_value)
    ]
    if tests:
        yield f"residuals against {'; '.join(tests)}"


def _residual_size(fit: LeastSquares, point: str, noise: float | None) -> str:
    """Return a line on the residuals: chi^2, or the noise that they imply if ``noise`` is given."""
    degrees = f"{fit.degrees} degrees of freedom"
    if noise is not None:
        return f"noise of {point} {noise:.3g}, from the residuals; {degrees}"
    per_degree, p_value = fit.chi_squared / fit.degrees, probability(fit.p_value)
    return f"chi^2 {fit.chi_squared:.4g} for {degrees}, {per_degree:.3g} each, {p_value}"


def _warnings(fit: ForceFit | SceneFit) -> list[str]:
    return [f"warning: {doubt}" for doubt in fit.doubts]
