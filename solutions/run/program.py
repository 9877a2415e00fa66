"""A program for the machine with all that it takes from the parameters' values: plain data.

An evaluator is a program with numbers in: value and derivatives at arrays of (x, t).
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import mpmath
import numpy as np

from solutions.functions.multiprecision import MpmathFormula
from solutions.run.bounded import PARTS
from solutions.run.bytecode import Bytecode
from solutions.run.doubledouble import Array, check_range, split
from solutions.run.jacobi_program import jacobi_program
from solutions.run.linear_phase import LinearPhase, as_pairs
from solutions.run.machine import run_pairs

if TYPE_CHECKING:
    from sympy import Expr

__all__ = [
    "Evaluator",
    "Numbers",
    "PointEvaluator",
    "Program",
    "Variables",
    "long_number",
]

CONSTANT_DIGITS = 120
AGREEMENT = 1e-50
"""Relative difference of a constant from the same with twice the digits; three floats hold 48."""

_CONTEXT: Any = mpmath.MPContext()
_CONTEXT.dps = CONSTANT_DIGITS


def long_number(exact: Expr) -> Any:
    """An exact SymPy number as an mpf of the constants' precision."""
    return _CONTEXT.mpf(exact._to_mpmath(_CONTEXT.prec))


@dataclass(frozen=True)
class Variables:
    """``xi = a x + d t`` and ``tau = b t``: a closed form's variables in the caller's; exact."""

    a: Expr
    b: Expr
    d: Expr

    def phase(self, p: Any, q: Any, r: Any) -> LinearPhase:
        """``p xi + q tau + r`` in the caller's variables; p, q, r are long numbers.

        Raises OverflowError for a coefficient out of a double's range.
        """
        a, b, d = (long_number(rate) for rate in (self.a, self.b, self.d))
        return LinearPhase(p * a, p * d + q * b, r)


class Numbers(NamedTuple):
    """What a program takes from the parameters' values, as mpf."""

    constants: list[Any]
    coefficients: list[tuple[Any, Any, Any]]
    moduli: list[Any]


@dataclass(frozen=True)
class Program:
    """Value, xi derivative and tau derivative as a function of phases, Jacobi values, constants.

    The bytecode's inputs are the phases, then sn, cn, dn, zeta, theta of each call; ``calls`` has
    the place of each call's phase, and ``wanted`` which of the five it reads. ``fixed`` takes the
    parameters and gives the bytecode's constants, then p, q, r of each phase, then m of each call.
    """

    calls: Sequence[int]
    wanted: Sequence[Sequence[bool]]
    bytecode: Bytecode
    fixed: MpmathFormula

    def numbers(self, parameters: Sequence[Expr]) -> Numbers:
        """The numbers at these exact parameters, with so many digits that more change nothing."""
        digits, found = CONSTANT_DIGITS, self._fixed_with(CONSTANT_DIGITS, parameters)
        while True:
            digits, before = 2 * digits, found
            found = self._fixed_with(digits, parameters)
            zero = _CONTEXT.mpf(10) ** (-digits // 4)
            found = [
                0 * new if max(abs(old), abs(new)) < zero and not _agree(old, new) else new
                for old, new in zip(before, found, strict=True)
            ]
            if all(new == 0 or _agree(old, new) for old, new in zip(before, found, strict=True)):
                break
        first, second = len(self.bytecode.pool), len(found) - len(self.calls)
        triples = zip(*(iter(found[first:second]),) * 3, strict=True)
        return Numbers(found[:first], list(triples), found[second:])

    def _fixed_with(self, digits: int, parameters: Sequence[Expr]) -> list[Any]:
        with _CONTEXT.workdps(digits):
            values = self.fixed(_CONTEXT, *map(long_number, parameters))
            return [_CONTEXT.convert(value) for value in values]

    def text(self) -> str:
        """The program as JSON; the constants' names are left out."""
        code, formula = self.bytecode, self.fixed
        return json.dumps({
            "calls": self.calls,
            "wanted": self.wanted,
            "bytecode": [code.code.tolist(), code.registers, code.inputs, code.outputs],
            "constants": len(code.pool),
            "fixed": [formula.arguments, formula.code, formula.results],
        })  # fmt: skip

    @classmethod
    def read(cls, text: str) -> Program:
        """The program that ``text`` wrote down."""
        held = json.loads(text)
        code, registers, inputs, outputs = held["bytecode"]
        array = np.array(code, dtype=np.int64).reshape(-1, 5)
        pool = tuple(range(held["constants"]))
        bytecode = Bytecode(array, registers, inputs, tuple(outputs), pool)
        return cls(held["calls"], held["wanted"], bytecode, MpmathFormula(*held["fixed"]))


def _agree(old: Any, new: Any) -> bool:
    return bool(abs(new - old) <= AGREEMENT * abs(new))


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
