"""Scene files: TOML with a whitelist of keys.

    name, title, lattice, wave, eps, order, t0, snapshots, times, slow_times, compared, half_width,
    observables, curve_points, look_points, tolerance, engine
    [constants]   of the lattice: numbers, or formulas in text, which may contain eps
    [parameters]  of the wave: numbers, or formulas in text such as "K/2", "1/3"
    [long_wave]   amplitude, time (powers of eps), background (a mean strain); all optional
    [envelope]    k (the carrier's wavenumber, such as "pi/2"), branch
    [disorder]    of, spread, seed, distribution, sites: see `scene_disorder.py`
    [losses]      site, bond: see `losses.py`
    [scheme]      name, step
    [domain]      kind, sites

A chain on a bench has the tables of `bench.py` instead of a wave.

``lattice`` is a name of the catalogue, a lattice's file in the scene's folder, or a table with the
keys of such a file; a table of K2, K3 and K4 stands for the paper's chain. Constants that are not
stated are taken from the lattice's file. ``compared`` may also be in [domain]. A scene with a
tolerance states no step, kind or sites. The default name is that of the file.
"""

import json
import re
from collections.abc import Mapping
from numbers import Integral, Real
from pathlib import Path
from typing import Any

from longwave.scenes.description import scene_checks as check
from longwave.scenes.description.bench import BENCH_TABLES
from longwave.scenes.description.csv_table import with_columns
from longwave.scenes.description.scene_disorder import Disorder
from longwave.scenes.description.stated_tables import StatedTables
from longwave.support.user_files import read_toml, shown, shown_path

TOP_KEYS = (
    *("name", "title", "lattice", "wave", "eps", "order", "t0", "snapshots", "times"),
    *("slow_times", "compared", "half_width", "observables", "curve_points", "look_points"),
    *("tolerance", "engine"),
)
PAIR_TABLES = ("constants", "parameters")
"""Tables whose keys depend on the lattice or the wave."""

TABLE_FIELDS = {
    "long_wave": {"amplitude": "amplitude", "time": "time", "background": "background"},
    "envelope": {"k": "carrier", "branch": "branch"},
    "scheme": {"name": "scheme", "step": "step"},
    "domain": {"kind": "domain", "sites": "sites", "compared": "compared"},
}
"""Field of `Scene` for each key of the tables of a scene file, by table."""

LATTICE_KEYS = ("fields", "masses", "positive", "spring", "site", "bond")
"""Keys of a table that declares a lattice, which has at least one of them."""

NEEDED = {"step": "step in [scheme]", "domain": "kind in [domain]", "sites": "sites in [domain]"}
"""Fields required without a tolerance, each with its key and table in a scene file."""

MAX_SCENE_BYTES = 1_000_000
"""Maximum size of a scene's file, in bytes."""


def read_document(path: str | Path, what: str = "scene") -> Mapping[str, Any]:
    """Return the tables of a TOML file, or of the standard input for ``-``.

    Raises ValueError for a file that cannot be read; ``what`` is the word for it in the message.
    """
    try:
        return read_toml(path, what, MAX_SCENE_BYTES)
    except OSError as error:
        raise ValueError(
            f"{what} must be a file that can be read, got {shown_path(path)}: {error.strerror} "
            f"(or the name of a shipped {what})"
        ) from None


