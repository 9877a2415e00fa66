"""The evaluation of a closed form as bytecode: value and both derivatives.

The lowered expression (``solutions.lowering``) becomes a tape with derivatives
(``solutions.tape``), and the tape bytecode, which one register machine runs in double and another
in double-double. Constants are evaluated from the exact parameters in a private mpmath context.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import mpmath
import sympy as sp

from solutions.assembler import Assembler
from solutions.bytecode import Bytecode
from solutions.lowering import Lowering
from solutions.phase import JacobiCall, Phase
from solutions.special.mp import mp_module
from solutions.tape import tape_of

__all__ = ["CONSTANT_DIGITS", "Program", "compile_program", "constant_context"]

CONSTANT_DIGITS = 120


def _constant_context() -> Any:
    context = mpmath.MPContext()
    context.dps = CONSTANT_DIGITS
    return context


constant_context: Any = _constant_context()


@dataclass(frozen=True)
class Program:
    """Value, xi derivative and tau derivative as a function of phases, Jacobi values, constants.

    The bytecode's inputs are the phases in the order of ``phases``, then sn, cn, dn, zeta, theta
    of each of ``calls``. ``constants`` (the bytecode's pool), ``coefficients`` (p, q, r of each
    phase) and ``moduli`` (m of each call) take the exact parameter values as mpf and return mpf.
    """

    phases: tuple[Phase, ...]
    calls: tuple[JacobiCall, ...]
    uses_theta: tuple[bool, ...]
    bytecode: Bytecode
    constants: Callable[..., Sequence[Any]]
    coefficients: Callable[..., Sequence[Any]]
    moduli: Callable[..., Sequence[Any]]


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
        uses_theta=tuple(call.theta in used for call in calls),
        bytecode=bytecode,
        constants=_in_mpmath(parameters, [entry.xreplace(back) for entry in bytecode.pool]),
        coefficients=_in_mpmath(parameters, [c for ph in phases for c in (ph.p, ph.q, ph.r)]),
        moduli=_in_mpmath(parameters, [call.m for call in calls]),
    )


def _in_mpmath(parameters: Sequence[sp.Symbol], expressions: list[sp.Expr]) -> Any:
    modules = [mp_module(constant_context), "mpmath"]
    return sp.lambdify(list(parameters), expressions, modules, cse=True)
