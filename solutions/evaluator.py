"""One expression with numbers in: value and derivatives at arrays of (x, t)."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike, NDArray

from solutions.linear_phase import LinearPhase
from solutions.program import compile_program, constant_context
from solutions.special.double import evaluate, evaluate_thetas
from solutions.special.doubledouble import split
from solutions.special.parameter import EllipticParameter, elliptic_parameter

__all__ = ["Evaluator", "Variables", "long_number"]

BLOCK = 4096
"""Points evaluated at a time, so that temporaries stay in the cache."""

Array = NDArray[np.float64]


def long_number(exact: sp.Expr) -> Any:
    """An exact SymPy number as an mpf of the constants' precision."""
    return constant_context.mpf(exact._to_mpmath(constant_context.prec))


class Variables:
    """How xi and tau depend on the caller's variables: ``xi = a x + d t``, ``tau = b t``."""

    def __init__(self, a: Any, b: Any, d: Any = 0) -> None:
        self.a, self.b, self.d = a, b, d

    def phase(self, p: Any, q: Any, r: Any) -> LinearPhase:
        """``p xi + q tau + r`` in the caller's variables."""
        return LinearPhase(p * self.a, p * self.d + q * self.b, r)


class Evaluator:
    """The value and its xi and tau derivatives of an expression at given parameters.

    ``parameters`` maps symbols to exact numbers. The result is scaled by nothing: the caller
    multiplies by the normal form's rates.
    """

    def __init__(self, expression: sp.Expr, parameters: Mapping[sp.Symbol, sp.Expr]) -> None:
        self._program = compile_program(expression, tuple(parameters))
        exact = [long_number(value) for value in parameters.values()]
        self._constants = [float(c) for c in self._program.constants(*exact)]
        flat = list(self._program.coefficients(*exact))
        self._coefficients = [tuple(flat[i : i + 3]) for i in range(0, len(flat), 3)]
        self._moduli = [_elliptic_parameter(m) for m in self._program.moduli(*exact)]

    def phases(self, variables: Variables) -> list[LinearPhase]:
        """The program's phases in the caller's variables."""
        return [variables.phase(*coefficients) for coefficients in self._coefficients]

    def __call__(
        self, phases: list[LinearPhase], x: ArrayLike, t: ArrayLike
    ) -> tuple[Array, Array, Array]:
        """Value, xi derivative and tau derivative at the broadcast points (x, t)."""
        x, t = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(t, dtype=float))
        flat_x, flat_t = np.ravel(x), np.ravel(t)
        out = np.empty((3, flat_x.size))
        for start in range(0, flat_x.size, BLOCK):
            block = slice(start, start + BLOCK)
            for row, values in enumerate(self._block(phases, flat_x[block], flat_t[block])):
                out[row, block] = values
        shaped = out.reshape(3, *x.shape)
        return shaped[0], shaped[1], shaped[2]

    def _block(self, phases: list[LinearPhase], x: Array, t: Array) -> tuple[Any, Any, Any]:
        program = self._program
        pairs = [phase(np.ascontiguousarray(x), np.ascontiguousarray(t)) for phase in phases]
        by_symbol = dict(zip((ph.symbol for ph in program.phases), pairs, strict=True))
        jacobi: list[Array] = []
        for call, modulus, thetas in zip(
            program.calls, self._moduli, program.uses_theta, strict=True
        ):
            u, u_lo = by_symbol[call.phase]
            values = evaluate(modulus, u, u_lo)
            theta = evaluate_thetas(modulus, u, u_lo).theta if thetas else u
            jacobi += [values.sn, values.cn, values.dn, values.zeta, theta]
        with np.errstate(under="ignore"):
            return program.run(*(high for high, _ in pairs), *jacobi, *self._constants)


def _elliptic_parameter(m: Any) -> EllipticParameter:
    (m_hi, m_lo), (m1_hi, m1_lo) = split(m), split(1 - m)
    return elliptic_parameter(m_hi, m1_hi, m_lo, m1_lo)
