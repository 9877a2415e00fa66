"""The files of scenes: TOML with a whitelist of keys.

    name, title, lattice, wave, eps, order, t0, snapshots, times, slow_times, compared, half_width,
    observables, curve_points, look_points, tolerance, engine
    [constants]   the lattice's: numbers, or formulas in text, with eps in it where they are small
    [parameters]  the wave's: numbers, or texts such as "K/2", "1/3"
    [long_wave]   amplitude, time (powers of eps), background (a mean strain); all may be left out
    [envelope]    k (the carrier's wavenumber, such as "pi/2"), branch
    [disorder]    of, spread, seed, distribution, sites: see `scene_disorder.py`
    [losses]      site, bond: see `losses.py`
    [scheme]      name, step
    [domain]      kind, sites

or, in the place of a wave, the tables of a chain on a bench (`bench.py`).

``lattice`` is a name of the catalogue, the file of a lattice (in the scene's folder), or the
lattice itself, as a table with the keys of such a file; as a table of K2, K3 and K4 it is the
paper's chain. Constants that are not stated are as the lattice's file has them. ``compared`` may
stand in [domain], too. A scene with a tolerance states no step, kind and sites; one without a name
has that of its file.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from numbers import Integral, Real
from pathlib import Path
from typing import Any

from longwave.scenes.description.bench import BENCH_TABLES
from longwave.scenes.description.csv_table import with_columns
from longwave.scenes.description.scene_checks import (
    CHAIN,
    CHAIN_CONSTANTS,
    refuse_unknown,
    table,
    text,
)
from longwave.scenes.description.scene_disorder import Disorder
from longwave.scenes.description.stated_tables import StatedTables
from longwave.support.user_files import read_toml, shown, shown_path

TOP = (
    *("name", "title", "lattice", "wave", "eps", "order", "t0", "snapshots", "times"),
    *("slow_times", "compared", "half_width", "observables", "curve_points", "look_points"),
    *("tolerance", "engine"),
)
PAIRS = ("constants", "parameters")
"""Tables whose keys a lattice or a wave decides."""

TABLES = {
    "long_wave": {"amplitude": "amplitude", "time": "time", "background": "background"},
    "envelope": {"k": "carrier", "branch": "branch"},
    "scheme": {"name": "scheme", "step": "step"},
    "domain": {"kind": "domain", "sites": "sites", "compared": "compared"},
}
"""Their keys, and the fields of a scene that these are."""

LATTICE_KEYS = ("fields", "masses", "positive", "spring", "site", "bond")
"""Keys of which a table that declares a lattice has one."""

STATED = {"step": "step in [scheme]", "domain": "kind in [domain]", "sites": "sites in [domain]"}
"""Required unless there is a tolerance."""

LARGEST_FILE = 1_000_000
"""Bytes of a scene's file."""


def read_document(path: str | Path, what: str = "scene") -> Mapping[str, Any]:
    """The tables of a TOML file, or of the standard input for ``-``; ``what`` it is to be.

    Raises ValueError, in one line, for what is none.
    """
    try:
        return read_toml(path, what, LARGEST_FILE)
    except OSError as error:
        raise ValueError(
            f"{what} must be a file that can be read, got {shown_path(path)}: {error.strerror} "
            f"(or the name of a shipped {what})"
        ) from None


def in_one_spelling(document: Mapping[str, Any]) -> dict[str, Any]:
    """The tables with the paper's chain by its name.

    >>> in_one_spelling({"lattice": {"K2": 1, "K4": 2}, "domain": {"compared": 9}})
    {'lattice': 'fput_strain', 'constants': {'K2': 1, 'K4': 2}, 'compared': 9}
    """
    found = dict(document)
    lattice = found.get("lattice")
    if isinstance(lattice, Mapping) and not any(key in lattice for key in LATTICE_KEYS):
        refuse_unknown(lattice, CHAIN_CONSTANTS, " in [lattice]")
        if table(document, "constants"):
            raise ValueError(
                "K2, K3 and K4 must be in [constants] or in [lattice], got both (leave one out)"
            )
        found |= {"lattice": CHAIN, "constants": dict(lattice)}
    domain = found.get("domain")
    if isinstance(domain, Mapping) and "compared" in domain:
        if "compared" in found:
            raise ValueError("compared must be given once, got it in [domain], too (leave one out)")
        rest = {key: value for key, value in domain.items() if key != "compared"}
        found.pop("domain")
        found |= ({"domain": rest} if rest else {}) | {"compared": domain["compared"]}
    return found


