"""A sweep's growth rates over the carrier's wavenumber, beside the map that theory has of them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from reports.figures.growth_figures import GrowthCurve, GrowthPanel, ModulationMap

if TYPE_CHECKING:
    from verify.lattices.lattice_scene import LatticeScene

Array = NDArray[np.float64]

CARRIER = "envelope.k"
"""The field over which rates are drawn."""

NEEDED = (
    *("growth_rate", "growth_rate_error", "growth_rate_theory", "carrier_k"),
    "perturbation_kappa",
)
"""What a picture is made of, beside the cells' status."""

MOST_ROWS = 6
"""Lattices in a picture."""

WAVENUMBERS, KAPPAS = 400, 120
"""Points of a map."""

BEYOND = 1.25
"""How far a map goes in kappa, in units of the largest that was run and grows."""


def growth_panels(data: xr.Dataset, most_curves: int) -> Sequence[GrowthPanel]:
    """The rates of a sweep's cells over k: a panel for each lattice, a curve for each other value.

    Raises ValueError in one line where the sweep is not over the carrier's k, or over too much.
    """
    along = _carrier_dimension(data)
    others = [str(name) for name in data["status"].dims if name != along]
    rows = [name for name in others if _is_discrete(data, name)][:1]
    if not rows and len(others) > 1:
        rows = [min(others, key=lambda name: data.sizes[name])]
    lines = [name for name in others if name not in rows]
    counts = [(rows, MOST_ROWS), (lines[:1], most_curves), (lines[1:], 1)]
    for names, most in counts:
        for name in names:
            if data.sizes[name] > most:
                raise ValueError(
                    f"{name} must have at most {most} values beside k, got {data.sizes[name]} "
                    f"(choose with --at {name}=VALUE)"
                )
    places = range(data.sizes[rows[0]]) if rows else [None]
    return [
        _panel(data if place is None else data.isel({rows[0]: place}), along, lines[:1])
        for place in places
    ]


def _carrier_dimension(data: xr.Dataset) -> str:
    fields = {str(n): data[n].attrs.get("field") for n in data.coords if data[n].ndim == 1}
    found = [name for name, field in fields.items() if field == CARRIER]
    if not found or not all(_is_number_of_cells(data, name) for name in NEEDED):
        swept = ", ".join(map(str, fields.values())) or "nothing"
        raise ValueError(
            f"growth_map must be of growth rates over {CARRIER}, got a sweep over {swept} (a scene "
            'with wave = "perturbed_plane", and its k in [grid])'
        )
    return str(data[found[0]].dims[0])


def _is_number_of_cells(data: xr.Dataset, name: str) -> bool:
    """Whether a data set, which may be any file's, has that number of each cell."""
    return name in data and data[name].dims == data["status"].dims and data[name].dtype.kind == "f"


def _is_discrete(data: xr.Dataset, name: str) -> bool:
    """Whether a dimension is of texts, or a list."""
    own = [data[c] for c in data.coords if data[c].dims == (name,)]
    return any(values.dtype.kind not in "fiu" for values in own)


def _panel(data: xr.Dataset, along: str, lines: Sequence[str]) -> GrowthPanel:
    places = range(data.sizes[lines[0]]) if lines else [None]
    parts = [data if place is None else data.isel({lines[0]: place}) for place in places]
    labels = [_told(part, lines) for part in parts]
    curves = [_curve(label, part, along) for label, part in zip(labels, parts, strict=True)]
    title = _told(data, [str(n) for n in data.coords if data[n].ndim == 0], ("lattice", "branch"))
    return GrowthPanel(title, curves, _theory(parts, along, curves))


def _told(data: xr.Dataset, names: Sequence[str], wanted: Sequence[str] = ()) -> str:
    """The values of coordinates in words."""
    told = {name: data[name].item() for name in names if name in data.coords}
    if wanted:
        return ", ".join(str(told[name]) for name in wanted if name in told)
    return ", ".join(
        f"{name} = {value:g}" if isinstance(value, int | float) else f"{name} = {value}"
        for name, value in told.items()
    )


