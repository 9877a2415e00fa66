"""Checks of a scene's fields; each raises ValueError in one line: argument, condition, value."""

import math
from collections.abc import Mapping

from verify.lattice.observables import NAMES


def finite(name: str, value: object) -> float:
    """The value as a float, if it is a finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{name} must be a number, got {value!r}")
    if not math.isfinite(value):
        raise ValueError(f"{name} must be finite, got {value}")
    return float(value)


def positive(name: str, value: float) -> None:
    """Refuse what is not positive."""
    if value <= 0:
        raise ValueError(f"{name} must satisfy {name} > 0, got {value:g}")


def whole(name: str, value: object) -> None:
    """Refuse what is not a whole number >= 1."""
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise ValueError(f"{name} must be a whole number >= 1, got {value!r}")


def one_of(name: str, value: object, known: tuple[str, ...]) -> None:
    """Refuse a word that is not known."""
    if value not in known:
        raise ValueError(f"{name} must be one of {', '.join(known)}, got {value!r}")


def times(values: object, t0: float) -> tuple[float, ...]:
    """Increasing times from t0 on."""
    if not isinstance(values, list | tuple) or not values:
        raise ValueError(f"snapshots must be a list of at least one time, got {values!r}")
    checked = tuple(finite("snapshots", value) for value in values)
    if min(checked) < t0:
        raise ValueError(
            f"snapshots must satisfy t >= t0 = {t0:g}, got {min(checked):g} (start earlier)"
        )
    if list(checked) != sorted(set(checked)):
        raise ValueError(f"snapshots must increase, got {list(checked)}")
    return checked


def observables(values: object) -> tuple[str, ...]:
    """Known observables."""
    if not isinstance(values, list | tuple):
        raise ValueError(f"observables must be a list of names, got {values!r}")
    for value in values:
        one_of("observables", value, NAMES)
    return tuple(values)


def parameters(
    values: Mapping[str, float | str] | tuple[tuple[str, float | str], ...],
) -> tuple[tuple[str, float | str], ...]:
    """The wave's parameters as pairs: finite numbers, or texts that `quantity.py` reads."""
    pairs = values.items() if isinstance(values, Mapping) else values
    return tuple(
        (str(name), value if isinstance(value, str) else finite(str(name), value))
        for name, value in pairs
    )
