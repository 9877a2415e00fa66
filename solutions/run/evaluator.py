"""Programs with numbers in: values at arrays of points, and their Taylor coefficients."""

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
    """What a wave asks of an evaluator: phases, and values with their derivatives."""

    def phases(self, variables: Variables) -> list[LinearPhase]:
        """The phases in the caller's variables."""

    def __call__(self, phases: list[LinearPhase], *points: Array) -> Array:
        """Values at the points (x, t) or (x, t, z): an array (rows, 3, points).

        The rows are the value and its derivatives in xi, tau and, with z, zeta; those of the real,
        then of the imaginary part where the value is complex. The second axis is high part, low
        part and bound of the error.
        """


class Evaluator:
    """The values and their derivatives by a program with exact parameters put in.

    The result is scaled by nothing: the caller multiplies by the normal form's rates. Raises
    OverflowError for a constant of the program beyond 1e-250 .. 1e250.
    """

    def __init__(self, program: Program, parameters: Sequence[Expr]) -> None:
        self._bytecode, self._calls = program.bytecode, tuple(program.calls)
        numbers = program.numbers(parameters)
        self._constants = np.array([split(check_range(c)) for c in numbers.constants]).reshape(
            -1, 2
        )
        self._coefficients = numbers.coefficients
        self._moduli = [check_range(m) for m in numbers.moduli]
        self._wanted = [tuple(wanted) for wanted in program.wanted]
        self._functions = [
            jacobi_program(m, check_range(1 - m), wanted)
            for m, wanted in zip(self._moduli, self._wanted, strict=True)
        ]

    def phases(self, variables: Variables) -> list[LinearPhase]:
        """The program's phases in the caller's variables."""
        return [variables.phase(*coefficients) for coefficients in self._coefficients]

    def __call__(self, phases: list[LinearPhase], *points: Array) -> Array:
        """Values and derivatives at the points (x, t) or (x, t, z): an array (rows, 3, points)."""
        found = [phase(*points) for phase in phases]
        rows = [as_pairs(phase)[None] for phase in found]
        rows += [
            functions(found[place])
            for place, functions in zip(self._calls, self._functions, strict=True)
        ]
        out = np.empty((len(self._bytecode.outputs), PARTS, points[0].size))
        inputs = np.concatenate(rows) if rows else np.empty((0, PARTS, points[0].size))
        run_pairs(self._bytecode, self._constants, inputs, out)
        return out

    def only(self, rows: Sequence[int]) -> Evaluator:
        """Return what evaluates some of the rows alone, to the same bits."""
        made = copy(self)
        made._bytecode, read = self._bytecode.only([self._bytecode.outputs[row] for row in rows])
        made._functions, first = [], len(self._coefficients)
        for functions in self._functions:
            count = len(functions.bytecode.outputs)
            made._functions.append(functions.only([first + i in read for i in range(count)]))
            first += count
        return made

    def taylor(self, rows: Sequence[int], highest: int) -> Evaluator:
        """What evaluates the Taylor coefficients in xi, 0 to ``highest``, of some of the rows."""
        constants = [LONG.mpf(high) + LONG.mpf(low) for high, low in self._constants.tolist()]
        made = copy(self)
        made._bytecode, made._constants = taylor_bytecode(
            self._bytecode, constants, self._series, rows, highest
        )
        made._functions = [
            jacobi_program(m, 1 - m, (True, True, True, zeta or theta, theta))
            for m, (*_, zeta, theta) in zip(self._moduli, self._wanted, strict=True)
        ]
        return made

    def _series(self, code: Code, count: int) -> list[Series]:
        """The Taylor series of the bytecode's inputs: phases, then the functions of each call."""
        phases: list[Series] = []
        for number, (rate, *_) in enumerate(self._coefficients):
            phases.append([Value(code, number), rate, *[LONG.zero] * count][:count])
        found = list(phases)
        for place, m in zip(self._calls, self._moduli, strict=True):
            with LONG.workdps(CONSTANT_DIGITS):
                mean = LONG.ellipe(m) / LONG.ellipk(m) if m < 1 else LONG.zero
            found += jacobi_series(code, len(found), phases[place], m, mean, count)
        return found
