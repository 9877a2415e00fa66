"""The register machine: double-double numbers with bounds of their errors, on blocks of points.

A register is a block of ``solutions.run.bounded``.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from solutions.compile.assembler import Bytecode, Operation
from solutions.run.block_functions import BLOCK
from solutions.run.bounded import (
    PARTS,
    UNIT,
    Bounded,
    add,
    load,
    multiply,
    negate,
    reciprocal,
    scale,
    square_root,
    store,
)
from solutions.run.bounded_functions import SCRATCH, exponential, logarithm, sech, tanh
from solutions.run.doubledouble import Pair
from solutions.run.jit import njit

__all__ = ["run_pairs", "scale_rows"]

Array = NDArray[np.float64]

_ADD, _MULTIPLY = int(Operation.ADD), int(Operation.MULTIPLY)
_ADD_CONSTANT, _FROM_CONSTANT = int(Operation.ADD_CONSTANT), int(Operation.FROM_CONSTANT)
_MULTIPLY_CONSTANT, _SCALE = int(Operation.MULTIPLY_CONSTANT), int(Operation.SCALE)
_CONSTANT, _RECIPROCAL = int(Operation.CONSTANT), int(Operation.RECIPROCAL)
_SQUARE_ROOT, _LOGARITHM = int(Operation.SQUARE_ROOT), int(Operation.LOGARITHM)
_EXPONENTIAL, _TANH = int(Operation.EXPONENTIAL), int(Operation.TANH)


@njit(error_model="numpy")
def _binary(operation: int, x: Array, y: Array, z: Array) -> None:
    if operation == _MULTIPLY:
        for i in range(BLOCK):
            store(z, i, multiply(load(x, i), load(y, i)))
    elif operation == _ADD:
        for i in range(BLOCK):
            store(z, i, add(load(x, i), load(y, i)))
    else:
        for i in range(BLOCK):
            store(z, i, add(load(x, i), negate(load(y, i))))


@njit(error_model="numpy")
def _with_constant(operation: int, x: Array, c: Bounded, z: Array) -> None:
    if operation == _MULTIPLY_CONSTANT:
        for i in range(BLOCK):
            store(z, i, multiply(load(x, i), c))
    elif operation == _SCALE:
        for i in range(BLOCK):
            store(z, i, scale(load(x, i), c[0]))
    elif operation == _ADD_CONSTANT:
        for i in range(BLOCK):
            store(z, i, add(load(x, i), c))
    elif operation == _FROM_CONSTANT:
        for i in range(BLOCK):
            store(z, i, add(c, negate(load(x, i))))
    else:
        for i in range(BLOCK):
            store(z, i, c)


@njit(error_model="numpy")
def _unary(operation: int, x: Array, z: Array, scratch: Array) -> None:
    if operation == _RECIPROCAL:
        for i in range(BLOCK):
            store(z, i, reciprocal(load(x, i)))
    elif operation == _SQUARE_ROOT:
        for i in range(BLOCK):
            store(z, i, square_root(load(x, i)))
    elif operation == _LOGARITHM:
        logarithm(x, z, scratch)
    elif operation == _EXPONENTIAL:
        exponential(x, z, scratch)
    elif operation == _TANH:
        tanh(x, z, scratch)
    else:
        sech(x, z, scratch)


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
    scratch = np.zeros((SCRATCH, PARTS * BLOCK))
    points = inputs.shape[2]
    for start in range(0, points, BLOCK):
        count = min(BLOCK, points - start)
        for row in range(inputs.shape[0]):
            for part in range(PARTS):
                for i in range(BLOCK):
                    place = start + min(i, count - 1)
                    registers[row, part * BLOCK + i] = inputs[row, part, place]
        for line in range(code.shape[0]):
            operation, z, x = code[line, 0], registers[code[line, 1]], registers[code[line, 2]]
            if operation <= _MULTIPLY:
                _binary(operation, x, registers[code[line, 3]], z)
            elif operation <= _CONSTANT:
                c = constants[code[line, 3]]
                _with_constant(operation, x, (c[0], c[1], c[2]), z)
            else:
                _unary(operation, x, z, scratch)
        for row in range(outputs.size):
            for part in range(PARTS):
                for i in range(count):
                    out[row, part, start + i] = registers[outputs[row], part * BLOCK + i]


@njit(cache=True, nogil=True, error_model="numpy")
def _scale_row(row: Array, factor: Pair) -> None:
    for i in range(row.shape[1]):
        bounded = factor[0], factor[1], UNIT * abs(factor[0])
        row[0, i], row[1, i], row[2, i] = multiply((row[0, i], row[1, i], row[2, i]), bounded)


def scale_rows(rows: Array, factors: Sequence[Pair]) -> Array:
    """Multiply each row (3, ...) of bounded numbers by its factor, in place."""
    for row, factor in zip(rows, factors, strict=True):
        _scale_row(row.reshape(PARTS, -1), factor)
    return rows


def run_pairs(bytecode: Bytecode, constants: Array, inputs: Array, out: Array) -> None:
    """Fill ``out`` (outputs, 3, points) from ``inputs`` (inputs, 3, points).

    The second axis is high part, low part and bound of the error. ``constants`` (2 columns: high
    and low part) are the nearest pairs to the values of ``bytecode.pool``.
    """
    registers = np.zeros((bytecode.registers, PARTS * BLOCK))
    outputs = np.array(bytecode.outputs, dtype=np.int64)
    bounds = 2.0**-105 * np.abs(constants[:, :1])
    _run(bytecode.code, np.hstack([constants, bounds]), registers, outputs, inputs, out)
