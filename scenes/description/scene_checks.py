"""Checks of a scene's fields, and a reader of tables whose keys are each declared by a `TableKey`.

A check raises ValueError with a one-line message: argument, condition, value, remedy.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any, TypeAlias

from longwave.support import known_names
from longwave.support.user_files import cut, shown

Value: TypeAlias = "int | float | str"
"""Number, or formula in text such as "1/3", "sqrt(2)" or "K/2"."""

Pairs: TypeAlias = "tuple[tuple[str, Value], ...]"
"""Pairs of name and value."""

CHAIN = "fput_strain"
"""The paper's lattice, which a scene may state by K2, K3, K4 alone."""

CHAIN_CONSTANTS = ("K2", "K3", "K4")

NOT_GIVEN = -math.inf
"""Placeholder for ``t0`` in a scene that states slow times instead."""

ORDERS = ("leading", "slaved", "corrected")
"""Orders of initial data: the wave alone, with slaved fields, or with the first correction."""

MOST_STEPS = 1e10
"""Maximum number of time steps of a run."""

LONGEST_FORMULA = 200
"""Maximum number of characters of a formula."""

EXAMPLES: Mapping[str, str] = {
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
    "times": "[0, 100]: the first is the start",
    "slow_times": "[0, 1]: the first is the start",
}
"""Valid example of each field, shown in the message about a wrong value."""

LEAST_TOLERANCE = 1e-11
"""Least sup error of y/eps distinguishable from rounding errors, measured for Y2 over t = 15000."""

SMALLEST_NUMBER = 1e-50
"""Smallest nonzero magnitude; below it or above its reciprocal, computations may overflow."""

FARTHEST_SITE = 2.0**52
"""Largest site number accepted; up to it, multiples of 1/2 are exact doubles."""

LARGEST_WHOLE = 1e9
"""Largest whole number accepted; more cells would exceed any memory."""

REQUIRED = object()
"""Sentinel: `TableKey.default` of a key that has no default and must be stated."""


@dataclass(frozen=True)
class TableKey:
    """Declaration of a table's key: its check, its meaning and its default value.

    ``read`` takes the key's name and a value, checks the value and returns it. Messages call the
    key ``name``, or "KEY in [TABLE]" if ``name`` is empty, and append ``remedy`` if the key is
    missing. ``field`` is the record's field for the value, by default the key. A default of None is
    passed to ``read``, which may refuse it.
    """

    read: Callable[[str, Any], Any]
    meaning: str
    default: Any = REQUIRED
    name: str = ""
    field: str = ""
    remedy: str = "state it"


def read_table(
    name: str, entries: Mapping[str, TableKey], given: object, where: str = ""
) -> dict[str, Any]:
    """Return the checked values of the table ``name`` by field: stated keys first, then defaults.

    >>> read_table("noise", {"seed": TableKey(whole, "of draws", 0)}, {})
    {'seed': 0}
    """
    stated = as_table(name, given)
    refuse_unknown(stated, entries, f" in [{name}]")
    values = {}
    for key in dict.fromkeys((*stated, *entries)):
        entry = entries[key]
        label = entry.name or key + (where or f" in [{name}]")
        value = stated.get(key, entry.default)
        if value is REQUIRED:
            raise ValueError(f"{label} must be stated, got nothing ({entry.remedy})")
        is_read = key in stated or value is None
        values[entry.field or key] = entry.read(label, value) if is_read else value
    return values


