"""The files of scenes on any lattice: TOML with a whitelist of keys.

    name, title, lattice, wave, eps, order, slow_times, times, half_width, compared, tolerance
    [constants]   the lattice's: numbers, or formulas in text, with eps in it where they are small
    [parameters]  the wave's
    [long_wave]   amplitude, time (powers of eps), background (a mean strain); all may be left out
    [envelope]    k (the carrier's wavenumber, such as "pi/2"), branch
    [disorder]    of, spread, seed, distribution, sites: see `scene_disorder.py`

``lattice`` is a name of the catalogue, the file of a lattice (in the scene's folder), or the
lattice itself, as a table with the keys of such a file.  A scene without a name has that of its
file.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from longwave.scenes.chain.scene_fields import read_document, refuse_unknown, table, text
from longwave.scenes.scene_disorder import Disorder
from longwave.support.user_files import shown

TOP = (
    *("name", "title", "wave", "eps", "order", "slow_times", "times", "half_width", "compared"),
    "tolerance",
)
TABLES = ("constants", "parameters", "long_wave", "envelope", "disorder")
LONG_WAVE = {"amplitude": None, "time": None, "background": 0}
"""What stands in a file, and what it is where that says nothing."""

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
    """The fields of a `LatticeScene`, its name if given; files are looked for in ``folder``.

    >>> lattice_scene_fields({"colour": 3}, Path())
    Traceback (most recent call last):
    ...
    ValueError: keys must be known ones, got colour (one of name, ..., constants, ...)
    """
    refuse_unknown(document, (*TOP, "lattice", *TABLES), "")
    found = {key: document[key] for key in TOP if key in document}
    found |= _lattice(document.get("lattice"), folder)
    for name in ("constants", "parameters"):
        found[name] = tuple(table(document, name).items())
    if "disorder" in document:
        found["disorder"] = Disorder.of_pairs(table(document, "disorder")).pairs
    ansatz = table(document, "long_wave")
    refuse_unknown(ansatz, tuple(LONG_WAVE), " in [long_wave]")
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
        return _declaration(given, "lattice")
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
    return _declaration(read_document(path), path.stem)


def _declaration(document: Mapping[str, Any], name: str) -> dict[str, Any]:
    """The lattice's name, and what else its tables say as JSON."""
    found = dict(document)
    called = found.pop("name", name)
    text("name in [lattice]", called)
    try:
        return {"lattice": called, "declared": json.dumps(found)}
    except TypeError as error:
        raise ValueError(f"lattice must hold texts and numbers, got a date ({error})") from None


def document_of(given: Mapping[str, Any]) -> dict[str, Any]:
    """The document of a scene with these fields: what `lattice_scene_fields` makes them of."""
    found: dict[str, Any] = {"name": given["name"]}
    found |= {key: given[key] for key in TOP if given[key] not in (None, "", ())}
    found["lattice"] = given["lattice"]
    if given["declared"]:
        found["lattice"] = {"name": given["lattice"], **json.loads(given["declared"])}
    ansatz = {key: given[key] for key, usual in LONG_WAVE.items() if given[key] != usual}
    found |= {"constants": dict(given["constants"]), "parameters": dict(given["parameters"])}
    found |= {"long_wave": ansatz} if ansatz else {}
    found["disorder"] = dict(given["disorder"])
    if given["carrier"] != "":
        found["envelope"] = {key: given[field] for key, field in ENVELOPE.items()}
    return {key: value for key, value in found.items() if value != {}}
