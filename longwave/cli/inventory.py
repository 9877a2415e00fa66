"""`longwave list`: lattices, waves, schemes, scenes and more as plain data and as tables."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from rich.table import Column, Table

from longwave.support.console import table_console

if TYPE_CHECKING:
    from longwave.solutions import ClosedForm

Record = dict[str, Any]

CACHED_KINDS = ("lattices", "waves", "lattice-scenes")
"""Kinds of `longwave list` that are cached: they take a second and depend on the sources alone."""

PIPE_WIDTH = 160
"""Width of a table if stdout is not a terminal."""


def inventory(kinds: Iterable[str]) -> dict[str, list[Record]]:
    """Return the records of each kind as numbers, texts and lists.

    >>> [record["name"] for record in inventory(["lattices"])["lattices"]][:3]
    ['fput_strain', 'next_nearest', 'next_nearest_degenerate']
    """
    from longwave.solutions import kept_data

    return {
        kind: kept_data(__name__, kind, compute) if kind in CACHED_KINDS else compute()
        for kind, compute in ((kind, _KINDS[kind].records) for kind in kinds)
    }


def lattices() -> list[Record]:
    """Return the lattices: name, title, fields, constants and the force of each bond."""
    from longwave.derive import LATTICES

    return [
        {
            "name": lattice.name,
            "title": lattice.title,
            "fields": list(lattice.fields),
            "constants": [str(constant) for constant in lattice.constants],
            "forces": [str(bond.force) for bond in lattice.bonds],
        }
        for lattice in LATTICES.values()
    ]


def waves() -> list[Record]:
    """Return the closed forms: name, title, equation, parameters, background, period, source."""
    from longwave.solutions import CATALOGUE

    return [
        {
            "name": form.name,
            "title": form.title,
            "equation": form.equation.name,
            "s": None if form.equation.free_sign else form.equation.s,
            "parameters": [{"name": p.name, "domain": p.domain} for p in form.parameters],
            "background": _background(form, CATALOGUE),
            "period": None if form.period is None else str(form.period),
            "reference": str(form.reference),
        }
        for form in CATALOGUE
    ]


def _background(form: ClosedForm, catalogue: Iterable[ClosedForm]) -> str:
    """Return the name of the closed form that equals a form's background, or else its formula."""
    for other in catalogue:
        is_bare = other.period is not None and other.background == 0  # cheap test comes first
        if is_bare and other.expression == form.background:
            return other.name
    return str(form.background)


def schemes() -> list[Record]:
    """Return the schemes: name, order, force evaluations per step, stability limit, source."""
    from longwave.lattice.schemes import SCHEMES, stability_limit

    return [
        {
            "name": scheme.name,
            "order": scheme.order,
            "forces_a_step": scheme.stages,
            "stability_limit": round(float(stability_limit(scheme)), 4),
            "reference": scheme.reference,
        }
        for scheme in SCHEMES
    ]


def scenes() -> list[Record]:
    """Return the shipped scenes: the paper's, further ones, then members of families."""
    from longwave.scenes.description import named_scenes

    folders = {"paper": named_scenes.shipped_scenes()}
    folders["further"] = named_scenes.shipped_scenes("further")
    named = ((o, named_scenes.load_scene(n)) for o, names in folders.items() for n in names)
    family = (("family", scene) for scene in named_scenes.rational_family_scenes().values())
    return [
        {
            "name": scene.name,
            "title": scene.title,
            "origin": origin,
            "wave": scene.wave_name,
            "parameters": dict(scene.parameters),
            "eps": scene.eps,
            "start": scene.t0,
            "end": scene.end,
            "tolerance": scene.tolerance,
            "scheme": scene.numerics.scheme or None,
            "step": None if scene.tolerance else scene.discretisation.step,
            "observables": list(scene.observables),
        }
        for origin, scene in (*named, *family)
    ]


def lattice_scenes() -> list[Record]:
    """Return the shipped scenes on any lattice: lattice, equation, wave, eps, order, times."""
    from longwave.scenes.description.named_scenes import load_scene, shipped_scenes
    from longwave.scenes.starts.lattice_derivation import equation_of_form
    from longwave.solutions import closed_form

    return [
        {
            "name": scene.name,
            "title": scene.title,
            "lattice": scene.lattice,
            "equation": equation_of_form(closed_form(scene.wave_name)),
            "wave": scene.wave,
            "parameters": dict(scene.parameters),
            "constants": dict(scene.constants),
            "carrier": scene.carrier or None,
            "eps": scene.eps,
            "order": scene.order,
            "slow_times": list(scene.slow_times),
            "tolerance": scene.tolerance,
        }
        for scene in map(load_scene, shipped_scenes("lattices"))
    ]


