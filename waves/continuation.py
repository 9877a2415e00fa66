"""Continuation of an approximate motion in a parameter, by steps that adapt."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from longwave.waves.kernel.limits import CertificateError

State = TypeVar("State")


def continued(
    state: State,
    solve: Callable[[State, float, float], State],
    *,
    start: float,
    end: float,
    step: float,
    least: float,
    growth: float = 1.5,
) -> State:
    """Return the state at ``end``, from that at ``start``.

    ``solve`` returns the state at a new value, from the state at the one before, and both values. A
    step for which it raises CertificateError is halved; else the next one grows by ``growth``.
    Raises the CertificateError of a step below ``least``.

    >>> continued(1.0, lambda root, before, value: value**0.5, start=1.0, end=4.0, step=1, least=1)
    2.0
    """
    value = start
    while value < end:
        aim = min(value + step, end)
        try:
            state = solve(state, value, aim)
        except CertificateError:
            step /= 2
            if step < least:
                raise
        else:
            value, step = aim, growth * step
    return state
