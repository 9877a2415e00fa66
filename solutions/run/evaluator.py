"""One expression with numbers in: value and derivatives at arrays of (x, t)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from solutions.run.bounded import PARTS
from solutions.run.doubledouble import Array, check_range, split
from solutions.run.jacobi_program import jacobi_program
from solutions.run.linear_phase import LinearPhase, as_pairs
from solutions.run.machine import run_pairs
from solutions.run.program import Program, Variables

if TYPE_CHECKING:
    from sympy import Expr

__all__ = ["Evaluator", "PointEvaluator"]


class PointEvaluator(Protocol):
    """What a wave asks of an evaluator: phases, and the value with its derivatives."""

    def phases(self, variables: Variables) -> list[LinearPhase]:
        """The phases in the caller's variables."""

    def __call__(self, phases: list[LinearPhase], x: Array, t: Array) -> Array:
        """Value, xi derivative and tau derivative at the points (x, t): an array (3, 3, points).

        The second axis is high part, low part and bound of the error.
        """


class Evaluator:
    """The value and its xi and tau derivatives by a program with exact parameters put in.

    The result is scaled by nothing: the caller multiplies by the normal form's rates. Raises
    OverflowError for a constant of the program beyond 1e-250 .. 1e250.
    """

    def __init__(self, program: Program, parameters: Sequence[Expr]) -> None:
        self._program = program
        numbers = program.numbers(parameters)
        self._constants = np.array([split(check_range(c)) for c in numbers.constants]).reshape(
            -1, 2
        )
        self._coefficients = numbers.coefficients
        self._functions = [
            jacobi_program(check_range(m), check_range(1 - m), tuple(wanted))
            for m, wanted in zip(numbers.moduli, program.wanted, strict=True)
        ]

    def phases(self, variables: Variables) -> list[LinearPhase]:
        """The program's phases in the caller's variables."""
        return [variables.phase(*coefficients) for coefficients in self._coefficients]

    def __call__(self, phases: list[LinearPhase], x: Array, t: Array) -> Array:
        """Value, xi derivative and tau derivative at the points (x, t): an array (3, 3, points)."""
        program = self._program
        found = [phase(x, t) for phase in phases]
        rows = [as_pairs(phase)[None] for phase in found]
        rows += [
            functions(found[place])
            for place, functions in zip(program.calls, self._functions, strict=True)
        ]
        out = np.empty((3, PARTS, x.size))
        inputs = np.concatenate(rows) if rows else np.empty((0, PARTS, x.size))
        run_pairs(program.bytecode, self._constants, inputs, out)
        return out