def bench_scenes() -> list[Record]:
    """Return the shipped scenes of bench chains: lattice, cells, end time, tolerance."""
    from longwave.scenes.description.named_scenes import load_scene, shipped_scenes

    return [
        {
            "name": scene.name,
            "title": scene.title,
            "lattice": scene.lattice,
            "cells": scene.own_bench.sites,
            "end": scene.end,
            "tolerance": scene.tolerance,
        }
        for scene in map(load_scene, shipped_scenes("bench"))
    ]


def sweeps() -> list[Record]:
    """Return the shipped sweeps: name, title, base scene, swept fields, number of cells."""
    from longwave.runs.sweep_file import load_sweep, shipped_sweeps

    return [
        {
            "name": sweep.name,
            "title": sweep.title,
            "scene": sweep.base,
            "fields": [field for dimension in sweep.dimensions for field in dimension.fields],
            "shape": list(sweep.shape),
            "cells": len(sweep),
        }
        for sweep in map(load_sweep, shipped_sweeps())
    ]


def observables() -> list[Record]:
    """Return the observables: name, description, and the arrays that they add to a run."""
    from longwave.scenes.observed.observables import OBSERVABLES

    return [
        {
            "name": entry.name,
            "what": entry.summary,
            "needs_ring": entry.needs_ring,
            "arrays": [variable.name for variable in entry.variables],
        }
        for entry in OBSERVABLES.values()
    ]


class _Kind(NamedTuple):
    """One kind of `longwave list`: its records, the columns of its table, and a note below it.

    A column is a format string that is filled from a record, or a function of the record.
    """

    records: Callable[[], list[Record]]
    columns: Mapping[str, str | Callable[[Record], str]]
    note: str = ""


def _plain_columns(*names: str) -> dict[str, str]:
    """Return table columns, each of which shows the entry of that name of a record unchanged."""
    return {name: f"{{{name}}}" for name in names}


def _tolerance_or_step(record: Record) -> str:
    if record["tolerance"] is not None:
        return f"to {record['tolerance']:g}"
    return f"{record['scheme']}, step {record['step']:g}"


_KINDS: Mapping[str, _Kind] = {
    "lattices": _Kind(lattices, _plain_columns("name", "title", "fields", "constants", "forces")),
    "waves": _Kind(
        waves,
        {
            "name": "{name}",
            "wave": "{title}",
            "equation": "{equation}",
            "parameters": lambda wave: ", ".join(p["domain"] for p in wave["parameters"]),
            "background": "{background}",
            "period in xi": "{period}",
        },
        "rational_<j> exists for every order j: it can be run up to 12 and proved up to 99",
    ),
    "schemes": _Kind(
        schemes,
        _plain_columns("name", "order")
        | {"forces a step": "{forces_a_step}", "stable step x frequency": "{stability_limit:.2f}"}
        | {"from": "{reference}"},
    ),
    "scenes": _Kind(
        scenes,
        _plain_columns("name", "title", "wave")
        | {"eps": "{eps:g}", "times": "{start:g} to {end:g}", "computed": _tolerance_or_step},
        "a scene of your own is a TOML file: longwave run FILE.toml",
    ),
    "lattice-scenes": _Kind(
        lattice_scenes,
        _plain_columns("name", "title", "lattice", "equation", "wave")
        | {"eps": "{eps:g}", "order": "{order}", "to": "{tolerance:g}"},
        "longwave converge NAME fits the rate at which the error falls with eps",
    ),
    "bench-scenes": _Kind(
        bench_scenes,
        _plain_columns("name", "title", "lattice")
        | {"cells": "{cells}", "until": "{end:g}", "to": "{tolerance:g}"},
        "a chain of your own is a TOML file: longwave run FILE.toml",
    ),
    "sweeps": _Kind(
        sweeps,
        _plain_columns("name", "title", "scene") | {"varied": "{fields}", "cells": "{cells}"},
        "a sweep of your own is a TOML file: longwave sweep FILE.toml",
    ),
    "observables": _Kind(
        observables,
        {
            "name": "{name}",
            "what": lambda one: one["what"] + " (on a ring only)" * one["needs_ring"],
            "arrays": "{arrays}",
        },
    ),
}


def print_tables(records_by_kind: Mapping[str, Iterable[Record]]) -> None:
    """Print a table for each kind; texts are printed without markup."""
    console = table_console(PIPE_WIDTH, highlight=False, markup=False, emoji=False)
    for kind, records in records_by_kind.items():
        columns, note = _KINDS[kind].columns, _KINDS[kind].note
        headings = [Column(name, no_wrap=name == "name") for name in columns]
        table = Table(*headings, title=kind, title_justify="left")
        for record in records:
            texts = {name: _cell_text(value) for name, value in record.items()}
            cells = (
                c.format(**texts) if isinstance(c, str) else c(record) for c in columns.values()
            )
            table.add_row(*cells)
        console.print(table)
        if note:
            console.print(note, soft_wrap=True)


def _cell_text(value: Any) -> Any:
    """Return the text of a table's entry: a list is joined by commas, None is an empty text."""
    if isinstance(value, list):
        return ", ".join(map(str, value))
    return "" if value is None else value
