"""Shipped scenes, and loading of scenes by name or from a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import as_file, files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_file import read_document
from longwave.support.known_names import one_of
from longwave.support.user_files import STANDARD_INPUT, parse_toml, shown

if TYPE_CHECKING:
    import xarray as xr


def shipped_scenes(folder: str = "paper") -> tuple[str, ...]:
    """Return the sorted names of the shipped scenes of one folder, a key of `FOLDERS`.

    >>> "rational_2_eps_0.05" in shipped_scenes(), "toda_soliton" in shipped_scenes("lattices")
    (True, True)
    """
    if folder not in FOLDERS:
        raise ValueError(
            f"folder must be a known one, got {shown(folder)} ({one_of(folder, FOLDERS)})"
        )
    return _shipped_names(folder)


def load_scene(text: str | Path, tolerance: float | None = None) -> Scene:
    """Return the scene of a TOML file, or the shipped scene of that name.

    ``-`` reads the standard input; a lattice's file is then looked up in the working folder. A
    ``tolerance`` replaces the scene's own tolerance or step.

    Raises ValueError for a file that cannot be read or an unknown name.
    """
    if tolerance is not None:
        return _load(text, {"tolerance": tolerance}).with_tolerance(tolerance)
    return _load(text, {})


def names_a_file(name: str, folder: Path = Path()) -> bool:
    """Return whether ``name`` is that of a scene file in ``folder``, or of the standard input."""
    return name == STANDARD_INPUT or name.endswith(".toml") or (folder / name).is_file()


def _load(text: str | Path, defaults: Mapping[str, Any]) -> Scene:
    """Return a scene from a file or by name; files without [scheme] also get ``defaults``."""
    name = str(text)
    if names_a_file(name):
        document = read_document(name)
        return _of_document({**({} if "scheme" in document else defaults), **document}, Path(name))
    family = rational_family_scenes()
    if name in family:
        return family[name]
    for folder in FOLDERS:
        if name in _shipped_names(folder):
            with as_file(files(FOLDERS[folder]) / f"{name}.toml") as path:
                return Scene.from_toml(path)
    known = one_of(name, (one for folder in FOLDERS for one in _shipped_names(folder)))
    raise ValueError(f"scene must be a TOML file or a shipped scene, got {shown(text)} ({known})")


def scene_of_toml(text: str) -> Scene:
    """Return the scene that `Scene.toml` wrote; ValueError for other text."""
    return _of_document(parse_toml(text.encode(), "a text", "scene"), Path("scene"))


def scene_of(run: xr.Dataset) -> Scene:
    """Return the scene stored in a run, with any step and domain that the program chose filled in.

    Raises KeyError for a data set without a scene, ValueError for an invalid one.
    """
    return scene_of_toml(run.attrs["plan" if "plan" in run.attrs else "scene"])


def _of_document(document: Mapping[str, Any], path: Path) -> Scene:
    sweep_tables = {"grid", "list", "random"} & document.keys()
    if "scene" in document and sweep_tables:
        raise ValueError(
            f"{path}: a scene must be one, got a sweep, which has [{min(sweep_tables)}] (run it "
            "with `longwave sweep`)"
        )
    return Scene.of_document(document, path)


FOLDER_NAMES = ("paper", "further", "lattices", "bench")
"""Folders of shipped scenes: the paper's, further ones on its chain, other lattices, benches."""

FOLDERS = {name: f"longwave.scenes.shipped.{name}" for name in FOLDER_NAMES}
"""Python package that contains the scene files of each folder."""


@cache
def _shipped_names(folder: str) -> tuple[str, ...]:
    entries = (entry.name for entry in files(FOLDERS[folder]).iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in entries if name.endswith(".toml")))


ORDERS = (2, 3, 4, 5)
EPS = (0.1, 0.05, 0.025, 0.0125, 0.00625)

SLOW_START = -1.25
"""Slow time T = eps^3 t at which rational scenes start, as in the paper (-10000 at eps = 0.05)."""

SLOW_SNAPSHOTS = (-0.625, 0.0, 0.625)
"""Slow times T of the snapshots of rational scenes, as in the paper's scene."""

HALF_WIDTH = 75.0
"""Half-width in X of the compared region of rational scenes: 1500 sites at eps = 0.05."""


def rational_family_scenes(
    orders: Sequence[int] = ORDERS, eps: Sequence[float] = EPS, tolerance: float = 1e-4
) -> dict[str, Scene]:
    """Return scenes of the rational solutions Y_j at each eps, with equal slow times and X ranges.

    >>> scene = rational_family_scenes()["Y5_eps_0.025"]
    >>> scene.wave, scene.t0, scene.compared
    ('rational_5', -80000.0, 3000)
    """
    scenes = [_member(order, value, tolerance) for order in orders for value in eps]
    return {scene.name: scene for scene in scenes}


def _member(order: int, eps: float, tolerance: float) -> Scene:
    """Return the scene of Y_order at one eps; lattice times are rounded to whole numbers."""
    t0, *snapshots = (float(round(T / eps**3)) for T in (SLOW_START, *SLOW_SNAPSHOTS))
    return Scene.of(
        name=f"Y{order}_eps_{eps:g}",
        title=f"Rational solution of order {order}, eps = {eps:g}",
        wave=f"rational_{order}",
        eps=eps,
        t0=t0,
        snapshots=tuple(snapshots),
        K2=4.0,
        K4=1.0,
        compared=round(HALF_WIDTH / eps),
        tolerance=tolerance,
        observables=("strain",),
    )
