"""``longwave fit``: a force law from measured points, or a scene's constants from sensors' records.

What is fitted is printed, written as a lattice, and a law drawn.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from longwave.derive.intervals import WIDE, rounded
from longwave.scenes.description.scene_file import toml_text
from longwave.scenes.fits.force_data import read_force
from longwave.scenes.fits.force_fit import AS_GOOD, ForceFit, fit_points
from longwave.scenes.fits.force_law import stated_law
from longwave.scenes.fits.least_squares import LeastSquares, probability
from longwave.scenes.fits.residual_tests import EVEN, ODD, SERIAL, SMOOTH
from longwave.scenes.fits.scene_fit import LAGS, SceneFit, fit_scene
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

TESTED = {ODD: "the term", EVEN: "the term", SMOOTH: "smooth curves to", SERIAL: "neighbours"}
"""Words for what residuals are tested against, by the kind of the test."""

MOST_ACROSS = 6
"""Constants of which all correlations are told."""


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
    """Fit, print, and write what is asked for; return the exit status 0.

    Raises ValueError for wrong input.
    """
    check_output(output, "chain.toml", suffixes=(".toml",), force=force, read=(points,))
    read = (points, output or points)
    check_output(plot, "fit.png", suffixes=SUFFIXES, force=force, option="--plot", read=read)
    found = fit_points(read_force(points, units), stated_law(law, fixed))
    name = "the standard input" if points == STANDARD_INPUT else on_one_line(Path(points).name)
    where = f"{found.data.stretch.size} points of {name}{' in m and N' if units else ''}"
    if output is not None:
        text = lattice_text(found, where)
        write_atomically(output, lambda draft: draft.write_text(text, encoding="utf-8"))
    if plot is not None:
        from longwave.reports.pictures.force_picture import force_figure
        from longwave.reports.pictures.style import save, styled

        with styled():
            save(force_figure(found, where), Path(plot))
    if json_wanted:
        print_json(fit_data(found))
    else:
        print_fit(found, where)
    return 0


def lattice_text(found: ForceFit, where: str) -> str:
    """The lattice file of a fit, with what it comes from as comments."""
    told = [f"force law of {where}", *_judgement(found), *_warnings(found)]
    told.append("masses = [1]: put there what a cell weighs, in quotes")
    return "\n".join([*(f"# {line}" for line in told), toml_text(found.document())])


def fit_data(found: ForceFit) -> dict[str, Any]:
    """The fit as JSON-ready data."""
    return {
        "law": found.law.text,
        **_constants_data(found, found.law.free),
        "points": found.data.stretch.size,
        "degrees_of_freedom": found.degrees,
        "noise": float(found.errors[0]) if found.data.deviation is None else None,
        "chi_squared": found.chi_squared if found.data.deviation is not None else None,
        "p_value": None if math.isnan(found.p_value) else found.p_value,
        "smooth_p_value": None if math.isnan(found.smooth_p_value) else found.smooth_p_value,
        "residual_tests": [
            {"kind": test.kind, "seeks": test.seeks, "p_value": test.p_value}
            for test in found.tests
            if not math.isnan(test.p_value)
        ],
        "aicc": dict(found.evidence),
        "warnings": _warnings(found),
    }


def _constants_data(found: LeastSquares, names: Sequence[object]) -> dict[str, Any]:
    values = zip(names, found.values.tolist(), found.deviations.tolist(), strict=True)
    return {
        "constants": {str(name): {"value": v, "deviation": sd} for name, v, sd in values},
        "covariance": found.covariance.tolist(),
    }


def print_fit(found: ForceFit, where: str) -> None:
    """Print the constants and how well the law describes the points."""
    print_lines(plain_console(), [f"F(x) = {found.law.text}, fitted to {where}"])
    _print_constants(found, found.law.free)
    print_lines(plain_console(), [*_evidence(found), *_judgement(found), *_warnings(found)])


def _print_constants(found: LeastSquares, free: Sequence[object]) -> None:
    """Print a table of the constants with intervals and correlations."""
    names = [str(name) for name in free]
    across = [f"with {name}" for name in names] if 1 < len(names) <= MOST_ACROSS else []
    table = Table("constant", "value", "95 % interval", *across)
    rows = zip(names, found.values, found.deviations, found.correlations, strict=True)
    for name, value, deviation, correlations in rows:
        low, high = (rounded(value + sign * WIDE * deviation, deviation) for sign in (-1, 1))
        shown = [f"{entry:.2f}" for entry in correlations] if across else []
        figures = (
            f"{rounded(value, deviation)} +- {rounded(deviation, deviation)}",
            f"{low} .. {high}",
        )
        table.add_row(name, *figures, *shown)
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
    """Fit a scene's constants to records, print, and write a lattice file if asked; return 0.

    Raises ValueError for wrong input.
    """
    check_output(output, "chain.toml", suffixes=(".toml",), force=force, read=(*records, scene))
    found = fit_scene(scene, records, [name.strip() for name in free.split(",") if name.strip()])
    names = ", ".join(on_one_line(Path(record).name) for record in records)
    where = f"{found.residuals.size} readings of {names}"
    told = [*_judgement_of_scene(found), *_warnings(found)]
    if output is not None:
        values = zip(found.names, found.values, found.deviations, strict=True)
        lost = [
            f"{name} = {rounded(value, sd)} +- {rounded(sd, sd)}: belongs into the scene"
            for name, value, sd in values
            if name not in found.document()["constants"]
        ]
        head = [f"# {line}" for line in (f"fitted to {where}", *told, *lost)]
        text = "\n".join([*head, toml_text(found.document())])
        write_atomically(output, lambda draft: draft.write_text(text, encoding="utf-8"))
    if json_wanted:
        data = {
            **_constants_data(found, found.names),
            "readings": found.residuals.size,
            "degrees_of_freedom": found.degrees,
            "noise": found.noise,
            "chi_squared": found.chi_squared if found.has_deviations else None,
            "p_value": found.p_value if found.has_deviations else None,
            "serial_p_value": found.serial_p_value,
            "warnings": _warnings(found),
        }
        print_json(data)
        return 0
    print_lines(plain_console(), [f"{found.model.scene.name}, fitted to {where}"])
    _print_constants(found, found.names)
    print_lines(plain_console(), told)
    return 0


def _judgement_of_scene(found: SceneFit) -> Iterator[str]:
    yield _size(found, "a reading", found.noise)
    serial = probability(found.serial_p_value)
    yield f"residuals against those up to {LAGS} readings later: {serial}"


def _evidence(found: ForceFit) -> Iterator[str]:
    """How the order was chosen, if it was."""
    if found.evidence:
        least = min(value for _, value in found.evidence)
        above = ", ".join(f"{names} {value - least:.1f}" for names, value in found.evidence)
        yield f"AICc above the least: {above}; the fewest constants within {AS_GOOD:g} are taken"
        if found.widening.max() > 1.0:
            yield "the deviations include those of the other laws, weighted by exp(-AICc/2)"


def _judgement(found: ForceFit) -> Iterator[str]:
    yield _size(found, "a point", None if found.has_deviations else float(found.errors[0]))
    told = [
        f"{TESTED[test.kind]} {test.seeks}, {probability(test.p_value)}"
        for test in found.tests
        if not math.isnan(test.p_value)
    ]
    if told:
        yield f"residuals against {'; '.join(told)}"


def _size(found: LeastSquares, point: str, noise: float | None) -> str:
    """How large residuals are, against what was measured or by themselves."""
    degrees = f"{found.degrees} degrees of freedom"
    if noise is not None:
        return f"noise of {point} {noise:.3g}, from the residuals; {degrees}"
    each, p_value = found.chi_squared / found.degrees, probability(found.p_value)
    return f"chi^2 {found.chi_squared:.4g} for {degrees}, {each:.3g} each, {p_value}"


def _warnings(found: ForceFit | SceneFit) -> list[str]:
    return [f"warning: {doubt}" for doubt in found.doubts]