def _curve(label: str, data: xr.Dataset, along: str) -> GrowthCurve:
    done = data["status"].values == "done"

    def column(name: str) -> Array:
        return np.where(done, np.asarray(data[name].values, dtype=np.float64), np.nan)

    asked = np.array([_number(value) for value in _asked(data, along)])
    return GrowthCurve(
        label,
        np.where(done, column("carrier_k"), asked),
        column("growth_rate"),
        column("growth_rate_error"),
        column("growth_rate_theory"),
        column("perturbation_kappa"),
        np.isin(data["status"].values, ("refused", "failed", "blown up")),
    )


def _asked(data: xr.Dataset, along: str) -> Sequence[Any]:
    fields = (c for c in data.coords if data[c].dims == (along,))
    found: list[Any] = next(
        data[c].values.tolist() for c in fields if data[c].attrs.get("field") == CARRIER
    )
    return found


def _number(value: float | str) -> float:
    """A wavenumber as a file says it; NaN for what is none."""
    from verify.lattices.lattice_derivation import formula

    try:
        return float(formula("k", value, {}))
    except (ValueError, TypeError):
        return np.nan


def _theory(
    parts: Sequence[xr.Dataset], along: str, curves: Sequence[GrowthCurve]
) -> ModulationMap | None:
    """The map of the cells' lattice; None where it has none, or is in a file of its own."""
    from verify.lattices.modulation import scene_modulation
    from verify.lattices.perturbed_plane import chosen_kappa
    from verify.lattices.sideband_growth import plane_wave_numbers

    k = np.linspace(0.0, np.pi, WAVENUMBERS + 1)[1:]
    found: dict[bytes, Array] = {}
    first = None
    try:
        for part in parts:
            scene = _scene(part.isel({along: 0}))
            given = plane_wave_numbers(scene)
            grid = scene_modulation(scene, k, given["amplitude"])
            kappa = chosen_kappa(grid.p, grid.q, given)
            rates = _rates(grid.p, grid.q, given["amplitude"], kappa)
            found[rates.tobytes()] = rates
            first = first or (grid, given["amplitude"])
    except ValueError:
        return None
    assert first is not None
    grid, amplitude = first
    run = np.concatenate([curve.kappa for curve in curves])
    growing = run[np.concatenate([curve.theory for curve in curves]) > 0.0]
    shown = growing if growing.size else run[np.isfinite(run)]
    largest = float(np.max(shown, initial=0.0)) or 1.0
    kappas = np.linspace(0.0, BEYOND * largest, KAPPAS)
    rates = _rates(grid.p, grid.q, amplitude, kappas[:, None])
    return ModulationMap(k, list(found.values()), grid.product, kappas, rates)


def _rates(p: Array, q: Array, amplitude: float, kappa: Array | float) -> Array:
    """Growth rates in T of perturbations, 0 of those that do not grow."""
    from verify.lattices.perturbed_plane import squared_rate

    with np.errstate(all="ignore"):
        return np.asarray(np.sqrt(np.maximum(squared_rate(p, q, amplitude, kappa), 0.0)))


def _scene(cell: xr.Dataset) -> LatticeScene:
    """The scene of one cell; ValueError if the file does not hold it."""
    from runs.sweep_scene import changed_document, make_scene
    from verify.lattices.lattice_scene import LatticeScene

    try:
        document = json.loads(cell.attrs["sweep"])["scene"]
        changes = {
            str(cell[name].attrs["field"]): _value(cell[name].item())
            for name in cell.coords
            if "field" in cell[name].attrs
        }
        scene = make_scene(changed_document(document, changes), "scene", Path())
    except (KeyError, TypeError, AttributeError, RecursionError) as error:
        raise ValueError(f"sweep must hold its scene, got {error}") from None
    if not isinstance(scene, LatticeScene):
        raise ValueError(f"scene must name a lattice, got {scene.name}")
    return scene


def _value(held: Any) -> Any:
    """A field's value: lists and tables stand as JSON."""
    if isinstance(held, str) and held[:1] in ("[", "{"):
        return json.loads(held)
    return held