def table(document: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """Return the table ``name`` of a document, empty if absent; ValueError for a non-table."""
    return as_table(name, document.get(name, {}))


def as_table(name: str, given: object) -> Mapping[str, Any]:
    """Return ``given`` if it is a mapping; otherwise raise ValueError, which calls it ``name``."""
    if not isinstance(given, Mapping):
        raise ValueError(f"{name} must be a table, got {shown(given)} (write [{name}])")
    return given


def refuse_unknown(
    given: Iterable[str], known: Iterable[str], where: str = "", what: str = "keys"
) -> None:
    """Raise ValueError for an unknown key; its message calls keys ``what``, the table ``where``."""
    for key in given:
        if key not in known:
            remedy = known_names.one_of(key, known)
            raise ValueError(f"{what}{where} must be known ones, got {plain(key)} ({remedy})")


def finite(name: str, value: object) -> float:
    """Return a finite number as a float; ValueError for other values."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ValueError(f"{name} must be a number, got {shown(value)}{_remedy(name)}")
    number = value if isinstance(value, int) else float(value)
    if not isinstance(number, int) and not math.isfinite(number):
        raise ValueError(f"{name} must be finite, got {value}{_remedy(name)}")
    if number != 0 and not SMALLEST_NUMBER <= abs(number) <= 1 / SMALLEST_NUMBER:
        raise ValueError(
            f"{name} must be 0 or satisfy {SMALLEST_NUMBER:g} <= |{name}| <= "
            f"{1 / SMALLEST_NUMBER:g}, got {shown(value)}{_remedy(name)}"
        )
    return float(number)


def positive(name: str, value: object) -> float:
    """Return a finite number above 0 as a float; ValueError for other values."""
    number = finite(name, value)
    if number <= 0:
        raise ValueError(f"{name} must satisfy {name} > 0, got {number:g}{_remedy(name)}")
    return number


def tolerance(given: object) -> float:
    """Return a tolerance as a float; ValueError unless it is at least `LEAST_TOLERANCE`."""
    value = positive("tolerance", given)
    if value < LEAST_TOLERANCE:
        raise ValueError(
            f"tolerance must satisfy tolerance >= {LEAST_TOLERANCE:g}, got {value:g} "
            "(rounding alone makes as much in a long run)"
        )
    return value


def whole(name: str, value: object, least: int = 1, most: float = LARGEST_WHOLE) -> int:
    """Return a whole number from ``least`` to ``most`` as an int; ValueError for other values."""
    is_whole = isinstance(value, Integral) and not isinstance(value, bool)
    if not is_whole or not least <= int(value) <= most:  # type: ignore[call-overload]
        raise ValueError(
            f"{name} must be a whole number, {least:g} <= {name} <= {most:g}, got {shown(value)}"
            f"{_remedy(name)}"
        )
    return int(value)  # type: ignore[call-overload]


def enough_steps(step: float, duration: float) -> None:
    """Raise ValueError for a step so small that the run would take over `MOST_STEPS` steps."""
    if duration > MOST_STEPS * step:
        raise ValueError(
            f"step must satisfy step >= {duration / MOST_STEPS:.3g} for {duration:g} time units, "
            f"got {step:g} (that would be more than {MOST_STEPS:g} steps)"
        )


def within_reach(speed: float, times: Iterable[float]) -> None:
    """Raise ValueError for times at which a wave of this speed is beyond `FARTHEST_SITE`."""
    farthest = max(map(abs, times))
    if speed * farthest > FARTHEST_SITE:
        raise ValueError(
            f"times must satisfy |t| <= {FARTHEST_SITE / speed:.2g} with the speed of sound "
            f"{speed:.3g}, got {farthest:g} (beyond it sites cannot be told apart)"
        )


def text(name: str, value: object) -> str:
    """Return a text without surrogates, as files cannot store them; ValueError for other values."""
    if not isinstance(value, str):
        raise ValueError(f"{name} must be a text, got {shown(value)} (write it in quotes)")
    if any("\ud800" <= character <= "\udfff" for character in value):
        raise ValueError(f"{name} must be a text in Unicode, got {shown(value)} (rename it)")
    return value


def closed_form(value: object) -> None:
    """Raise ValueError for a value that is not a closed form."""
    from longwave.solutions import ClosedForm  # slow import, only needed for a wave without a name

    if not isinstance(value, ClosedForm):
        raise ValueError(
            f"wave must be a text or a ClosedForm, got {shown(value)} (such as 'rogue_cn')"
        )


def one_of(name: str, value: object, known: tuple[str, ...]) -> str:
    """Return ``value`` if it is one of the ``known`` words; ValueError otherwise."""
    if not isinstance(value, str) or value not in known:
        raise ValueError(
            f"{name} must be a known one, got {shown(value)} ({known_names.one_of(value, known)})"
        )
    return value


def times(name: str, values: object, least: int = 1, start: float = -math.inf) -> tuple[float, ...]:
    """Return increasing times, at least ``least`` (1 or 2), none before ``start``."""
    values = values.tolist() if hasattr(values, "tolist") else values  # NumPy array
    if not isinstance(values, list | tuple) or len(values) < least:
        raise ValueError(
            f"{name} must be a list of at least {('one time', 'two times')[least - 1]}, got "
            f"{shown(values)}{_remedy(name)}"
        )
    checked = tuple(finite(name, value) for value in values)
    if min(checked) < start:
        raise ValueError(
            f"{name} must satisfy t >= t0 = {start:g}, got {min(checked):g} (start earlier)"
        )
    if list(checked) != sorted(set(checked)):
        raise ValueError(f"{name} must increase, got {shown(list(checked))} (sort them)")
    return checked


def names(name: str, values: object, known: tuple[str, ...]) -> tuple[str, ...]:
    """Return a list of different known names as a tuple; ValueError for other values."""
    if not isinstance(values, list | tuple):
        raise ValueError(
            f'{name} must be a list of names, got {shown(values)} (such as ["{known[0]}"])'
        )
    for value in values:
        one_of(name, value, known)
        if list(values).count(value) > 1:
            raise ValueError(f"{name} must have each name once, got {value} twice (leave one out)")
    return tuple(values)


def value(name: str, given: object) -> Value:
    """Return a finite number (an int if whole) or a short formula; ValueError for others."""
    if isinstance(given, str):
        if len(given) > LONGEST_FORMULA:
            raise ValueError(
                f"{name} must be a short formula, got {len(given)} characters (such as 1/3)"
            )
        return text(name, given)
    number = finite(name, given)
    return int(number) if abs(number) < FARTHEST_SITE and number.is_integer() else number


def as_pairs(name: str, given: object, example: str) -> list[tuple[str, Any]]:
    """Return pairs of name and value from a mapping or from pairs; ValueError for others."""
    entries = list(given.items()) if isinstance(given, Mapping) else given
    if not isinstance(entries, list | tuple) or not all(
        isinstance(pair, list | tuple) and len(pair) == 2 for pair in entries
    ):
        raise ValueError(
            f"{name} must be pairs of names and values, got {shown(given)} (such as {example})"
        )
    return [(str(key), entry) for key, entry in entries]


def pairs(where: str, given: object) -> Pairs:
    """Return checked pairs from a mapping or pairs; ValueError for a repeated or invalid name."""
    entries = as_pairs(where, given, '{"k": 0.5}' if where == "parameters" else '{"K2": 1}')
    checked: dict[str, Value] = {}
    for name, entry in entries:
        number = value(name, entry)
        if name in checked:
            raise ValueError(f"{where} must have each name once, got {name} twice (leave one)")
        checked[text(f"name in {where}", name)] = number
    return tuple(checked.items())


def plain(key: object) -> str:
    """Return a key as shown in a message: shortened, without quotes."""
    return cut(str(key), 60)


def _remedy(name: str) -> str:
    return f" (such as {EXAMPLES.get(name, '0.5')})"
