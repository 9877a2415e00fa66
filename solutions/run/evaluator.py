"""Programs at given parameters: values at arrays of points, and Taylor coefficients."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import TYPE_CHECKING, Protocol

import numpy as np

from longwave.solutions.run.bounded import PARTS
from longwave.solutions.run.bytecode import Code, Value
from longwave.solutions.run.doubledouble import Array, check_range, split
from longwave.solutions.run.linear_phase import (
    CONSTANT_DIGITS,
    LONG,
    LinearPhase,
    Variables,
    as_pairs,
)
from longwave.solutions.run.machine import run_pairs
from longwave.solutions.run.program import Program, jacobi_program
from longwave.solutions.run.taylor_program import Series, jacobi_series, taylor_bytecode

if TYPE_CHECKING:
    from sympy import Expr


class PointEvaluator(Protocol):
    """Interface of an evaluator: its linear phases, and its values and derivatives at points."""

    def phases(self, variables: Variables) -> list[LinearPhase]:
        """Return the phases in the caller's variables."""

    def __call__(self, phases: list[LinearPhase], *points: Array) -> Array:
        """Return values at the points (x, t) or (x, t, z): an array (rows, 3, points).

        The rows are the value and its derivatives in xi, tau and, with z, zeta; if the value is
        complex, those of the real, then of the imaginary part. The second axis is high part, low
        part and bound of the error.
        """


class Evaluator:
    """Values and derivatives computed by a program at exact parameters.

    The result is not scaled: the caller multiplies by the normal form's rates. Raises OverflowError
    for a constant of the program beyond 1e-250 .. 1e250.
    """

    def __init__(self, program: Program, parameters: Sequence[Expr]) -> None:
        self._bytecode, self._calls = program.bytecode, tuple(program.calls)
        numbers = program.numbers(parameters)
        pairs = [split(check_range(constant)) for constant in numbers.constants]
        self._constants = np.array(pairs).reshape(-1, 2)
        self._coefficients = numbers.coefficients
        self._moduli = [check_range(m) for m in numbers.moduli]
        self._requested = [tuple(requested) for requested in program.requested]
        self._functions = [
            jacobi_program(m, check_range(1 - m), requested)
            for m, requested in zip(self._moduli, self._requested, strict=True)
        ]

    def phases(self, variables: Variables) -> list[LinearPhase]:
        """Return the program's phases in the caller's variables."""
        return [variables.phase(*coefficients) for coefficients in self._coefficients]

    def __call__(self, phases: list[LinearPhase], *points: Array) -> Array:
        """Return values and derivatives at points (x, t) or (x, t, z), shape (rows, 3, points)."""
        phase_values = [phase(*points) for phase in phases]
        calls = zip(self._calls, self._functions, strict=True)
        rows = [as_pairs(phase)[None] for phase in phase_values]
        rows += [functions(phase_values[index]) for index, functions in calls]
        out = np.empty((len(self._bytecode.outputs), PARTS, points[0].size))
        inputs = np.concatenate(rows) if rows else np.empty((0, PARTS, points[0].size))
        run_pairs(self._bytecode, self._constants, inputs, out)
        return out

    def only(self, rows: Sequence[int]) -> Evaluator:
        """Return an evaluator of some of the rows only, whose values are bitwise the same."""
        evaluator = copy(self)
        outputs = [self._bytecode.outputs[row] for row in rows]
        evaluator._bytecode, read_inputs = self._bytecode.only(outputs)
        evaluator._functions, first = [], len(self._coefficients)
        for functions in self._functions:
            last = first + len(functions.bytecode.outputs)
            requested = [i in read_inputs for i in range(first, last)]
            evaluator._functions.append(functions.only(requested))
            first = last
        return evaluator

    def taylor(self, rows: Sequence[int], highest: int) -> Evaluator:
        """Return an evaluator of some rows' Taylor coefficients in xi, 0 to ``highest``."""
        constants = [LONG.mpf(high) + LONG.mpf(low) for high, low in self._constants.tolist()]
        evaluator = copy(self)
        expanded = taylor_bytecode(self._bytecode, constants, self._series, rows, highest)
        evaluator._bytecode, evaluator._constants = expanded
        evaluator._functions = [
            jacobi_program(m, 1 - m, (True, True, True, zeta or theta, theta))
            for m, (*_, zeta, theta) in zip(self._moduli, self._requested, strict=True)
        ]
        return evaluator

    def _series(self, code: Code, count: int) -> list[Series]:
        """Return the Taylor series of the bytecode's inputs: phases, then each call's functions."""
        phases: list[Series] = []
        for number, (rate, *_) in enumerate(self._coefficients):
            phases.append([Value(code, number), rate, *[LONG.zero] * count][:count])
        series = list(phases)
        for index, m in zip(self._calls, self._moduli, strict=True):
            with LONG.workdps(CONSTANT_DIGITS):
                mean = LONG.ellipe(m) / LONG.ellipk(m) if m < 1 else LONG.zero
            series += jacobi_series(code, len(series), phases[index], m, mean, count)
        return series