def scene_fields(given: Mapping[str, Any], folder: Path = Path()) -> dict[str, Any]:
    """The keywords of `Scene.of` for a parsed document; files are looked for in ``folder``.

    >>> scene_fields({"colour": 3})
    Traceback (most recent call last):
    ...
    ValueError: keys must be known ones, got colour (one of name, ..., constants, ...)
    >>> scene_fields({"step": 0.1})
    Traceback (most recent call last):
    ...
    ValueError: step must be in [scheme], got it at the top of the scene (write it below a line ...)
    """
    document = in_one_spelling(given)
    known = (*TOP, *PAIRS, *TABLES, "disorder", "losses", *BENCH_TABLES)
    for name, fields in TABLES.items():
        for key in sorted(document.keys() & fields.keys() - set(known)):
            raise ValueError(
                f"{key} must be in [{name}], got it at the top of the scene (write it below a line "
                f"[{name}])"
            )
    refuse_unknown(document, known)
    found = {key: document[key] for key in TOP if key in document}
    found |= with_columns({key: document[key] for key in BENCH_TABLES if key in document}, folder)
    found |= _lattice(document.get("lattice"), folder)
    found |= {name: tuple(table(document, name).items()) for name in PAIRS}
    measured = table(found["declared"].tables, "constants") if "declared" in found else {}
    found["constants"] = tuple({**measured, **dict(found["constants"])}.items())
    for name, fields in TABLES.items():
        entries = table(document, name)
        refuse_unknown(entries, fields, f" in [{name}]")
        found |= {fields[key]: value for key, value in entries.items()}
    if "losses" in document:
        found["losses"] = table(document, "losses")
    if "disorder" in document:
        found["disorder"] = Disorder.of_pairs(table(document, "disorder"))
    if "envelope" in document and found.get("carrier", "") == "":
        raise ValueError('k in [envelope] must be stated, got nothing (such as k = "pi/2")')
    if "long_wave" in document and "envelope" in document:
        raise ValueError("[long_wave] must not be given with [envelope], got both (leave one)")
    if "tolerance" not in found and found.keys() & {"chain", "start"}:
        raise ValueError(
            "tolerance must be stated, got nothing (of what is watched, such as tolerance = 1e-8)"
        )
    missing = [where for key, where in STATED.items() if key not in found]
    if missing and "tolerance" not in found:
        raise ValueError(f"{missing[0]} must be stated, got nothing (state it or a tolerance)")
    return found


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


def lattice_keywords(given: object) -> dict[str, Any]:
    """The keywords of `Scene.of` for a `derive.Lattice`, or for the tables of a lattice's file.

    >>> from longwave.derive import LATTICES
    >>> lattice_keywords(LATTICES["toda"])
    {'lattice': 'toda'}
    """
    if isinstance(given, Mapping):
        return _declaration(given, "lattice")
    from longwave.derive import LATTICES, Lattice  # scenes are read without SymPy
    from longwave.derive.lattice_file import document_of_lattice

    if not isinstance(given, Lattice):
        raise ValueError(
            f"lattice must be a name, a Lattice or its tables, got {shown(given)} (such as 'toda')"
        )
    if LATTICES.get(given.name) == given:
        return {"lattice": given.name}
    return _declaration(document_of_lattice(given), given.name)


def _declaration(document: Mapping[str, Any], name: str) -> dict[str, Any]:
    """The lattice's name, and what else its tables say."""
    found = dict(document)
    called = found.pop("name", name)
    text("name in [lattice]", called)
    return {"lattice": called, "declared": StatedTables(found, "lattice")}


def document_of(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the document that `scene_fields` reads as these keywords of a scene.

    >>> document_of({"wave": "kink", "constants": [["K2", 1]], "step": None, "sites": 8})
    {'lattice': 'fput_strain', 'wave': 'kink', 'constants': {'K2': 1}, 'domain': {'sites': 8}}
    """
    given = {"lattice": CHAIN} | {k: v for k, v in given.items() if v is not None}
    found = {key: given[key] for key in TOP if key in given}
    if "declared" in given:
        found["lattice"] = {"name": given["lattice"], **given["declared"].tables}
    found |= {name: dict(given[name]) for name in PAIRS if name in given}
    found |= {"disorder": dict(given["disorder"].pairs)} if "disorder" in given else {}
    found |= {"losses": given["losses"].table} if "losses" in given else {}
    found |= given["bench"].stated.tables if "bench" in given else {}
    for name, fields in TABLES.items():
        entries = {k: given[field] for k, field in fields.items() if field in given}
        entries.pop("compared", None)
        found |= {name: entries} if entries else {}
    return found


_BARE = re.compile(r"[A-Za-z0-9_-]+")


def toml_text(document: Mapping[str, object]) -> str:
    """The document as TOML: values first, then its tables, each with all that is in it inline.

    Reading gives the same tables: numbers to the last bit.

    A value is a text, a truth value, a number, a list or a table; ValueError for any other.

    >>> print(toml_text({"wave": "kink", "lattice": {"K2": 0.1}, "times": [0, 1e-5]}), end="")
    wave = "kink"
    times = [0, 1e-05]
    <BLANKLINE>
    [lattice]
    K2 = 0.1
    """
    tables = {name: value for name, value in document.items() if isinstance(value, Mapping)}
    lines = [_line(name, value) for name, value in document.items() if name not in tables]
    for name, entries in tables.items():
        lines += ["", f"[{_key(name)}]", *(_line(*entry) for entry in entries.items())]
    return "\n".join(lines).lstrip("\n") + "\n"


def _line(name: str, value: object) -> str:
    return f"{_key(name)} = {_value(value)}"


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else _text(name)


def _value(value: object) -> str:
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Integral):
        return str(int(value))
    if isinstance(value, Real):
        return repr(float(value))
    if isinstance(value, Mapping):
        return f"{{{', '.join(_line(*entry) for entry in value.items())}}}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    raise ValueError(
        f"a value of TOML must be a text, a number, a list or a table, got {type(value).__name__} "
        "(leave it out)"
    )


def _text(text: str) -> str:
    """A text in quotes; JSON writes what TOML reads, but for one sign that steers terminals."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
