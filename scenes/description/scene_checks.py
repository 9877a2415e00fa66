"""What each field of a scene may be, and the reader of tables: a new key is one `Entry`.

A check raises ValueError in one line: argument, condition, value, remedy.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any, TypeAlias

from longwave.support import known_names
from longwave.support.user_files import cut, shown

Value: TypeAlias = "int | float | str"
"""A number, or a formula in text such as "1/3", "sqrt(2)" or "K/2"."""

Pairs: TypeAlias = "tuple[tuple[str, Value], ...]"
"""Names and values."""

CHAIN = "fput_strain"
"""The paper's lattice, which K2, K3, K4 alone stand for."""

CHAIN_CONSTANTS = ("K2", "K3", "K4")

NOT_GIVEN = -math.inf
"""The start of a scene that gives slow times."""

ORDERS = ("leading", "slaved", "corrected")
"""What the data hold: the wave alone; the fields that follow it too; the next order as well."""

MOST_STEPS = 1e10

LONGEST_FORMULA = 200
"""Characters of a value in text."""

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
    "times": "[0, 100]: the first is the start",
    "slow_times": "[0, 1]: the first is the start",
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

STATED = object()
"""The usual value of a key that must be stated."""


@dataclass(frozen=True)
class Entry:
    """A key of a table: what reads a value, given its name, what it says, the usual value.

    Messages call it ``name``, unless that is "KEY in [TABLE]", and say in ``remedy`` what to state.
    A record has it as ``field``, unless that is the key. The usual value None is read, too.
    """

    read: Callable[[str, Any], Any]
    says: str
    usual: Any = STATED
    name: str = ""
    field: str = ""
    remedy: str = "state it"


def read_table(
    name: str, entries: Mapping[str, Entry], given: object, where: str = ""
) -> dict[str, Any]:
    """The values that a table states, in its order, and the usual ones, by the fields of a record.

    >>> read_table("noise", {"seed": Entry(whole, "of draws", 0)}, {})
    {'seed': 0}
    """
    stated = as_table(name, given)
    refuse_unknown(stated, entries, f" in [{name}]")
    found = {}
    for key in dict.fromkeys((*stated, *entries)):
        entry = entries[key]
        label, value = entry.name or key + (where or f" in [{name}]"), stated.get(key, entry.usual)
        if value is STATED:
            raise ValueError(f"{label} must be stated, got nothing ({entry.remedy})")
        is_read = key in stated or value is None
        found[entry.field or key] = entry.read(label, value) if is_read else value
    return found


def table(document: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    """The table of that name, empty if there is none; ValueError if it is something else."""
    return as_table(name, document.get(name, {}))


def as_table(name: str, given: object) -> Mapping[str, Any]:
    """The value of that name, if it is a table."""
    if not isinstance(given, Mapping):
        raise ValueError(f"{name} must be a table, got {shown(given)} (write [{name}])")
    return given


def refuse_unknown(
    given: Iterable[str], known: Iterable[str], where: str = "", what: str = "keys"
) -> None:
    """Refuse keys that are not known, ``where`` saying in which table they are."""
    for key in given:
        if key not in known:
            remedy = known_names.one_of(key, known)
            raise ValueError(f"{what}{where} must be known ones, got {plain(key)} ({remedy})")


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


def positive(name: str, value: object) -> float:
    """The value as a float, if it is a finite number above 0."""
    number = finite(name, value)
    if number <= 0:
        raise ValueError(f"{name} must satisfy {name} > 0, got {number:g}{_remedy(name)}")
    return number


def tolerance(given: object) -> float:
    """The tolerance as a float, if it is positive and not below rounding."""
    value = positive("tolerance", given)
    if value < LEAST_TOLERANCE:
        raise ValueError(
            f"tolerance must satisfy tolerance >= {LEAST_TOLERANCE:g}, got {value:g} "
            "(rounding alone makes as much in a long run)"
        )
    return value


def whole(name: str, value: object, least: int = 1, most: float = LARGEST) -> int:
    """The value as an int, if it is a whole number, from 1 to what some memory holds or as told."""
    is_whole = isinstance(value, Integral) and not isinstance(value, bool)
    if not is_whole or not least <= int(value) <= most:  # type: ignore[call-overload]
        raise ValueError(
            f"{name} must be a whole number, {least:g} <= {name} <= {most:g}, got {shown(value)}"
            f"{_remedy(name)}"
        )
    return int(value)  # type: ignore[call-overload]


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


def text(name: str, value: object) -> str:
    """The value, if it is a text that a file can hold: one without halves of signs."""
    if not isinstance(value, str):
        raise ValueError(f"{name} must be a text, got {shown(value)} (write it in quotes)")
    if any("\ud800" <= sign <= "\udfff" for sign in value):
        raise ValueError(f"{name} must be a text in Unicode, got {shown(value)} (name it anew)")
    return value


def closed_form(value: object) -> None:
    """Refuse what is no closed form."""
    from longwave.solutions import ClosedForm  # only a wave that is not named needs formulas

    if not isinstance(value, ClosedForm):
        raise ValueError(
            f"wave must be a text or a ClosedForm, got {shown(value)} (such as 'rogue_cn')"
        )


def one_of(name: str, value: object, known: tuple[str, ...]) -> str:
    """The value, if it is a known word."""
    if not isinstance(value, str) or value not in known:
        raise ValueError(
            f"{name} must be a known one, got {shown(value)} ({known_names.one_of(value, known)})"
        )
    return value


def times(name: str, values: object, least: int = 1, start: float = -math.inf) -> tuple[float, ...]:
    """Increasing times from ``start`` on: one, or two, at the least."""
    values = values.tolist() if hasattr(values, "tolist") else values  # an array of NumPy's
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
    """Known names."""
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
    """A finite number, whole if it is, or a short text."""
    if isinstance(given, str):
        if len(given) > LONGEST_FORMULA:
            raise ValueError(
                f"{name} must be a short formula, got {len(given)} characters (such as 1/3)"
            )
        return text(name, given)
    number = finite(name, given)
    return int(number) if abs(number) < FARTHEST_SITE and number.is_integer() else number


def pairs(name: str, given: object) -> Pairs:
    """Pairs of names and values, from a mapping or such pairs."""
    found = list(given.items()) if isinstance(given, Mapping) else given
    if not isinstance(found, list | tuple) or not all(
        isinstance(pair, list | tuple) and len(pair) == 2 for pair in found
    ):
        usual = '{"k": 0.5}' if name == "parameters" else '{"K2": 1}'
        raise ValueError(
            f"{name} must be pairs of names and values, got {shown(given)} (such as {usual})"
        )
    checked = tuple((str(key), value(str(key), entry)) for key, entry in found)
    differing(name, checked)
    return checked


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
    return cut(str(key), 60)


def _remedy(name: str) -> str:
    return f" (such as {USUAL.get(name, '0.5')})"
