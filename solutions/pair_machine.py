"""The register machine in double-double, on blocks of points: a register is a block."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from solutions.bytecode import Bytecode
from solutions.jit import njit
from solutions.pair_functions import SCRATCH, exponential, logarithm, sech, tanh
from solutions.special.blocks import BLOCK, load, store
from solutions.special.doubledouble import (
    Pair,
    add,
    multiply,
    reciprocal,
    square_root,
    subtract,
)

__all__ = ["run_pairs", "scale_rows"]

Array = NDArray[np.float64]


@njit(error_model="numpy")
def _binary(operation: int, x: Array, y: Array, z: Array) -> None:
    if operation == 0:
        for i in range(BLOCK):
            store(z, i, add(load(x, i), load(y, i)))
    elif operation == 1:
        for i in range(BLOCK):
            store(z, i, subtract(load(x, i), load(y, i)))
    else:
        for i in range(BLOCK):
            store(z, i, multiply(load(x, i), load(y, i)))


@njit(error_model="numpy")
def _with_constant(operation: int, x: Array, c: Pair, z: Array) -> None:
    if operation == 3:
        for i in range(BLOCK):
            store(z, i, add(load(x, i), c))
    elif operation == 4:
        for i in range(BLOCK):
            store(z, i, subtract(c, load(x, i)))
    elif operation == 5:
        for i in range(BLOCK):
            store(z, i, multiply(load(x, i), c))
    else:
        for i in range(BLOCK):
            store(z, i, c)


@njit(error_model="numpy")
def _unary(operation: int, x: Array, z: Array, scratch: Array) -> None:
    if operation == 7:
        for i in range(BLOCK):
            store(z, i, reciprocal(load(x, i)))
    elif operation == 8:
        for i in range(BLOCK):
            store(z, i, square_root(load(x, i)))
    elif operation == 9:
        logarithm(x, z, scratch)
    elif operation == 10:
        exponential(x, z, scratch)
    elif operation == 11:
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
    scratch = np.zeros((SCRATCH, 2 * BLOCK))
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
                _unary(operation, x, z, scratch)
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
