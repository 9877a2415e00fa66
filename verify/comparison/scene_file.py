"""Scene files: TOML with a whitelist of keys.

title, wave, eps, t0, snapshots, observables, curve_points, look_points, tolerance, engine
[lattice]     K2, K3, K4
[parameters]  the wave's own: numbers, or multiples of K such as "K/2"
[scheme]      name, step
[domain]      kind, sites, compared

A scene with a tolerance states no step, kind and sites.
"""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

TOP = (
    "title",
    "wave",
    "eps",
    "t0",
    "snapshots",
    "observables",
    "curve_points",
    "look_points",
    "tolerance",
    "engine",
)
TABLES = {
    "lattice": {"K2": "K2", "K3": "K3", "K4": "K4"},
    "scheme": {"name": "scheme", "step": "step"},
    "domain": {"kind": "domain", "sites": "sites", "compared": "compared"},
}
REQUIRED = ("wave", "eps", "t0", "snapshots", "K2", "K4", "compared")
STATED = ("step", "domain", "sites")
"""Required unless there is a tolerance."""


def read_scene_file(path: Path) -> dict[str, Any]:
    """The scene's fields by name, the file's stem as ``name``.

    Raises ValueError for a file that is missing, is not TOML, has an unknown key or lacks one.
    """
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(
            f"scene must be a file that can be read, got {path}: {error.strerror} "
            "(or the name of a shipped scene)"
        ) from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"scene must be a TOML file, got {path}: {error} (mend it)") from None
    try:
        return {"name": path.stem, **scene_fields(document)}
    except ValueError as error:
        raise ValueError(f"{path.name}: {error}") from None


def scene_fields(document: Mapping[str, Any]) -> dict[str, Any]:
    """Flatten a parsed document into the scene's fields, refusing unknown keys.

    >>> scene_fields({"colour": 3})
    Traceback (most recent call last):
    ...
    ValueError: keys must be known ones, got colour (one of title, wave, ..., domain, parameters)
    """
    _refuse_unknown(document, (*TOP, *TABLES, "parameters"), "")
    fields = {key: document[key] for key in TOP if key in document}
    for table, renamed in TABLES.items():
        entries = _table(document, table)
        _refuse_unknown(entries, tuple(renamed), f" in [{table}]")
        fields |= {renamed[key]: value for key, value in entries.items()}
    required = REQUIRED if "tolerance" in fields else (*REQUIRED, *STATED)
    missing = [key for key in required if key not in fields]
    if missing:
        remedy = " or a tolerance" if missing[0] in STATED else ""
        raise ValueError(f"{_where(missing[0])} must be stated, got nothing (state it{remedy})")
    fields["parameters"] = tuple(_table(document, "parameters").items())
    return fields


def _table(document: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    table = document.get(name, {})
    if not isinstance(table, Mapping):
        raise ValueError(f"{name} must be a table, got {table!r} (write [{name}])")
    return table


def _where(field: str) -> str:
    for table, renamed in TABLES.items():
        for key, target in renamed.items():
            if target == field:
                return f"{key} in [{table}]"
    return field


def _refuse_unknown(entries: Mapping[str, Any], known: tuple[str, ...], where: str) -> None:
    for key in entries:
        if key not in known:
            raise ValueError(
                f"keys{where} must be known ones, got {key} (one of {', '.join(known)})"
            )
