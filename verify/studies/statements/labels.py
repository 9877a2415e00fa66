"""Whether a statement's label, or a witness, is right: by values at admissible points."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from verify.studies.statements.record import Point, Statement, Truth
from verify.studies.statements.values import ValueMissing, Values, values_at

POINTS = 6
TRIES = 10
DIGITS = (40, 240)
"""Two precisions suffice for most residuals that are no rounding."""

MORE_DIGITS = (*DIGITS, 700, 1400, 6000)
"""Where terms cancel: changes by 10**-200, and witnesses far out: 1 - tanh(1000)."""

SAME = 1e-3
"""Relative difference up to which two values are one; rounding differs by 10**-200 and more."""


def fails_at(statement: Statement, point: Point, digits: Sequence[int] = MORE_DIGITS) -> bool:
    """Whether the statement has a residual at ``point``; raises ValueMissing without a value.

    A residual that is one term by construction is taken from that term where it is small.
    """
    if _is_number(lambda values: values.residual(statement, point), digits[:2]):
        return True
    change = statement.change
    if change is not None:
        return _is_number(lambda values: values.value(change, point), digits)
    return _is_number(lambda values: values.residual(statement, point), digits[1:])


def with_counterexample(statement: Statement, draw: random.Random) -> Statement | None:
    """A false statement with an admissible point that shows it; None if some tries find none."""
    for _ in range(TRIES):
        point = statement.point(draw)
        try:
            if fails_at(statement, point, DIGITS):
                return replace(statement, counterexample=point)
        except ValueMissing:
            continue
    return None


def _is_number(find: Callable[[Values], Any], digits: Sequence[int]) -> bool:
    """Whether ``find`` gives one number other than 0, however small, at two of the precisions.

    Rounding falls with the precision.  Raises ValueMissing if there is a value at none of them.
    """
    before, missing = None, None
    for values in map(values_at, digits):
        try:
            found = find(values)
        except ValueMissing as error:
            missing = error
            continue
        if before is not None and _is_same(before, found):
            return True
        before = found
    if before is None and missing is not None:
        raise missing
    return False


def _is_same(coarse: Any, fine: Any) -> bool:
    return bool(abs(coarse - fine) < SAME * abs(fine))


def label_fault(statement: Statement, points: int = POINTS) -> str | None:
    """What speaks against the label, in words; None if nothing does.

    A true statement's residual must be rounding at every point where it has a value, a false
    one's must not be at its counterexample, and a void one must have no value anywhere.
    """
    if statement.truth is Truth.FALSE:
        return _false_fault(statement)
    draw = random.Random(f"{statement.seed}:{statement.index}")
    find = _void_fault if statement.truth is Truth.VOID else _true_fault
    for _ in range(points):
        point = statement.point(draw)
        try:
            fault = find(statement, point)
        except ValueMissing:
            continue
        if fault is not None:
            return fault
    return None


def _true_fault(statement: Statement, point: Point) -> str | None:
    if fails_at(statement, point, DIGITS) and fails_at(statement, point, MORE_DIGITS[-2:]):
        return f"the residual at {point} is no rounding"
    return None


def _void_fault(statement: Statement, point: Point) -> str | None:
    """A division by 0 gives rounding, if it gives anything: another value at other digits."""
    same = _is_number(lambda values: values.value(statement.right, point), DIGITS)
    return f"there is a value at {point}" if same else None


def _false_fault(statement: Statement) -> str | None:
    point = statement.counterexample
    if point is None:
        return "there is no counterexample"
    for made in statement.ranges:
        if not made.holds(point[made.symbol]):
            return f"{made.symbol} = {point[made.symbol]} is not in its range"
    try:
        shown = fails_at(statement, point)
        return None if shown else f"the residual at {point} is rounding"
    except ValueMissing as error:
        return f"no value at the counterexample {point}: {error}"
