"""The register machine in double-double, on blocks of points.

A register holds ``BLOCK`` high parts, then as many low parts: LLVM then sees that its loops do not
overlap and runs them on vectors. numba's disk cache sees changes of this file only: after a change
in ``solutions.special.doubledouble`` or ``elementary`` remove ``__pycache__``.
"""

import math
from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from solutions.bytecode import Bytecode
from solutions.special.doubledouble import (
    Pair,
    add,
    divide,
    fma,
    multiply,
    quick_two_sum,
    scale,
    square_root,
    subtract,
)
from solutions.special.elementary import decay

__all__ = ["run_pairs", "scale_rows"]

Array = NDArray[np.float64]
BLOCK = 128


@njit(error_model="numpy")
def _exponential(x: Pair) -> Pair:
    if x[0] <= 0.0:
        return decay((-x[0], -x[1]))[0]
    return divide((1.0, 0.0), decay(x)[0])


@njit(error_model="numpy")
def _logarithm(x: Pair) -> Pair:
    """One Newton step from the double value."""
    start = math.log(x[0])
    ratio = multiply(x, _exponential((-start, 0.0)))
    rest = subtract(ratio, (1.0, 0.0))
    return add((start, 0.0), subtract(rest, scale(multiply(rest, rest), 0.5)))


@njit(error_model="numpy")
def _tanh(x: Pair) -> Pair:
    sign = 1.0 if x[0] >= 0.0 else -1.0
    fall, rise = decay(scale(x, 2.0 * sign))
    return scale(divide(rise, add((1.0, 0.0), fall)), sign)


@njit(error_model="numpy")
def _sech(x: Pair) -> Pair:
    fall, _ = decay(scale(x, 1.0 if x[0] >= 0.0 else -1.0))
    return divide(scale(fall, 2.0), add((1.0, 0.0), multiply(fall, fall)))


@njit(error_model="numpy")
def _reciprocal(x: Pair) -> Pair:
    """1/x with relative error below 2^-101."""
    q = 1.0 / x[0]
    rest = fma(-q, x[0], 1.0)
    return quick_two_sum(q, q * (rest - q * x[1]))


@njit(error_model="numpy")
def _binary(operation: int, x: Array, y: Array, z: Array) -> None:
    if operation == 0:
        for i in range(BLOCK):
            z[i], z[i + BLOCK] = add((x[i], x[i + BLOCK]), (y[i], y[i + BLOCK]))
    elif operation == 1:
        for i in range(BLOCK):
            z[i], z[i + BLOCK] = subtract((x[i], x[i + BLOCK]), (y[i], y[i + BLOCK]))
    else:
        for i in range(BLOCK):
            z[i], z[i + BLOCK] = multiply((x[i], x[i + BLOCK]), (y[i], y[i + BLOCK]))


@njit(error_model="numpy")
def _with_constant(operation: int, x: Array, c: Pair, z: Array) -> None:
    if operation == 3:
        for i in range(BLOCK):
            z[i], z[i + BLOCK] = add((x[i], x[i + BLOCK]), c)
    elif operation == 4:
        for i in range(BLOCK):
            z[i], z[i + BLOCK] = subtract(c, (x[i], x[i + BLOCK]))
    elif operation == 5:
        for i in range(BLOCK):
            z[i], z[i + BLOCK] = multiply((x[i], x[i + BLOCK]), c)
    else:
        for i in range(BLOCK):
            z[i], z[i + BLOCK] = c


@njit(error_model="numpy")
def _unary(operation: int, x: Array, z: Array) -> None:
    if operation == 7:
        for i in range(BLOCK):
            z[i], z[i + BLOCK] = _reciprocal((x[i], x[i + BLOCK]))
    elif operation == 8:
        for i in range(BLOCK):
            z[i], z[i + BLOCK] = square_root((x[i], x[i + BLOCK]))
    elif operation == 9:
        for i in range(BLOCK):
            z[i], z[i + BLOCK] = _logarithm((x[i], x[i + BLOCK]))
    elif operation == 10:
        for i in range(BLOCK):
            z[i], z[i + BLOCK] = _exponential((x[i], x[i + BLOCK]))
    elif operation == 11:
        for i in range(BLOCK):
            z[i], z[i + BLOCK] = _tanh((x[i], x[i + BLOCK]))
    else:
        for i in range(BLOCK):
            z[i], z[i + BLOCK] = _sech((x[i], x[i + BLOCK]))


@njit(cache=True, nogil=True, error_model="numpy")
def _run(
    code: NDArray[np.int64],
    constants: Array,
    registers: Array,
    outputs: NDArray[np.int64],
    inputs: Array,
    out: Array,
) -> None:
    """Block after block; the points beyond the last are copies of it."""
    points = inputs.shape[2]
    for start in range(0, points, BLOCK):
        for row in range(inputs.shape[0]):
            for i in range(BLOCK):
                place = min(start + i, points - 1)
                registers[row, i] = inputs[row, 0, place]
                registers[row, i + BLOCK] = inputs[row, 1, place]
        for line in range(code.shape[0]):
            operation, z, x = code[line, 0], registers[code[line, 1]], registers[code[line, 2]]
            if operation < 3:
                _binary(operation, x, registers[code[line, 3]], z)
            elif operation < 7:
                c = constants[code[line, 3]]
                _with_constant(operation, x, (c[0], c[1]), z)
            else:
                _unary(operation, x, z)
        for row in range(outputs.size):
            for i in range(min(BLOCK, points - start)):
                out[row, 0, start + i] = registers[outputs[row], i]
                out[row, 1, start + i] = registers[outputs[row], i + BLOCK]


@njit(cache=True, nogil=True, error_model="numpy")
def _scale(row: Array, factor: Pair) -> None:
    for i in range(row.shape[1]):
        row[0, i], row[1, i] = multiply((row[0, i], row[1, i]), factor)


def scale_rows(rows: Array, factors: Sequence[Pair]) -> Array:
    """Multiply each row (2, ...) of pairs by its factor, in place."""
    for row, factor in zip(rows, factors, strict=True):
        _scale(row.reshape(2, -1), factor)
    return rows


def run_pairs(bytecode: Bytecode, constants: Array, inputs: Array, out: Array) -> None:
    """Fill ``out`` (outputs, 2, points) from ``inputs`` (inputs, 2, points).

    ``constants`` (2 columns: high and low part) are the values of ``bytecode.pool``.
    """
    registers = np.zeros((bytecode.registers, 2 * BLOCK))
    outputs = np.array(bytecode.outputs, dtype=np.int64)
    _run(bytecode.code, constants, registers, outputs, inputs, out)
