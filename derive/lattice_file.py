"""A lattice from a TOML file: fields, masses, springs, on-site forces, or bonds of any stencil.

    name = "mass_in_mass"
    fields = ["u", "v"]
    masses = ["m1", "m2"]
    positive = ["K2", "g", "m1", "m2"]      # all other constants are real

    [[spring]]
    between = ["u[n]", "u[n+1]"]
    force = "K2*x + K4*x**3"                # of the stretch x: any smooth function

    [[spring]]
    between = ["u[n]", "v[n]"]
    force = "g*sinh(x)"

    [[site]]
    field = "u"
    force = "h*x"

    [[bond]]                                # its stretch, and where its force F acts
    stretch = "y[n]"
    action = {y = "F[n+1] - 2*F[n] + F[n-1]"}
    force = "K2*x + K3*x**2"

    [constants]                             # measured values; the constants remain symbols
    K2 = 1.0

    [covariance]                            # of their errors; missing entries are 0
    K2 = {K2 = 1e-4}

A small constant is written with its power of eps, as in ``force = "K2*x + eps*k3*x**2"``.
Two axes are ``u[n, m+1]``.  Formulas are parsed with a whitelist, never evaluated.
"""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import sympy as sp

from longwave.derive.algebra.contact import contact
from longwave.derive.algebra.exact_numbers import exact
from longwave.derive.algebra.formula_expression import read_formula
from longwave.derive.algebra.formula_printing import formula_as_text
from longwave.derive.algebra.formula_text import Vocabulary
from longwave.derive.lattice import Bond, Cell, Lattice, Stencil, on_site, spring
from longwave.derive.measured import Measured
from longwave.derive.models.lattices import LATTICES
from longwave.derive.symbols import check_names, eps, x
from longwave.support.known_names import one_of
from longwave.support.user_files import STANDARD_INPUT, file_stem, read_toml, shown, shown_path

LARGEST_FILE = 100_000
"""Largest size of a file, in bytes."""

MAX_ENTRIES = 50
"""Most tables of one kind in a file: [[spring]], [[site]] or [[bond]]."""

LONGEST_NAME = 30
"""Longest name of a field or constant, in characters."""

LONGEST_TITLE = 200
"""Longest name or title of a lattice, in characters."""

SMOOTH = (
    *(sp.exp, sp.log, sp.sqrt, sp.sin, sp.cos, sp.tan, sp.sinh, sp.cosh, sp.tanh, sp.sech),
    *(sp.atan, sp.asinh, contact),
)
FUNCTIONS = {function.__name__: (function, 1) for function in SMOOTH}

KEYS = {
    "": {"name", "title", "fields", "masses", "positive", "spring", "site", "bond"}
    | {"constants", "covariance"},
    "spring": {"between", "force"},
    "site": {"field", "force"},
    "bond": {"stretch", "action", "force"},
}
"""Kind of table -> its allowed keys; "" is the top of the file."""

_TERM = re.compile(
    r"\s*([+-]?)\s*(?:(\d{1,6})\s*\*\s*)?([A-Za-z][A-Za-z0-9]*)\[\s*n\s*([+-]\s*\d{1,6})?\s*"
    r"(?:,\s*m\s*([+-]\s*\d{1,6})?\s*)?\]\s*",
    re.ASCII,
)


def read_lattice(path: Path) -> Lattice:
    """Read a lattice from a file, or from the standard input for ``-``.

    Raises ValueError, with the file and the entry, for an invalid lattice; OSError if the file
    cannot be read.
    """
    document = read_toml(path, "lattice", LARGEST_FILE)
    try:
        return lattice_of(document, file_stem(path))
    except ValueError as error:
        raise ValueError(f"{shown_path(path.name)}: {error}") from None


