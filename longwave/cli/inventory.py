"""What there is, as plain data and as tables: lattices, waves, schemes, scenes, observables."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from rich.table import Column, Table

from longwave.support.console import table_console

if TYPE_CHECKING:
    from longwave.solutions import ClosedForm

Record = dict[str, Any]

SYMBOLIC = ("lattices", "waves", "lattice-scenes")
"""What follows from formulas in the sources alone, and takes a second to make."""

PIPE_WIDTH = 160
"""Columns of a table where stdout is no terminal."""


def inventory(kinds: Iterable[str]) -> dict[str, list[Record]]:
    """The records of each kind, made of numbers, text and lists alone.

    >>> [record["name"] for record in inventory(["lattices"])["lattices"]][:3]
    ['fput_strain', 'next_nearest', 'next_nearest_degenerate']
    """
    from longwave.solutions import kept_data

    return {
        kind: kept_data(__name__, kind, made) if kind in SYMBOLIC else made()
        for kind, made in ((kind, _KINDS[kind].records) for kind in kinds)
    }


def lattices() -> list[Record]:
    """The lattices: name, title, fields, constants and the force of each bond."""
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
    """The closed forms: name, title, equation, parameters with domains, background, period."""
    from longwave.solutions import CATALOGUE

    return [
        {
            "name": form.name,
            "title": form.title,
            "equation": form.equation.name,
            "s": None if form.equation.free_sign else form.equation.s,
            "parameters": [
                {"name": parameter.name, "domain": parameter.domain}
                for parameter in form.parameters
            ],
            "background": _background(form, CATALOGUE),
            "period": None if form.period is None else str(form.period),
            "reference": str(form.reference),
        }
        for form in CATALOGUE
    ]


def _background(form: ClosedForm, catalogue: Iterable[ClosedForm]) -> str:
    """The bare wave's name where the background is one of the catalogue, else its formula."""
    for other in catalogue:
        is_bare = other.period is not None and other.background == 0  # no other formula is made
        if is_bare and other.expression == form.background:
            return other.name
    return str(form.background)


def schemes() -> list[Record]:
    """The schemes: name, order, forces a step, largest stable step times frequency, source."""
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
    """The shipped scenes, the paper's first, then the others and the members of families."""
    from longwave.scenes.description.named_scenes import (
        load_scene,
        rational_family_scenes,
        shipped_scenes,
    )

    found = [("paper", load_scene(name)) for name in shipped_scenes()]
    found += [("further", load_scene(name)) for name in shipped_scenes("further")]
    found += [("family", scene) for scene in rational_family_scenes().values()]
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
        for origin, scene in found
    ]


def lattice_scenes() -> list[Record]:
    """The shipped scenes that name a lattice: lattice, equation, wave, eps, order, times."""
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
    """The shipped chains on a bench: lattice, cells, times, tolerance."""
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
    """The shipped sweeps: name, title, base scene, swept fields, number of cells."""
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
    """The observables: name, what is computed, the arrays that are added to a run."""
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
    """Of one kind of things: their records, the columns of their table, and what stands below.

    A column has a format of a record, or a function of it.
    """

    records: Callable[[], list[Record]]
    columns: Mapping[str, str | Callable[[Record], str]]
    note: str = ""


def _own(*names: str) -> dict[str, str]:
    """Columns of records' entries as they are."""
    return {name: f"{{{name}}}" for name in names}


def _computed(record: Record) -> str:
    if record["tolerance"] is not None:
        return f"to {record['tolerance']:g}"
    return f"{record['scheme']}, step {record['step']:g}"


_KINDS: Mapping[str, _Kind] = {
    "lattices": _Kind(lattices, _own("name", "title", "fields", "constants", "forces")),
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
        "rational_<j> is there for every order j: to be run up to 12, to be proved up to 99",
    ),
    "schemes": _Kind(
        schemes,
        _own("name", "order")
        | {"forces a step": "{forces_a_step}", "stable step x frequency": "{stability_limit:.2f}"}
        | {"from": "{reference}"},
    ),
    "scenes": _Kind(
        scenes,
        _own("name", "title", "wave")
        | {"eps": "{eps:g}", "times": "{start:g} to {end:g}", "computed": _computed},
        "a scene of your own is a TOML file: longwave run FILE.toml",
    ),
    "lattice-scenes": _Kind(
        lattice_scenes,
        _own("name", "title", "lattice", "equation", "wave")
        | {"eps": "{eps:g}", "order": "{order}", "to": "{tolerance:g}"},
        "each is derived anew when it is run; longwave converge NAME fits its rate",
    ),
    "bench-scenes": _Kind(
        bench_scenes,
        _own("name", "title", "lattice")
        | {"cells": "{cells}", "until": "{end:g}", "to": "{tolerance:g}"},
        "a chain of your own is a TOML file: longwave run FILE.toml",
    ),
    "sweeps": _Kind(
        sweeps,
        _own("name", "title", "scene") | {"varied": "{fields}", "cells": "{cells}"},
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


def print_tables(found: Mapping[str, Iterable[Record]]) -> None:
    """Print a table of each kind; text is printed as it is."""
    console = table_console(PIPE_WIDTH, highlight=False, markup=False, emoji=False)
    for kind, records in found.items():
        columns, note = _KINDS[kind].columns, _KINDS[kind].note
        headings = [Column(name, no_wrap=name == "name") for name in columns]
        table = Table(*headings, title=kind, title_justify="left")
        for record in records:
            cells = {name: _text(value) for name, value in record.items()}
            table.add_row(
                *(c.format(**cells) if isinstance(c, str) else c(record) for c in columns.values())
            )
        console.print(table)
        if note:
            console.print(note, soft_wrap=True)


def _text(value: Any) -> Any:
    """What a cell shows of an entry: a list with commas, nothing for None."""
    if isinstance(value, list):
        return ", ".join(map(str, value))
    return "" if value is None else value
