"""The evaluation of a closed form as bytecode: value and both derivatives.

The lowered expression (``solutions.compile.lowering``) becomes a tape with derivatives
(``solutions.compile.tape``), and the tape bytecode for the register machine
(``solutions.run.machine``). Constants are evaluated from the exact parameters in a private mpmath
context.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import mpmath
import sympy as sp

from solutions.compile.assembler import Assembler
from solutions.compile.lowering import JacobiCall, Lowering, Phase
from solutions.compile.tape import tape_of
from solutions.functions.multiprecision import mp_module
from solutions.run.linear_phase import LinearPhase
from solutions.run.machine import Bytecode

__all__ = ["Numbers", "Program", "Variables", "compile_program", "constant_context", "long_number"]

CONSTANT_DIGITS = 120
AGREEMENT = 1e-50
"""Relative difference of a constant from the same with twice the digits; three floats hold 48."""


def _constant_context() -> Any:
    context = mpmath.MPContext()
    context.dps = CONSTANT_DIGITS
    return context


constant_context: Any = _constant_context()


def long_number(exact: sp.Expr) -> Any:
    """An exact SymPy number as an mpf of the constants' precision."""
    return constant_context.mpf(exact._to_mpmath(constant_context.prec))


class Numbers(NamedTuple):
    """What a program takes from the parameters' values, as mpf."""

    constants: list[Any]
    coefficients: list[tuple[Any, Any, Any]]
    moduli: list[Any]


@dataclass(frozen=True)
class Program:
    """Value, xi derivative and tau derivative as a function of phases, Jacobi values, constants.

    The bytecode's inputs are the phases in the order of ``phases``, then sn, cn, dn, zeta, theta
    of each of ``calls``; ``wanted`` says which of these it reads. ``fixed`` takes the parameter
    values as mpf and returns the bytecode's constants, then p, q, r of each phase, then m of each
    call.
    """

    phases: tuple[Phase, ...]
    calls: tuple[JacobiCall, ...]
    wanted: tuple[tuple[bool, ...], ...]
    bytecode: Bytecode
    fixed: Callable[..., Sequence[Any]]

    def numbers(self, parameters: Sequence[sp.Expr]) -> Numbers:
        """The numbers at these exact parameters, with so many digits that more change nothing."""
        digits, found = CONSTANT_DIGITS, self._fixed_with(CONSTANT_DIGITS, parameters)
        while True:
            digits, before = 2 * digits, found
            found = self._fixed_with(digits, parameters)
            zero = constant_context.mpf(10) ** (-digits // 4)
            found = [
                0 * new if max(abs(old), abs(new)) < zero and not _agree(old, new) else new
                for old, new in zip(before, found, strict=True)
            ]
            if all(new == 0 or _agree(old, new) for old, new in zip(before, found, strict=True)):
                break
        first, second = len(self.bytecode.pool), len(found) - len(self.calls)
        triples = zip(*(iter(found[first:second]),) * 3, strict=True)
        return Numbers(found[:first], list(triples), found[second:])

    def _fixed_with(self, digits: int, parameters: Sequence[sp.Expr]) -> list[Any]:
        with constant_context.workdps(digits):
            values = self.fixed(*map(long_number, parameters))
            return [constant_context.convert(value) for value in values]


def _agree(old: Any, new: Any) -> bool:
    return bool(abs(new - old) <= AGREEMENT * abs(new))


@lru_cache(maxsize=64)
def compile_program(expression: sp.Expr, parameters: tuple[sp.Symbol, ...]) -> Program:
    """Compile ``expression`` in xi, tau and ``parameters``."""
    lowering = Lowering()
    statements, outputs = tape_of(lowering, lowering.lower(expression))
    phases, calls = tuple(lowering.phases.values()), tuple(lowering.calls.values())
    jacobi = [symbol for call in calls for symbol in call.symbols]
    assembler = Assembler([*(phase.symbol for phase in phases), *jacobi])
    for symbol, right in statements:
        assembler.define(symbol, right)
    bytecode = assembler.assemble([assembler.value(output) for output in outputs])
    back = {symbol: constant for constant, symbol in lowering.constants.items()}
    used = set().union(*(right.free_symbols for _, right in statements))
    return Program(
        phases=phases,
        calls=calls,
        wanted=tuple(tuple(s in used for s in call.symbols) for call in calls),
        bytecode=bytecode,
        fixed=_in_mpmath(
            parameters,
            [
                *(entry.xreplace(back) for entry in bytecode.pool),
                *(c for phase in phases for c in (phase.p, phase.q, phase.r)),
                *(call.m for call in calls),
            ],
        ),
    )


def _in_mpmath(parameters: Sequence[sp.Symbol], expressions: list[sp.Expr]) -> Any:
    modules = [mp_module(constant_context), "mpmath"]
    return sp.lambdify(list(parameters), expressions, modules, cse=True)


@dataclass(frozen=True)
class Variables:
    """``xi = a x + d t`` and ``tau = b t`` with exact a, b, d."""

    a: sp.Expr
    b: sp.Expr
    d: sp.Expr = sp.S.Zero

    def phase(self, p: Any, q: Any, r: Any) -> LinearPhase:
        """``p xi + q tau + r`` in the caller's variables; p, q, r are long numbers.

        Raises OverflowError for a coefficient out of a double's range.
        """
        a, b, d = (long_number(rate) for rate in (self.a, self.b, self.d))
        return LinearPhase(p * a, p * d + q * b, r)
