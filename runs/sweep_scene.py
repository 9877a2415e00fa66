"""The scenes of a sweep: a scene's file as tables, with other values in some of its fields."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeAlias

from longwave.scenes import lattice_scene_file
from longwave.scenes.any_scene import AnyScene, load_scene
from longwave.scenes.chain import scene_fields
from longwave.scenes.chain.observables import OBSERVABLES
from longwave.scenes.chain.scene import Scene
from longwave.scenes.chain.scene_fields import read_document
from longwave.scenes.lattice_scene import LatticeScene
from longwave.scenes.lattice_scene_file import lattice_scene_fields, names_a_lattice
from longwave.scenes.scene_disorder import Disorder
from longwave.support.known_names import one_of
from longwave.support.user_files import shown

Document: TypeAlias = Mapping[str, Any]

ALTERNATIVES = (("slow_times", "times"), ("half_width", "compared"))
"""Fields of which a scene has one: who states one leaves the other out."""

OPEN = ("parameters", "constants")
"""Tables whose keys a wave or a lattice decides."""

LABELS = ("name", "title")
"""Fields on which no run depends."""

CHAIN = {
    **{key: () for key in scene_fields.TOP if key not in LABELS},
    **{name: tuple(keys) for name, keys in scene_fields.TABLES.items()},
}
"""What may vary of a `Scene`: fields, and tables with their keys."""

ANY_LATTICE = {
    **{key: () for key in (*lattice_scene_file.TOP, "lattice") if key not in LABELS},
    "long_wave": lattice_scene_file.LONG_WAVE,
    "envelope": tuple(lattice_scene_file.ENVELOPE),
    "disorder": tuple(field.name for field in fields(Disorder)),
}
"""The same of a `LatticeScene`."""


def base_document(given: object, folder: Path) -> tuple[str, Document]:
    """Name and tables of a sweep's base: a shipped scene, a file in ``folder``, or tables.

    Raises ValueError in one line.
    """
    if isinstance(given, Mapping):
        return "scene", given
    if not isinstance(given, str):
        raise ValueError(
            f"scene must be a name, a file or a table, got {shown(given)} (such as 'toda_soliton')"
        )
    if given.endswith(".toml"):
        path = folder / given
        return path.stem, read_document(path)
    scene = load_scene(given)
    return scene.name, tomllib.loads(scene.toml())


def check_field(field: str, document: Document) -> None:
    """Refuse a field that no scene of the document's kind has."""
    top, _, key = field.partition(".")
    known = ANY_LATTICE if names_a_lattice(document) else CHAIN
    if top in OPEN and (top == "parameters" or known is ANY_LATTICE):
        return  # a key of the table, or all of it
    if top in known and (key in known[top] if key else not known[top]):
        return
    names = [
        *(
            f"{name}.{inner}" if inner else name
            for name, keys in known.items()
            for inner in keys or [""]
        ),
        "parameters.NAME",
        *(["constants.NAME"] if known is ANY_LATTICE else []),
    ]
    raise ValueError(f"fields must be known ones, got {shown(field)} ({one_of(field, names)})")


def changed_document(document: Document, changes: Mapping[str, Any]) -> Document:
    """The tables with other values; fields have dotted names. The given ones stay as they are.

    >>> changed_document({"eps": 1, "parameters": {"k": 2}}, {"parameters.k": 3, "times": [0, 1]})
    {'eps': 1, 'parameters': {'k': 3}, 'times': [0, 1]}
    """
    found = dict(document)
    if "tolerance" in changes and "tolerance" not in found:
        _leave_to_tolerance(found)
    for field, value in changes.items():
        for pair in ALTERNATIVES:
            if field in pair:
                found.pop(pair[1 - pair.index(field)], None)
        name, _, key = field.partition(".")
        if not key:
            found[name] = value
            continue
        entries = found.get(name, {})
        if not isinstance(entries, Mapping):
            raise ValueError(f"{name} must be a table for {field}, got {shown(entries)} (name it)")
        found[name] = {**entries, key: value}
    return found


def _leave_to_tolerance(document: dict[str, Any]) -> None:
    """Take away what a tolerance determines: scheme, step, domain, and measured refinements."""
    document.pop("scheme", None)
    domain = document.get("domain", {})
    if isinstance(domain, Mapping) and "compared" in domain:
        document["domain"] = {"compared": domain["compared"]}
    asked = document.get("observables")
    if isinstance(asked, list | tuple):
        document["observables"] = [
            name
            for name in asked
            if not (name in OBSERVABLES and OBSERVABLES[name].seen == "refinement")
        ]


def make_scene(document: Document, name: str, folder: Path) -> AnyScene:
    """The scene, of either kind, that the tables say; ValueError in one line for what is none."""
    if names_a_lattice(document):
        return LatticeScene.of(**{"name": name} | lattice_scene_fields(document, folder))
    return Scene.of(**{"name": name} | scene_fields.scene_fields(document))
