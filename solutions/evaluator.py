"""One expression with numbers in: value and derivatives at arrays of (x, t)."""

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from solutions.double_machine import run_double
from solutions.linear_phase import LinearPhase
from solutions.pair_machine import run_pairs
from solutions.program import compile_program
from solutions.special.double import evaluate, evaluate_thetas
from solutions.special.doubledouble import split
from solutions.special.extended import evaluate_pairs
from solutions.special.parameter import EllipticParameter, elliptic_parameter
from solutions.variables import Variables, long_number

__all__ = ["Evaluator", "PointEvaluator"]

Array = NDArray[np.float64]


class PointEvaluator(Protocol):
    """What a wave asks of an evaluator: phases, and three rows of values in either arithmetic."""

    def phases(self, variables: Variables) -> list[LinearPhase]:
        """The phases in the caller's variables."""

    def double(self, phases: list[LinearPhase], x: Array, t: Array) -> Array:
        """Value, xi derivative and tau derivative at the points (x, t): three rows."""

    def pairs(self, phases: list[LinearPhase], x: Array, t: Array) -> Array:
        """``double`` in double-double: an array (3, 2, points) of high and low parts."""


class Evaluator:
    """The value and its xi and tau derivatives of an expression at given parameters.

    ``parameters`` maps symbols to exact numbers. The result is scaled by nothing: the caller
    multiplies by the normal form's rates.
    """

    def __init__(self, expression: sp.Expr, parameters: Mapping[sp.Symbol, sp.Expr]) -> None:
        self._program = compile_program(expression, tuple(parameters))
        exact = [long_number(value) for value in parameters.values()]
        constants = [split(c) for c in self._program.constants(*exact)]
        self._constants = np.array(constants, dtype=float).reshape(-1, 2)
        flat = list(self._program.coefficients(*exact))
        self._coefficients = [tuple(flat[i : i + 3]) for i in range(0, len(flat), 3)]
        self._moduli = [_elliptic_parameter(m) for m in self._program.moduli(*exact)]

    def phases(self, variables: Variables) -> list[LinearPhase]:
        """The program's phases in the caller's variables."""
        return [variables.phase(*coefficients) for coefficients in self._coefficients]

    def double(self, phases: list[LinearPhase], x: Array, t: Array) -> Array:
        """Value, xi derivative and tau derivative at the points (x, t): three rows."""
        pairs = [phase(x, t) for phase in phases]
        rows = [high for high, _ in pairs]
        for u, modulus, thetas in self._calls(pairs):
            values = evaluate(modulus, *u)
            theta = evaluate_thetas(modulus, *u).theta if thetas else values.dn
            rows += [values.sn, values.cn, values.dn, values.zeta, theta]
        out = np.empty((3, x.size))
        inputs = np.array(rows).reshape(len(rows), x.size)
        run_double(self._program.bytecode, np.ascontiguousarray(self._constants[:, 0]), inputs, out)
        return out

    def pairs(self, phases: list[LinearPhase], x: Array, t: Array) -> Array:
        """``double`` in double-double: an array (3, 2, points) of high and low parts."""
        pairs = [phase(x, t) for phase in phases]
        rows = [np.array(pair) for pair in pairs]
        for u, modulus, thetas in self._calls(pairs):
            values = evaluate_pairs(modulus, *u, theta=thetas)
            theta = values.dn if values.theta is None else values.theta
            rows += [values.sn, values.cn, values.dn, values.zeta, theta]
        out = np.empty((3, 2, x.size))
        inputs = np.array(rows).reshape(len(rows), 2, x.size)
        run_pairs(self._program.bytecode, self._constants, inputs, out)
        return out

    def _calls(
        self, pairs: list[tuple[Array, Array]]
    ) -> list[tuple[tuple[Array, Array], EllipticParameter, bool]]:
        """Argument, parameter and whether Theta is wanted, of each Jacobi call."""
        program = self._program
        by_symbol = dict(zip((ph.symbol for ph in program.phases), pairs, strict=True))
        arguments = [by_symbol[call.phase] for call in program.calls]
        return list(zip(arguments, self._moduli, program.uses_theta, strict=True))


def _elliptic_parameter(m: Any) -> EllipticParameter:
    (m_hi, m_lo), (m1_hi, m1_lo) = split(m), split(1 - m)
    return elliptic_parameter(m_hi, m1_hi, m_lo, m1_lo)
