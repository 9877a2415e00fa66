"""A scene's fields: what each may be, and the keys of scene files.

A check raises ValueError in one line: argument, condition, value, remedy. Scene files are TOML with
a whitelist of keys:

name, title, wave, eps, t0, snapshots, observables, curve_points, look_points, tolerance, engine
[lattice]     K2, K3, K4
[parameters]  the wave's own: numbers, or multiples of K such as "K/2"
[scheme]      name, step
[domain]      kind, sites, compared

A scene with a tolerance states no step, kind and sites; one without a name has that of its file.
"""

import math
from collections.abc import Iterable, Mapping
from numbers import Integral, Real
from pathlib import Path
from typing import Any

from longwave.support.user_files import shown

MOST_STEPS = 1e10

USUAL: Mapping[str, str] = {
    "eps": "0.05",
    "t0": "-1000",
    "K2": "1",
    "K3": "0",
    "K4": "1",
    "step": "0.5",
    "sites": "4096",
    "compared": "200",
    "curve_points": "201",
    "look_points": "201",
    "tolerance": "1e-4",
    "snapshots": "[-100, 0, 100]",
}
"""What may be written instead of a wrong value."""

LEAST_TOLERANCE = 1e-11
"""Sup error of y/eps that double precision still tells from rounding (Y2 over t = 15000)."""

SMALLEST = 1e-50
"""Numbers below it, and above its reciprocal, would leave the range of doubles on the way."""

FARTHEST_SITE = 2.0**52
"""Beyond it numbers of sites are not all doubles."""

LARGEST = 1e9
"""Whole numbers above it would be more than any memory holds."""


def finite(name: str, value: object) -> float:
    """The value as a float, if it is a finite number."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ValueError(f"{name} must be a number, got {shown(value)}{_remedy(name)}")
    number = value if isinstance(value, int) else float(value)
    if not isinstance(number, int) and not math.isfinite(number):
        raise ValueError(f"{name} must be finite, got {value}{_remedy(name)}")
    if number != 0 and not SMALLEST <= abs(number) <= 1 / SMALLEST:
        raise ValueError(
            f"{name} must be 0 or satisfy {SMALLEST:g} <= |{name}| <= {1 / SMALLEST:g}, "
            f"got {shown(value)}{_remedy(name)}"
        )
    return float(number)


def positive(name: str, value: float) -> None:
    """Refuse what is not positive."""
    if value <= 0:
        raise ValueError(f"{name} must satisfy {name} > 0, got {value:g}{_remedy(name)}")


def tolerance(given: object) -> float:
    """The tolerance as a float, if it is positive and not below rounding."""
    value = finite("tolerance", given)
    positive("tolerance", value)
    if value < LEAST_TOLERANCE:
        raise ValueError(
            f"tolerance must satisfy tolerance >= {LEAST_TOLERANCE:g}, got {value:g} "
            "(rounding alone makes as much in a long run)"
        )
    return value


def whole(name: str, value: object) -> int:
    """The value as an int, if it is a whole number >= 1 that some memory holds."""
    if isinstance(value, bool) or not isinstance(value, Integral) or not 1 <= int(value) <= LARGEST:
        raise ValueError(
            f"{name} must be a whole number, 1 <= {name} <= {LARGEST:g}, got {shown(value)}"
            f"{_remedy(name)}"
        )
    return int(value)


def enough_steps(step: float, duration: float) -> None:
    """Refuse a step with which nobody will see the run's end."""
    if duration > MOST_STEPS * step:
        raise ValueError(
            f"step must satisfy step >= {duration / MOST_STEPS:.3g} for {duration:g} time units, "
            f"got {step:g} (that would be more than {MOST_STEPS:g} steps)"
        )


def within_reach(speed: float, times: Iterable[float]) -> None:
    """Refuse times at which the wave is at a site whose number is no exact double."""
    farthest = max(map(abs, times))
    if speed * farthest > FARTHEST_SITE:
        raise ValueError(
            f"times must satisfy |t| <= {FARTHEST_SITE / speed:.2g} with the speed of sound "
            f"{speed:.3g}, got {farthest:g} (beyond it sites cannot be told apart)"
        )


def text(name: str, value: object) -> None:
    """Refuse what is no text, and what no file can hold of one: halves of signs."""
    if not isinstance(value, str):
        raise ValueError(f"{name} must be a text, got {shown(value)} (write it in quotes)")
    if any("\ud800" <= sign <= "\udfff" for sign in value):
        raise ValueError(f"{name} must be a text in Unicode, got {shown(value)} (name it anew)")


def known_fields(given: Iterable[str], known: Iterable[str]) -> None:
    """Refuse keywords that a scene does not have."""
    for key in given:
        if key not in known:
            raise ValueError(
                f"keywords must be known ones, got {plain(key)} (one of {', '.join(known)})"
            )


def closed_form(value: object) -> None:
    """Refuse what is no closed form."""
    from longwave.solutions import ClosedForm  # only a wave that is not named needs formulas

    if not isinstance(value, ClosedForm):
        raise ValueError(
            f"wave must be a text or a ClosedForm, got {shown(value)} (such as 'rogue_cn')"
        )


def one_of(name: str, value: object, known: tuple[str, ...]) -> None:
    """Refuse a word that is not known."""
    if value not in known:
        raise ValueError(
            f"{name} must be a known one, got {shown(value)} (one of {', '.join(known)})"
        )