def lattice_of(document: Mapping[str, Any], name: str = "lattice") -> Lattice:
    """Return the lattice that the tables of a file describe.

    >>> spring = {"between": ["u[n]", "u[n+1]"], "force": "K2*x"}
    >>> lattice_of({"fields": ["u"], "positive": ["K2"], "spring": [spring]}).equations()[0]
    "u_n'' = F(u_{n+1} - u_n) - F(u_n - u_{n-1})"
    """
    _check_keys(document, "")
    fields = _texts(document, "fields")
    positive = _texts(document, "positive", required=False)
    check_names("positive", positive)
    for word in (*fields, "pi", "I"):
        if word in positive:
            kind = "a field" if word in fields else "a number"
            raise ValueError(
                f"positive must name constants, got {word}, {kind} (write another name)"
            )
    symbols = _Symbols(set(positive))
    masses = [symbols.mass(f"masses[{i}]", m) for i, m in enumerate(_masses(document, fields))]
    springs = _bonds(document, "spring", partial(_spring, fields=fields, symbols=symbols))
    others = _bonds(document, "bond", partial(_bond, fields=fields, symbols=symbols))
    axes = max((len(bond.stretch[0].shift) for bond in (*springs, *others)), default=1)
    sites = _bonds(document, "site", partial(_site, fields=fields, symbols=symbols, axes=axes))
    bonds = [*springs, *sites, *others]
    if not bonds:
        raise ValueError("bonds must be given, got none (write a [[spring]])")
    lattice_name = _title("name", document.get("name", name))
    title = _title("title", document.get("title", lattice_name))
    lattice = Lattice(lattice_name, title, tuple(fields), tuple(masses), tuple(bonds))
    return replace(lattice, measured=_measured(document, lattice))


def _bonds(
    document: Mapping[str, Any], kind: str, build: Callable[[Mapping[str, Any]], Bond]
) -> list[Bond]:
    """Build the bonds of all [[kind]] tables; errors name the kind and number of the table."""
    entries = document.get(kind, [])
    if not isinstance(entries, list) or len(entries) > MAX_ENTRIES:
        raise ValueError(
            f"{kind} must be [[{kind}]] tables, at most {MAX_ENTRIES}, got {shown(entries)}"
        )
    bonds = []
    for number, entry in enumerate(entries, 1):
        _check_keys(entry, kind)
        try:
            bonds.append(build(entry))
        except ValueError as error:
            raise ValueError(f"[[{kind}]] {number}: {error}") from None
    return bonds


def document_of_lattice(lattice: Lattice) -> dict[str, Any]:
    """Return the tables of a lattice without losses, from which `lattice_of` rebuilds it.

    >>> from longwave.derive import LATTICES
    >>> document_of_lattice(LATTICES["toda"])["bond"][0]["stretch"]
    '+1*u[n+1] -1*u[n+0]'
    """

    def sum_of(entries: tuple[Stencil, ...], name: str = "") -> str:
        axes = [zip("nm", entry.shift, strict=False) for entry in entries]
        cells = [",".join(f"{axis}{step:+d}" for axis, step in pairs) for pairs in axes]
        return " ".join(
            f"{entry.weight:+d}*{name or lattice.fields[entry.field]}[{cell}]"
            for entry, cell in zip(entries, cells, strict=True)
        )

    def action_of(bond: Bond) -> dict[str, str]:
        ends = [[e for e in bond.action if e.field == i] for i in range(len(lattice.fields))]
        pairs = zip(lattice.fields, ends, strict=True)
        return {field: sum_of(tuple(entries), "F") for field, entries in pairs if entries}

    return {
        "fields": list(lattice.fields),
        "masses": [formula_as_text(mass) for mass in lattice.masses],
        "positive": [str(symbol) for symbol in lattice.constants if symbol.is_positive],
        "bond": [
            {
                "stretch": sum_of(bond.stretch),
                "action": action_of(bond),
                "force": formula_as_text(bond.force),
            }
            for bond in lattice.bonds
        ],
    }


def _measured(document: Mapping[str, Any], lattice: Lattice) -> Measured | None:
    """Return the file's values of constants, with their covariance; None for a file without any."""
    values, rows = (_table(key, document.get(key, {})) for key in ("constants", "covariance"))
    if not values and not rows:
        return None
    lattice.with_values(values)
    covariance = {name: _table(f"{name} in [covariance]", row) for name, row in rows.items()}
    return Measured.of(values, covariance)


