"""The compiled evaluation of a closed form: value and both derivatives, straight-line NumPy.

The lowered expression (``solutions.lowering``) becomes a tape with derivatives
(``solutions.tape``); ``lambdify`` turns its statements into one NumPy function. Constants
are evaluated from the exact parameters in a private mpmath context.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import mpmath
import numpy as np
import sympy as sp
from numpy.typing import NDArray

from solutions.lowering import Lowering
from solutions.phase import JacobiCall, Phase
from solutions.special.mp import mp_module
from solutions.tape import Statement, tape_of

__all__ = ["CONSTANT_DIGITS", "Program", "compile_program", "constant_context"]

CONSTANT_DIGITS = 80


def _constant_context() -> Any:
    context = mpmath.MPContext()
    context.dps = CONSTANT_DIGITS
    return context


constant_context: Any = _constant_context()


def _sech(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """sech without overflow."""
    decay = np.exp(-np.abs(x))
    return 2 * decay / (1 + decay * decay)


@dataclass(frozen=True)
class Program:
    """Value, xi derivative and tau derivative as a function of phases, Jacobi values, constants.

    ``run(*phases, *Jacobi values, *constants)`` takes the phases in the order of ``phases``, then
    sn, cn, dn, zeta, theta of each of ``calls``, then the constants. ``constants`` and
    ``coefficients`` (p, q, r of each phase) and ``moduli`` (m of each call) take the exact
    parameter values as mpf and return mpf.
    """

    phases: tuple[Phase, ...]
    calls: tuple[JacobiCall, ...]
    uses_theta: tuple[bool, ...]
    run: Callable[..., tuple[Any, Any, Any]]
    constants: Callable[..., Sequence[Any]]
    coefficients: Callable[..., Sequence[Any]]
    moduli: Callable[..., Sequence[Any]]


@lru_cache(maxsize=64)
def compile_program(expression: sp.Expr, parameters: tuple[sp.Symbol, ...]) -> Program:
    """Compile ``expression`` in xi, tau and ``parameters``."""
    lowering = Lowering()
    value = lowering.lower(expression)
    statements, outputs = tape_of(lowering, value)
    statements = _needed(statements, outputs)
    phases = tuple(lowering.phases.values())
    calls = tuple(lowering.calls.values())
    jacobi = [symbol for call in calls for symbol in call.symbols]
    arguments = [phase.symbol for phase in phases] + jacobi + list(lowering.constants.values())
    used = set().union(*(right.free_symbols for _, right in statements), *_free(outputs))
    return Program(
        phases=phases,
        calls=calls,
        uses_theta=tuple(call.theta in used for call in calls),
        run=sp.lambdify(
            arguments, outputs, [{"sech": _sech}, "numpy"], cse=lambda _: (statements, outputs)
        ),
        constants=_in_mpmath(parameters, list(lowering.constants)),
        coefficients=_in_mpmath(parameters, [c for ph in phases for c in (ph.p, ph.q, ph.r)]),
        moduli=_in_mpmath(parameters, [call.m for call in calls]),
    )


def _free(expressions: Sequence[sp.Expr]) -> list[set[sp.Basic]]:
    return [expression.free_symbols for expression in expressions]


def _in_mpmath(parameters: Sequence[sp.Symbol], expressions: list[sp.Expr]) -> Any:
    modules = [mp_module(constant_context), "mpmath"]
    return sp.lambdify(list(parameters), expressions, modules, cse=True)


def _needed(statements: list[Statement], outputs: list[sp.Expr]) -> list[Statement]:
    """The statements that the outputs depend on, in order."""
    wanted = set().union(*_free(outputs))
    kept = []
    for symbol, right in reversed(statements):
        if symbol in wanted:
            kept.append((symbol, right))
            wanted |= right.free_symbols
    return kept[::-1]