def times(values: object, t0: float) -> tuple[float, ...]:
    """Increasing times from t0 on."""
    if not isinstance(values, list | tuple) or not values:
        raise ValueError(
            f"snapshots must be a list of at least one time, got {shown(values)}"
            f"{_remedy('snapshots')}"
        )
    checked = tuple(finite("snapshots", value) for value in values)
    if min(checked) < t0:
        raise ValueError(
            f"snapshots must satisfy t >= t0 = {t0:g}, got {min(checked):g} (start earlier)"
        )
    if list(checked) != sorted(set(checked)):
        raise ValueError(f"snapshots must increase, got {shown(list(checked))} (sort them)")
    return checked


def names(name: str, values: object, known: tuple[str, ...]) -> tuple[str, ...]:
    """Known names."""
    if not isinstance(values, list | tuple):
        raise ValueError(
            f'{name} must be a list of names, got {shown(values)} (such as ["{known[0]}"])'
        )
    for value in values:
        one_of(name, value, known)
    return tuple(values)


def parameters(values: object) -> tuple[tuple[str, float | str], ...]:
    """The wave's parameters as pairs: finite numbers, or multiples of K (`moving_wave.py`)."""
    pairs = list(values.items()) if isinstance(values, Mapping) else values
    if not isinstance(pairs, list | tuple) or not all(
        isinstance(pair, list | tuple) and len(pair) == 2 for pair in pairs
    ):
        raise ValueError(
            f"parameters must be pairs of names and values, got {shown(values)} (such as "
            '{"k": 0.5})'
        )
    found = tuple(
        (str(name), value if isinstance(value, str) else finite(str(name), value))
        for name, value in pairs
    )
    differing("parameters", found)
    return found


def differing(where: str, pairs: Iterable[tuple[str, object]]) -> None:
    """Refuse pairs of which two have one name, and texts that no file can hold."""
    seen = set()
    for name, value in pairs:
        if name in seen:
            raise ValueError(f"{where} must have each name once, got {name} twice (leave one)")
        seen.add(name)
        text(f"name in {where}", name)
        if isinstance(value, str):
            text(name, value)


def plain(key: object) -> str:
    """A key as it is put into a message: short, without quotes."""
    found = str(key)
    return found if len(found) <= 60 else f"{found[:57]}..."


def _remedy(name: str) -> str:
    return f" (such as {USUAL.get(name, '0.5')})"


TOP = (
    "name",
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


LARGEST_FILE = 100_000
"""Bytes of a scene's file."""


def read_document(path: str | Path, what: str = "scene") -> Mapping[str, Any]:
    """The tables of a TOML file, or of the standard input for ``-``; ``what`` it is to be.

    Raises ValueError, in one line, for what is none.
    """
    from longwave.support.user_files import read_toml, shown_path

    try:
        return read_toml(path, what, LARGEST_FILE)
    except OSError as error:
        raise ValueError(
            f"{what} must be a file that can be read, got {shown_path(path)}: {error.strerror} "
            f"(or the name of a shipped {what})"
        ) from None


def parse_document(content: bytes, source: str) -> Mapping[str, Any]:
    """The tables of TOML from ``source``; ValueError, in one line, for what is none."""
    from longwave.support.user_files import parse_toml

    return parse_toml(content, source, "scene")


def scene_fields(document: Mapping[str, Any]) -> dict[str, Any]:
    """Flatten a parsed document into the scene's fields, refusing unknown keys.

    >>> scene_fields({"colour": 3})
    Traceback (most recent call last):
    ...
    ValueError: keys must be known ones, got colour (one of name, title, ..., domain, parameters)
    """
    if "disorder" in document:
        raise ValueError(
            "disorder must be in a scene that names its lattice, got one with constants alone "
            '(lattice = "fput_strain", with K2, K3 and K4 in [constants])'
        )
    refuse_unknown(document, (*TOP, *TABLES, "parameters"), "")
    fields = {key: document[key] for key in TOP if key in document}
    for name, renamed in TABLES.items():
        entries = table(document, name)
        refuse_unknown(entries, tuple(renamed), f" in [{name}]")
        fields |= {renamed[key]: value for key, value in entries.items()}
    required = REQUIRED if "tolerance" in fields else (*REQUIRED, *STATED)
    missing = [key for key in required if key not in fields]
    if missing:
        remedy = " or a tolerance" if missing[0] in STATED else ""
        raise ValueError(f"{_where(missing[0])} must be stated, got nothing (state it{remedy})")
    fields["parameters"] = tuple(table(document, "parameters").items())
    return fields


def document_of(fields: Mapping[str, Any]) -> dict[str, Any]:
    """The document of a scene with these fields: what `scene_fields` makes them of.

    >>> document_of({"wave": "kink", "K2": 1, "step": None, "parameters": [["A", 1]]})
    {'wave': 'kink', 'lattice': {'K2': 1}, 'parameters': {'A': 1}}
    """
    given = {k: value for k, value in fields.items() if value not in (None, "") or k == "name"}
    found = {key: given[key] for key in TOP if key in given}
    for name, renamed in TABLES.items():
        entries = {key: given[field] for key, field in renamed.items() if field in given}
        found |= {name: entries} if entries else {}
    parameters = dict(given["parameters"])
    return found | ({"parameters": parameters} if parameters else {})


def table(document: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """The table of that name, empty if there is none; ValueError if it is something else."""
    found = document.get(name, {})
    if not isinstance(found, Mapping):
        raise ValueError(f"{name} must be a table, got {shown(found)} (write [{name}])")
    return found


def _where(field: str) -> str:
    for name, renamed in TABLES.items():
        for key, target in renamed.items():
            if target == field:
                return f"{key} in [{name}]"
    return field


def refuse_unknown(entries: Mapping[str, Any], known: tuple[str, ...], where: str) -> None:
    """Refuse keys that are not known, ``where`` saying in which table they are."""
    for key in entries:
        if key not in known:
            raise ValueError(
                f"keys{where} must be known ones, got {plain(key)} (one of {', '.join(known)})"
            )