def _table(label: str, value: object) -> Mapping[str, Any]:
    if not isinstance(value, Mapping) or len(value) > MAX_ENTRIES:
        raise ValueError(
            f"{label} must be a table by constants' names, at most {MAX_ENTRIES}, got "
            f"{shown(value)} (such as {{K2 = 1}})"
        )
    return value


def force_of_text(text: str, label: str) -> sp.Expr:
    """Parse a force in the stretch x and real constants; ``label`` names it in errors.

    >>> force_of_text("K2*x + g*sinh(x)", "force")
    K2*x + g*sinh(x)
    """
    return _Symbols(set()).formula(label, text)


def _title(label: str, text: object) -> str:
    """Return a name or title. Raises ValueError unless it is one short printable line."""
    if not isinstance(text, str) or not text.isprintable() or len(text) > LONGEST_TITLE:
        words = f"one printable line of {LONGEST_TITLE} characters at most"
        raise ValueError(f"{label} must be {words}, got {shown(text)} (such as 'my chain')")
    return text


class _Symbols:
    """Constants by name, positive or real; parser of formulas with these constants."""

    def __init__(self, positive: set[str]) -> None:
        self.positive = positive
        self.known: dict[str, sp.Symbol] = {}

    def symbol(self, name: str) -> sp.Symbol:
        """Return the symbol of a constant; eps is the small parameter."""
        if name == str(eps):
            return eps
        sign = {"positive" if name in self.positive else "real": True}
        return self.known.setdefault(name, sp.Symbol(name, **sign))

    def mass(self, label: str, given: Any) -> sp.Expr:
        """Return a mass from a formula or a number; a float keeps its decimal value."""
        return exact(label, given) if isinstance(given, float) else self.formula(label, given)

    def formula(self, label: str, text: Any) -> sp.Expr:
        """Parse a formula in the stretch x and constants."""
        if isinstance(text, int) and not isinstance(text, bool):
            return sp.Integer(text)
        if not isinstance(text, str):
            raise ValueError(f"{label} must be text, got {shown(text)} (write it in quotes)")
        words = Vocabulary(FUNCTIONS, {"x": x}, unknown_name=self.symbol)
        return read_formula(text, words, label)


def time_formula(label: str, text: object) -> sp.Expr:
    """Parse a formula in the time t, which becomes the symbol x; ValueError for any other name."""
    if isinstance(text, int | float) and not isinstance(text, bool):
        return sp.nsimplify(text, rational=True) if math.isfinite(text) else sp.nan
    if not isinstance(text, str):
        raise ValueError(f"{label} must be a formula in t, got {shown(text)} (write it in quotes)")
    smooth = {name: known for name, known in FUNCTIONS.items() if name != contact.__name__}
    return read_formula(text, Vocabulary(smooth, {"t": x}), label)


def _check_keys(table: object, kind: str) -> None:
    known = KEYS[kind]
    if not isinstance(table, Mapping):
        raise ValueError(f"[[{kind}]] must be a table, got {shown(table)} (write KEY = VALUE)")
    for key in table:
        if key not in known:
            suggestion = one_of(key, sorted(known))
            raise ValueError(f"keys must be known ones, got {shown(key)} ({suggestion})")


def _texts(document: Mapping[str, Any], key: str, *, required: bool = True) -> list[str]:
    names = document.get(key, None if required else [])
    entries = names if isinstance(names, list) else [None]
    are_texts = all(isinstance(text, str) and len(text) <= LONGEST_NAME for text in entries)
    if not are_texts or (required and not names) or len(names) > MAX_ENTRIES:
        raise ValueError(f'{key} must be a list of names, got {shown(names)} (such as ["u"])')
    return list(names)


