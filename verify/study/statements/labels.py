"""Whether a statement's label, or a witness, is right: by values at admissible points."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import sympy as sp

from .record import Point, Statement, Truth
from .values import ValueMissing, Values, values_at

POINTS = 6
TRIES = 10
DIGITS = (40, 240, 700)
"""A residual counts as clear if it is so at one of these; they suit changes by 10**-200."""

MOST_DIGITS = 6000
"""For a witness far out, where exp(-3*t) makes both sides smaller than the other digits show."""

FALL = 1e-20
"""Rounding falls at least by this from the first of the digits to the second."""


def is_clear(residual: object, values: Values) -> bool:
    """Whether a relative residual is more than rounding."""
    found: bool = abs(residual) > values.context.mpf(10) ** (-values.digits / 2)  # type: ignore[arg-type]
    return found


def fails_at(statement: Statement, point: Point) -> bool:
    """Whether the statement has a residual at ``point``; raises ValueMissing without a value.

    A residual that is one term by construction is taken from that term where it is small.
    """
    try:
        if _has_residual(statement, point, DIGITS[:1]):
            return True
    except ValueMissing:
        return _has_residual(statement, point, DIGITS[1:])
    if statement.change is not None:
        return _is_value(statement.change, point)
    return _has_residual(statement, point, (*DIGITS[1:], MOST_DIGITS))


def with_counterexample(statement: Statement, draw: random.Random) -> Statement | None:
    """A false statement with an admissible point that shows it; None if some tries find none."""
    for _ in range(TRIES):
        point = statement.point(draw)
        try:
            if fails_at(statement, point):
                return replace(statement, counterexample=point)
        except ValueMissing:
            continue
    return None


def _has_residual(statement: Statement, point: Point, digits: Sequence[int]) -> bool:
    for values in map(values_at, digits):
        try:
            if is_clear(values.residual(statement, point), values):
                return True
        except ValueMissing:
            if values.digits == digits[-1]:
                raise
    return False


def _is_value(term: sp.Expr, point: Point) -> bool:
    """Whether ``term`` has a value other than 0, however small."""
    found = [values_at(digits).value(term, point) for digits in DIGITS]
    return any(abs(a - b) < abs(b) / 1000 for a, b in pairwise(found))


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
    """Rounding falls with the digits, what is no rounding stays."""
    coarse, fine = (values_at(digits) for digits in DIGITS[:2])
    residual = coarse.residual(statement, point)
    if not is_clear(residual, coarse):
        return None
    finer = fine.residual(statement, point)
    if abs(finer) < abs(residual) * FALL:
        return None
    return f"the residual at {point} is {fine.context.nstr(finer, 5)}"


def _void_fault(statement: Statement, point: Point) -> str | None:
    """A division by 0 gives rounding, if it gives anything: another value at other digits."""
    pair = [values_at(digits).value(statement.right, point) for digits in DIGITS[:2]]
    same = abs(pair[0] - pair[1]) < abs(pair[0]) / 1000
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
