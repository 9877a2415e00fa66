"""The files of scenes on any lattice: TOML with a whitelist of keys.

    title, lattice, wave, eps, order, slow_times, times, half_width, compared, tolerance
    [constants]   the lattice's: numbers, or formulas in text, with eps in it where they are small
    [parameters]  the wave's
    [long_wave]   amplitude, time (powers of eps), background (a mean strain); all may be left out
    [envelope]    k (the carrier's wavenumber, such as "pi/2"), branch

``lattice`` is a name of the catalogue, the file of a lattice (in the scene's folder), or the
lattice itself, as a table with the keys of such a file.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from verify.comparison.scene_fields import read_document, refuse_unknown, shown, table

TOP = (
    *("title", "wave", "eps", "order", "slow_times", "times", "half_width", "compared"),
    "tolerance",
)
TABLES = ("constants", "parameters", "long_wave", "envelope")
LONG_WAVE = ("amplitude", "time", "background")
ENVELOPE = {"k": "carrier", "branch": "branch"}
LATTICE_KEYS = ("fields", "masses", "positive", "spring", "site", "bond")
"""Keys of which a table that declares a lattice has one; K2, K3, K4 are the paper's constants."""


def names_a_lattice(document: Mapping[str, Any]) -> bool:
    """Whether a scene's file is one of a `LatticeScene`: it names a lattice, or declares one.

    >>> names_a_lattice({"lattice": "toda"}), names_a_lattice({"lattice": {"K2": 1, "K4": 1}})
    (True, False)
    """
    lattice = document.get("lattice")
    if isinstance(lattice, Mapping):
        return any(key in lattice for key in LATTICE_KEYS)
    return lattice is not None or any(key in document for key in ("constants", "envelope"))


def lattice_scene_fields(document: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """The fields of a `LatticeScene` but for its name; files are looked for in ``folder``.

    >>> lattice_scene_fields({"colour": 3}, Path())
    Traceback (most recent call last):
    ...
    ValueError: keys must be known ones, got colour (one of title, ..., constants, ...)
    """
    refuse_unknown(document, (*TOP, "lattice", *TABLES), "")
    found = {key: document[key] for key in TOP if key in document}
    found |= _lattice(document.get("lattice"), folder)
    for name in ("constants", "parameters"):
        found[name] = tuple(table(document, name).items())
    ansatz = table(document, "long_wave")
    refuse_unknown(ansatz, LONG_WAVE, " in [long_wave]")
    found |= ansatz
    carrier = table(document, "envelope")
    refuse_unknown(carrier, tuple(ENVELOPE), " in [envelope]")
    if "envelope" in document and "k" not in carrier:
        raise ValueError('k in [envelope] must be stated, got nothing (such as k = "pi/2")')
    if "long_wave" in document and "envelope" in document:
        raise ValueError("[long_wave] must not be given with [envelope], got both (leave one)")
    return found | {ENVELOPE[key]: value for key, value in carrier.items()}


def _lattice(given: object, folder: Path) -> dict[str, Any]:
    """The lattice by name, or as its name and its declaration."""
    if isinstance(given, Mapping):
        return {"lattice": str(given.get("name", "lattice")), "declared": _as_json(given)}
    if not isinstance(given, str):
        raise ValueError(
            f"lattice must be a name, a file or a table, got {shown(given)} (such as 'toda')"
        )
    if not given.endswith(".toml"):
        return {"lattice": given}
    path = folder / given
    if not path.is_file():
        raise ValueError(
            f"lattice must be a file beside the scene, got {shown(given)} (there is none in "
            f"{folder})"
        )
    document = read_document(path)
    return {"lattice": str(document.get("name", path.stem)), "declared": _as_json(document)}


def _as_json(document: Mapping[str, Any]) -> str:
    try:
        return json.dumps(document)
    except TypeError as error:
        raise ValueError(f"lattice must hold texts and numbers, got a date ({error})") from None