def _masses(document: Mapping[str, Any], fields: list[str]) -> list[Any]:
    masses = document.get("masses", [1] * len(fields))
    if not isinstance(masses, list) or len(masses) != len(fields):
        raise ValueError(
            f"masses must be a list of {len(fields)}, one a field, got {shown(masses)} "
            '(such as ["m1", "m2"])'
        )
    return list(masses)


def _terms(label: str, text: object) -> list[tuple[int, str, Cell]]:
    """Return weight, name and cell of each term of a sum such as ``F[n+1] - 2*F[n]``."""
    if not isinstance(text, str) or len(text) > 1000:
        raise ValueError(f"{label} must be a short text, got {shown(text)} (such as u[n+1])")
    terms: list[tuple[int, str, Cell]] = []
    position = 0
    while position < len(text):
        match = _TERM.match(text, position)
        if match is None or (terms and not match[1]):
            raise ValueError(
                f"{label} must be a sum of sites such as F[n+1] - 2*F[n], got "
                f"{shown(text)} (weights are whole numbers: put a factor into the force, that of "
                "one end alone into the force of a [[bond]] of its own)"
            )
        sign, weight, name, n_step, m_step = match.groups()
        steps = [int((step or "0").replace(" ", "")) for step in (n_step, m_step)]
        cell = tuple(steps) if "," in match[0] else tuple(steps[:1])
        terms.append((int(f"{sign}{weight or 1}"), name, cell))
        position = match.end()
    if not terms:
        raise ValueError(f"{label} must name a site, got {shown(text)} (such as u[n+1])")
    return terms


def _field(label: str, name: object, fields: list[str]) -> int:
    if name not in fields:
        raise ValueError(
            f"{label} must be among {', '.join(fields)}, got {shown(name)} (or add it to fields)"
        )
    return fields.index(str(name))


def _spring(entry: Mapping[str, Any], fields: list[str], symbols: _Symbols) -> Bond:
    between = entry.get("between")
    if not isinstance(between, list) or len(between) != 2:
        raise ValueError(f'between must be two sites, got {shown(between)} (["u[n]", "u[n+1]"])')
    ends = []
    for text in between:
        terms = _terms("between", text)
        if len(terms) != 1 or terms[0][0] != 1:
            raise ValueError(f"between must be two sites, got {shown(text)} (such as u[n+1])")
        _, name, cell = terms[0]
        ends.append((cell, _field("between", name, fields)))
    return spring(symbols.formula("force", entry.get("force")), ends[0], ends[1])


def _site(entry: Mapping[str, Any], fields: list[str], symbols: _Symbols, axes: int) -> Bond:
    index = _field("field", entry.get("field"), fields)
    return on_site(symbols.formula("force", entry.get("force")), index, axes)


def _bond(entry: Mapping[str, Any], fields: list[str], symbols: _Symbols) -> Bond:
    action = entry.get("action")
    if not isinstance(action, Mapping) or not action:
        raise ValueError(f'action must name fields, got {shown(action)} ({{u = "F[n] - F[n-1]"}})')
    terms = _terms("stretch", entry.get("stretch"))
    stretch = tuple(Stencil(cell, w, _field("stretch", name, fields)) for w, name, cell in terms)
    ends = []
    for name, text in action.items():
        for weight, force, cell in _terms("action", text):
            if force != "F":
                raise ValueError(
                    f"action must be a sum of F, the bond's force, got {shown(text)} (such as "
                    "F[n] - F[n-1])"
                )
            ends.append(Stencil(cell, weight, _field("action", name, fields)))
    return Bond(stretch, symbols.formula("force", entry.get("force")), tuple(ends))


def find_lattice(model: str) -> Lattice:
    """Return the lattice called ``model``, or read it from a file or the standard input ("-").

    Raises ValueError for an unknown name and as `read_lattice`.
    """
    if model in LATTICES:
        return LATTICES[model]
    if model.endswith(".toml") or model == STANDARD_INPUT:
        return read_lattice(Path(model))
    raise ValueError(
        f"MODEL must be a lattice or a file of one, got {shown(model)} "
        f"({one_of(model, LATTICES)}; or FILE.toml)"
    )