def in_one_spelling(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return an equivalent document that names the paper's chain and has ``compared`` at the top.

    >>> in_one_spelling({"lattice": {"K2": 1, "K4": 2}, "domain": {"compared": 9}})
    {'lattice': 'fput_strain', 'constants': {'K2': 1, 'K4': 2}, 'compared': 9}
    """
    tables = dict(document)
    lattice = tables.get("lattice")
    if isinstance(lattice, Mapping) and not any(key in lattice for key in LATTICE_KEYS):
        check.refuse_unknown(lattice, check.CHAIN_CONSTANTS, " in [lattice]")
        if check.table(document, "constants"):
            raise ValueError(
                "K2, K3 and K4 must be in [constants] or in [lattice], got both (leave one out)"
            )
        tables |= {"lattice": check.CHAIN, "constants": dict(lattice)}
    domain = tables.get("domain")
    if isinstance(domain, Mapping) and "compared" in domain:
        if "compared" in tables:
            raise ValueError("compared must be given once, got it in [domain], too (leave one out)")
        rest = {key: value for key, value in domain.items() if key != "compared"}
        tables.pop("domain")
        tables |= ({"domain": rest} if rest else {}) | {"compared": domain["compared"]}
    return tables


def scene_fields(given: Mapping[str, Any], folder: Path = Path()) -> dict[str, Any]:
    """Return the keywords of `Scene.of` for a parsed document; files are looked up in ``folder``.

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
    known = (*TOP_KEYS, *PAIR_TABLES, *TABLE_FIELDS, "disorder", "losses", *BENCH_TABLES)
    for name, fields in TABLE_FIELDS.items():
        for key in sorted(document.keys() & fields.keys() - set(known)):
            raise ValueError(
                f"{key} must be in [{name}], got it at the top of the scene (write it below a line "
                f"[{name}])"
            )
    check.refuse_unknown(document, known)
    keywords = {key: document[key] for key in TOP_KEYS if key in document}
    keywords |= with_columns(
        {key: document[key] for key in BENCH_TABLES if key in document}, folder
    )
    keywords |= _lattice(document.get("lattice"), folder)
    keywords |= {name: tuple(check.table(document, name).items()) for name in PAIR_TABLES}
    declared = keywords.get("declared")
    of_lattice = check.table(declared.tables, "constants") if declared else {}
    keywords["constants"] = tuple({**of_lattice, **dict(keywords["constants"])}.items())
    for name, fields in TABLE_FIELDS.items():
        entries = check.table(document, name)
        check.refuse_unknown(entries, fields, f" in [{name}]")
        keywords |= {fields[key]: value for key, value in entries.items()}
    if "losses" in document:
        keywords["losses"] = check.table(document, "losses")
    if "disorder" in document:
        keywords["disorder"] = Disorder.of_pairs(check.table(document, "disorder"))
    if "envelope" in document and keywords.get("carrier", "") == "":
        raise ValueError('k in [envelope] must be stated, got nothing (such as k = "pi/2")')
    if "long_wave" in document and "envelope" in document:
        raise ValueError("[long_wave] must not be given with [envelope], got both (leave one)")
    if "tolerance" not in keywords and keywords.keys() & {"chain", "start"}:
        raise ValueError(
            "tolerance must be stated, got nothing (such as tolerance = 1e-8, for the observables)"
        )
    missing = [where for key, where in NEEDED.items() if key not in keywords]
    if missing and "tolerance" not in keywords:
        raise ValueError(f"{missing[0]} must be stated, got nothing (state it or a tolerance)")
    return keywords


def _lattice(given: object, folder: Path) -> dict[str, Any]:
    """Return the keywords of `Scene.of` for a lattice given by name, file or table."""
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
    """Return the keywords of `Scene.of` for a `derive.Lattice`, or a lattice file's tables.

    >>> from longwave.derive import LATTICES
    >>> lattice_keywords(LATTICES["toda"])
    {'lattice': 'toda'}
    """
    if isinstance(given, Mapping):
        return _declaration(given, "lattice")
    from longwave.derive import LATTICES, Lattice  # slow import
    from longwave.derive.lattice_file import document_of_lattice

    if not isinstance(given, Lattice):
        raise ValueError(
            f"lattice must be a name, a Lattice or its tables, got {shown(given)} (such as 'toda')"
        )
    if LATTICES.get(given.name) == given:
        return {"lattice": given.name}
    return _declaration(document_of_lattice(given), given.name)


def _declaration(document: Mapping[str, Any], name: str) -> dict[str, Any]:
    """Return the keywords of `Scene.of` for a lattice's tables; ``name`` is the default name."""
    tables = dict(document)
    lattice_name = tables.pop("name", name)
    check.text("name in [lattice]", lattice_name)
    return {"lattice": lattice_name, "declared": StatedTables(tables, "lattice")}


def document_of(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return a document from which `scene_fields` reads these keywords: its inverse.

    >>> document_of({"wave": "kink", "constants": [["K2", 1]], "step": None, "sites": 8})
    {'lattice': 'fput_strain', 'wave': 'kink', 'constants': {'K2': 1}, 'domain': {'sites': 8}}
    """
    given = {"lattice": check.CHAIN} | {k: v for k, v in given.items() if v is not None}
    document = {key: given[key] for key in TOP_KEYS if key in given}
    if "declared" in given:
        document["lattice"] = {"name": given["lattice"], **given["declared"].tables}
    document |= {name: dict(given[name]) for name in PAIR_TABLES if name in given}
    document |= {"disorder": dict(given["disorder"].pairs)} if "disorder" in given else {}
    document |= {"losses": given["losses"].table} if "losses" in given else {}
    document |= given["bench"].stated.tables if "bench" in given else {}
    for name, fields in TABLE_FIELDS.items():
        entries = {k: given[field] for k, field in fields.items() if field in given}
        entries.pop("compared", None)
        document |= {name: entries} if entries else {}
    return document


_BARE = re.compile(r"[A-Za-z0-9_-]+")


def toml_text(document: Mapping[str, object]) -> str:
    """Return the document as TOML: values first, then tables, whose inner tables are inline.

    Parsing the text returns an equal document, with numbers equal to the last bit. Values must be
    strings, booleans, numbers, lists or tables; ValueError for any other.

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


def _text(value: str) -> str:
    """Return a text quoted for TOML: as in JSON, but with DEL escaped as well."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
