"""Taylor coefficients in xi on the machine: a value's program expanded into one for its series.

Every instruction is replaced by those of its series' coefficients; the Jacobi functions of a phase
follow from their differential equations. All arithmetic is double-double with error bounds.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from longwave.solutions.run.bytecode import Bytecode, Code, Operation, Value
from longwave.solutions.run.doubledouble import Array, split
from longwave.solutions.run.linear_phase import LONG

Series = list[Any]
"""Coefficients of a series, each a `Value` or a long number."""


def taylor_bytecode(
    bytecode: Bytecode,
    constants: Sequence[Any],
    inputs: Callable[[Code, int], list[Series]],
    outputs: Sequence[int],
    highest: int,
) -> tuple[Bytecode, Array]:
    """Return the program for coefficients 0 .. ``highest`` of some outputs, and its constants.

    ``constants`` are the long numbers of the bytecode's pool; the returned ones are pairs.
    ``inputs`` returns the series of the bytecode's inputs, which are also the new program's inputs.
    """
    code = Code(bytecode.inputs)
    registers: list[Series] = inputs(code, highest + 1)
    registers += [[]] * (bytecode.registers - len(registers))
    expansion = _Expansion(code, highest + 1)
    needed, _ = bytecode.only([bytecode.outputs[row] for row in outputs])
    for operation, target, a, b, c in needed.code.tolist():
        registers[target] = expansion.series(
            Operation(operation), registers[a], registers[b], constants[c] if constants else None
        )
    results = [registers[bytecode.outputs[row]] for row in outputs]
    program = code.assemble([code.number(c) for series in results for c in series[: highest + 1]])
    pairs = np.array([split(number) for number in program.pool]).reshape(-1, 2)
    return replace(program, pool=()), pairs


def jacobi_series(
    code: Code, first: int, phase: Series, m: Any, mean: Any, count: int
) -> list[Series]:
    """Return the series, ``count`` terms each, of sn, cn, dn, zeta and Theta of a phase.

    Their values are the inputs ``first`` to ``first + 4``; ``m`` is their parameter, ``mean`` E/K.
    """
    rate = phase[1] if count > 1 else 0
    sn, cn, dn, zeta, theta = all_series = [[Value(code, first + n)] for n in range(5)]
    for n in range(1, count):
        factor = rate / n
        sn.append(_of_product(cn, dn, n - 1) * factor)
        cn.append(_of_product(sn, dn, n - 1) * -factor)
        dn.append(_of_product(sn, cn, n - 1) * (-m * factor))
        square = _of_product(dn, dn, n - 1)
        zeta.append((square - mean if n == 1 else square) * factor)
        theta.append(_of_product(zeta, theta, n - 1) * factor)
    return all_series


def _of_product(x: Series, y: Series, n: int) -> Any:
    """Return the n-th coefficient of the product of two series; faster if they are the same."""
    if x is not y:  # one series twice is a square
        return sum((x[i] * y[n - i] for i in range(n + 1)), LONG.zero)
    pairs = sum((x[i] * x[n - i] for i in range((n + 1) // 2)), LONG.zero) * 2
    return pairs if n % 2 else pairs + x[n // 2] * x[n // 2]


class _Expansion:
    """Rules for the series of an operation's result from its operands', ``count`` terms each."""

    def __init__(self, code: Code, count: int) -> None:
        self._code, self._count = code, count

    def value(self, coefficient: Any) -> Value:
        """Return a coefficient as a value of the program."""
        return Value(self._code, self._code.number(coefficient))

    def series(self, operation: Operation, x: Series, y: Series, c: Any) -> Series:
        """Return the series of an instruction's result from its operands' series and constant."""
        match operation:
            case Operation.MULTIPLY_CONSTANT | Operation.SCALE:
                return [term * c for term in x]
            case Operation.CONSTANT:
                return [c, *[LONG.zero] * (self._count - 1)]
            case Operation.ADD_CONSTANT:
                return [x[0] + c, *x[1:]]
            case Operation.FROM_CONSTANT:
                return [c - x[0], *(term * -1 for term in x[1:])]
            case Operation.ADD:
                return [a + b for a, b in zip(x, y, strict=True)]
            case Operation.SUBTRACT:
                return [a - b for a, b in zip(x, y, strict=True)]
            case Operation.MULTIPLY:
                return [_of_product(x, y, n) for n in range(self._count)]
            case Operation.TANH | Operation.SECH:
                return self._hyperbolic(x)[operation == Operation.SECH]
        start = self.value(x[0])
        series: Series = [start.apply(operation)]
        if operation == Operation.SQUARE_ROOT:
            factor = series[0].apply(Operation.RECIPROCAL) * LONG.mpf(0.5)
        elif operation == Operation.LOGARITHM:
            factor = start.apply(Operation.RECIPROCAL)
        for n in range(1, self._count):
            match operation:
                case Operation.RECIPROCAL:
                    series.append(_dot(x[1 : n + 1], series[::-1]) * series[0] * -1)
                case Operation.EXPONENTIAL:
                    series.append(_chain(x, series, n))
                case Operation.SQUARE_ROOT:
                    series.append((x[n] - _dot(series[1:], series[:0:-1])) * factor)
                case Operation.LOGARITHM:
                    known = (series[j] * (LONG.mpf(j) / n) * x[n - j] for j in range(1, n))
                    series.append((x[n] - sum(known, LONG.zero)) * factor)
                case _:
                    raise ValueError(
                        f"operation must have a series, got {operation.name} (add one)"
                    )
        return series

    def _hyperbolic(self, x: Series) -> tuple[Series, Series]:
        """Return the series of tanh and sech, whose derivatives are sech**2 and -tanh sech."""
        start = self.value(x[0])
        tanh: Series = [start.apply(Operation.TANH)]
        sech: Series = [start.apply(Operation.SECH)]
        for n in range(1, self._count):
            rises = [_of_product(sech, sech, j) for j in range(n)]
            falls = [_of_product(tanh, sech, j) for j in range(n)]
            tanh.append(_chain(x, rises, n))
            sech.append(_chain(x, falls, n) * -1)
        return tanh, sech


def _dot(x: Series, y: Series) -> Any:
    return sum((a * b for a, b in zip(x, y, strict=True)), LONG.zero)


def _chain(x: Series, outer: Series, n: int) -> Any:
    """Return the n-th coefficient of f(x), where ``outer`` is the series of f'(x); n > 0."""
    terms = (x[j] * (LONG.mpf(j) / n) * outer[n - j] for j in range(1, n + 1))
    return sum(terms, LONG.zero)
