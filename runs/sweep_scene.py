"""A scene's file with other values in some fields: the cells of a sweep, and the option `--set`."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeAlias

from longwave.scenes.description import scene_file
from longwave.scenes.description.bench import KEYS
from longwave.scenes.description.losses import EPS_POWERS
from longwave.scenes.description.named_scenes import load_scene, names_a_file
from longwave.scenes.description.scene import Scene, alternatives_of
from longwave.scenes.description.scene_checks import CHAIN_CONSTANTS
from longwave.scenes.description.scene_disorder import Disorder
from longwave.scenes.observed.observables import OBSERVABLES
from longwave.support.known_names import one_of
from longwave.support.user_files import STANDARD_INPUT, file_stem, shown

Document: TypeAlias = Mapping[str, Any]

UNVARIED = ("name", "title")
"""Fields of a scene that do not affect its run, and that no sweep varies."""

VARIED = {
    **{key: () for key in scene_file.TOP_KEYS if key not in UNVARIED},
    **{name: tuple(keys) for name, keys in scene_file.TABLE_FIELDS.items()},
    "disorder": tuple(field.name for field in fields(Disorder)),
    "losses": EPS_POWERS,
    **{name: KEYS[name] for name in ("chain", "start", "defects")},
}
"""Fields that a sweep may vary: top-level key -> (); table -> its keys that may vary."""


def base_document(given: object, folder: Path = Path()) -> tuple[str, Document]:
    """Return name and tables of a base scene: a shipped one, a file in ``folder``, or tables."""
    if isinstance(given, Mapping):
        return "scene", scene_file.in_one_spelling(given)
    if not isinstance(given, str):
        got = f"{shown(given)} (such as 'toda_soliton')"
        raise ValueError(f"scene must be a name, a file or a table, got {got}")
    if names_a_file(given, folder):
        path = given if given == STANDARD_INPUT else folder / given
        return file_stem(path), scene_file.in_one_spelling(scene_file.read_document(path))
    scene = load_scene(given)
    return scene.name, tomllib.loads(scene.toml())


def changed_scene(
    source: str,
    changes: Mapping[str, Any],
    tolerance: float | None = None,
    engine: str | None = None,
) -> Scene:
    """Load a scene by file or name and return it with ``changes`` to some fields.

    ``tolerance`` and ``engine`` are options of their own. Raises ValueError in one line for an
    unknown field, or if the scene is not admissible.

    >>> changed_scene("toda_soliton", {"eps": 0.05, "parameters.kappa": 2})
    <Scene toda_soliton: kdv_soliton with kappa = 2 on toda, eps = 0.05, ...>
    """
    for option, value in (("tolerance", tolerance), ("engine", engine)):
        if value is not None and option in changes:
            got = f"--{option} {value} and --set {option}={changes[option]} (leave one out)"
            raise ValueError(f"{option} must be given once, got {got}")
    scene = _changed(source, changes, tolerance) if changes else load_scene(source, tolerance)
    return scene if engine is None else scene.changed(engine=engine)


def _changed(source: str, changes: Mapping[str, Any], tolerance: float | None) -> Scene:
    canonical = {canonical_field(field): value for field, value in changes.items()}
    name, document = base_document(source)
    for field in canonical:
        check_field(field, document)
    if tolerance is not None:
        canonical = {"tolerance": tolerance, **canonical}
    return make_scene(changed_document(document, canonical), name, Path(source).parent)


def canonical_field(field: str) -> str:
    """Return the usual dotted name of a field that can be written in two ways.

    >>> canonical_field("lattice.K4"), canonical_field("domain.compared")
    ('constants.K4', 'compared')
    """
    if field == "domain.compared":
        return "compared"
    table, _, key = field.partition(".")
    return f"constants.{key}" if table == "lattice" and key in CHAIN_CONSTANTS else field


def check_field(field: str, document: Document | None = None) -> None:
    """Raise ValueError for an unknown field.

    If a table in ``document`` has the field as a key, the message says to write TABLE.KEY.
    """
    top, _, key = field.partition(".")
    if top in scene_file.PAIR_TABLES:
        return  # these tables may have any key, and may be replaced as a whole
    if top in VARIED and (key in VARIED[top] if key else not VARIED[top]):
        return
    qualified = [
        f"{name}.{field}"
        for name, entries in (document or {}).items()
        if isinstance(entries, Mapping) and field in entries
    ]
    if qualified:
        got = f"{field} (write {' or '.join(qualified)})"
        raise ValueError(f"fields must be named with their table, got {got}")
    known = [f"{name}.{key}".strip(".") for name, keys in VARIED.items() for key in keys or [""]]
    known += [f"{name}.NAME" for name in scene_file.PAIR_TABLES]
    raise ValueError(f"fields must be known ones, got {shown(field)} ({one_of(field, known)})")


def changed_document(document: Document, changes: Mapping[str, Any]) -> Document:
    """Return a copy of a scene's tables with ``changes``, a map from dotted names to new values.

    >>> changed_document({"eps": 1, "parameters": {"k": 2}}, {"parameters.k": 3, "times": [0, 1]})
    {'eps': 1, 'parameters': {'k': 3}, 'times': [0, 1]}
    """
    changed = dict(document)
    if "tolerance" in changes and "tolerance" not in changed:
        _leave_to_tolerance(changed)
    for field, value in changes.items():
        for other in alternatives_of([field]):
            changed.pop(other, None)
        if field == "lattice" and scene_file.in_one_spelling({field: value}) != {field: value}:
            got = f"{shown(value)} (sweep constants.K2)"
            raise ValueError(f"lattice must be a name or a declared lattice in a sweep, got {got}")
        name, _, key = field.partition(".")
        if not key:
            changed[name] = value
            continue
        entries = changed.get(name, {})
        if not isinstance(entries, Mapping):
            raise ValueError(f"{name} must be a table for {field}, got {shown(entries)} (name it)")
        changed[name] = {**entries, key: value}
    return changed


def _leave_to_tolerance(document: dict[str, Any]) -> None:
    """Remove the entries that a tolerance replaces: scheme, domain, observables of a refinement."""
    document.pop("scheme", None)
    document.pop("domain", None)
    observables = document.get("observables")
    if isinstance(observables, list | tuple):
        refined = {name for name, o in OBSERVABLES.items() if o.measured_at == "refinement"}
        document["observables"] = [name for name in observables if name not in refined]


def make_scene(document: Document, name: str, folder: Path) -> Scene:
    """Build the scene from its tables; raise ValueError in one line if it is not admissible."""
    return Scene.of(**{"name": name} | scene_file.scene_fields(document, folder))
