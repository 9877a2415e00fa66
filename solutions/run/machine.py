"""The register machine: double-double numbers with bounds of their errors, on blocks of points.

A register is a block of ``solutions.run.bounded``.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from longwave.solutions.run import elementary
from longwave.solutions.run.bounded import (
    BLOCK,
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
from longwave.solutions.run.bytecode import Bytecode, Operation
from longwave.solutions.run.doubledouble import Array, Pair
from longwave.support.compiled.jit import doubles, integers, njit


@njit()
def _binary(operation: int, x: Array, y: Array, z: Array) -> None:
    if operation == Operation.MULTIPLY:
        for i in range(BLOCK):
            store(z, i, multiply(load(x, i), load(y, i)))
    elif operation == Operation.ADD:
        for i in range(BLOCK):
            store(z, i, add(load(x, i), load(y, i)))
    else:
        for i in range(BLOCK):
            store(z, i, add(load(x, i), negate(load(y, i))))


@njit()
def _choose(chosen: Array, x: Array, y: Array, z: Array) -> None:
    for part in range(PARTS):
        for i in range(BLOCK):
            index = part * BLOCK + i
            z[index] = x[index] if chosen[i] == 1.0 else y[index]


@njit()
def _with_constant(operation: int, x: Array, c: Bounded, z: Array) -> None:
    if operation == Operation.MULTIPLY_CONSTANT:
        for i in range(BLOCK):
            store(z, i, multiply(load(x, i), c))
    elif operation == Operation.SCALE:
        for i in range(BLOCK):
            store(z, i, scale(load(x, i), c[0]))
    elif operation == Operation.ADD_CONSTANT:
        for i in range(BLOCK):
            store(z, i, add(load(x, i), c))
    elif operation == Operation.FROM_CONSTANT:
        for i in range(BLOCK):
            store(z, i, add(c, negate(load(x, i))))
    else:
        for i in range(BLOCK):
            store(z, i, c)


@njit()
def _unary(operation: int, x: Array, z: Array, scratch: Array) -> None:
    if operation == Operation.RECIPROCAL:
        for i in range(BLOCK):
            store(z, i, reciprocal(load(x, i)))
    elif operation == Operation.SQUARE_ROOT:
        for i in range(BLOCK):
            store(z, i, square_root(load(x, i)))
    elif operation in (Operation.SINE, Operation.COSINE):
        elementary.sine_or_cosine(x, operation == Operation.SINE, z, scratch)
    else:
        _exponential(operation, x, z, scratch)


@njit()
def _exponential(operation: int, x: Array, z: Array, scratch: Array) -> None:
    """Fill ``z`` with exp, log, tanh or sech of ``x``, by ``operation``; all use exp(-|x|)."""
    source, power = x, z
    if operation == Operation.LOGARITHM:
        source, power = scratch[5], scratch[6]
        elementary.start_logarithm(x, source)
    elementary.decay_of(source, 2.0 if operation == Operation.TANH else 1.0, scratch)
    if operation == Operation.TANH:
        elementary.tanh(x, z, scratch)
    elif operation == Operation.SECH:
        elementary.sech(x, z, scratch)
    else:
        elementary.exponential(source, power, scratch)
    if operation == Operation.LOGARITHM:
        elementary.logarithm(x, source, power, z)


_EXAMPLE = (
    *(integers(2), doubles(2), doubles(2)),
    *(integers(1), doubles(3), doubles(2), doubles(3)),
)


@njit(cache=True, examples=[_EXAMPLE])
def _run(
    code: NDArray[np.int64],
    constants: Array,
    registers: Array,
    outputs: NDArray[np.int64],
    inputs: Array,
    scratch: Array,
    out: Array,
) -> None:
    """Fill ``out`` by running the code on blocks of points; the last point pads the last block."""
    points = inputs.shape[2]
    for start in range(0, points, BLOCK):
        count = min(BLOCK, points - start)
        for row in range(inputs.shape[0]):
            for part in range(PARTS):
                for i in range(BLOCK):
                    source = start + min(i, count - 1)
                    registers[row, part * BLOCK + i] = inputs[row, part, source]
        for line in range(code.shape[0]):
            operation, z, x = code[line, 0], registers[code[line, 1]], registers[code[line, 2]]
            if operation <= Operation.MULTIPLY:
                _binary(operation, x, registers[code[line, 3]], z)
            elif operation == Operation.CHOOSE:
                _choose(registers[code[line, 4]], x, registers[code[line, 3]], z)
            elif operation <= Operation.CONSTANT:
                c = constants[code[line, 4]]
                _with_constant(operation, x, (c[0], c[1], c[2]), z)
            else:
                _unary(operation, x, z, scratch)
        for row in range(outputs.size):
            for part in range(PARTS):
                for i in range(count):
                    out[row, part, start + i] = registers[outputs[row], part * BLOCK + i]


@njit(cache=True, examples=[(doubles(2), (0.0, 0.0))])
def _scale_row(row: Array, factor: Pair) -> None:
    for i in range(row.shape[1]):
        bounded = factor[0], factor[1], UNIT * abs(factor[0])
        row[0, i], row[1, i], row[2, i] = multiply((row[0, i], row[1, i], row[2, i]), bounded)


@njit(cache=True, examples=[(doubles(2), doubles(2), (0.0, 0.0))])
def _add_row(row: Array, other: Array, factor: Pair) -> None:
    bounded = factor[0], factor[1], UNIT * abs(factor[0])
    for i in range(row.shape[1]):
        part = multiply((other[0, i], other[1, i], other[2, i]), bounded)
        row[0, i], row[1, i], row[2, i] = add((row[0, i], row[1, i], row[2, i]), part)


def add_row(row: Array, other: Array, factor: Pair) -> None:
    """Add ``factor`` times the bounded numbers ``other`` (3, ...) to ``row``, in place."""
    _add_row(row.reshape(PARTS, -1), other.reshape(PARTS, -1), factor)


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
    scratch = np.zeros((elementary.SCRATCH, PARTS * BLOCK))
    _run(bytecode.code, np.hstack([constants, bounds]), registers, outputs, inputs, scratch, out)
