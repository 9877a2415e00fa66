"""The register machine in double precision, on blocks of points."""

import math

import numpy as np
from numpy.typing import NDArray

from solutions.bytecode import Bytecode
from solutions.jit import njit

__all__ = ["run_double"]

Array = NDArray[np.float64]
BLOCK = 256


@njit(error_model="numpy")
def _sech(x: float) -> float:
    decay = math.exp(-abs(x))
    return 2.0 * decay / (1.0 + decay * decay)


@njit(error_model="numpy")
def _binary(operation: int, x: Array, y: Array, z: Array) -> None:
    if operation == 0:
        for i in range(BLOCK):
            z[i] = x[i] + y[i]
    elif operation == 1:
        for i in range(BLOCK):
            z[i] = x[i] - y[i]
    else:
        for i in range(BLOCK):
            z[i] = x[i] * y[i]


@njit(error_model="numpy")
def _with_constant(operation: int, x: Array, c: float, z: Array) -> None:
    if operation == 3:
        for i in range(BLOCK):
            z[i] = x[i] + c
    elif operation == 4:
        for i in range(BLOCK):
            z[i] = c - x[i]
    elif operation == 5:
        for i in range(BLOCK):
            z[i] = x[i] * c
    else:
        for i in range(BLOCK):
            z[i] = c


@njit(error_model="numpy")
def _unary(operation: int, x: Array, z: Array) -> None:
    if operation == 7:
        for i in range(BLOCK):
            z[i] = 1.0 / x[i]
    elif operation == 8:
        for i in range(BLOCK):
            z[i] = math.sqrt(x[i])
    elif operation == 9:
        for i in range(BLOCK):
            z[i] = math.log(x[i])
    elif operation == 10:
        for i in range(BLOCK):
            z[i] = math.exp(x[i])
    elif operation == 11:
        for i in range(BLOCK):
            z[i] = math.tanh(x[i])
    else:
        for i in range(BLOCK):
            z[i] = _sech(x[i])


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
    points = inputs.shape[1]
    for start in range(0, points, BLOCK):
        for row in range(inputs.shape[0]):
            for i in range(BLOCK):
                registers[row, i] = inputs[row, min(start + i, points - 1)]
        for line in range(code.shape[0]):
            operation, z, x = code[line, 0], registers[code[line, 1]], registers[code[line, 2]]
            if operation < 3:
                _binary(operation, x, registers[code[line, 3]], z)
            elif operation < 7:
                _with_constant(operation, x, constants[code[line, 3]], z)
            else:
                _unary(operation, x, z)
        for row in range(outputs.size):
            for i in range(min(BLOCK, points - start)):
                out[row, start + i] = registers[outputs[row], i]


def run_double(bytecode: Bytecode, constants: Array, inputs: Array, out: Array) -> None:
    """Fill ``out`` (outputs, points) from ``inputs`` (inputs, points).

    ``constants`` are the values of ``bytecode.pool``.
    """
    registers = np.zeros((bytecode.registers, BLOCK))
    outputs = np.array(bytecode.outputs, dtype=np.int64)
    _run(bytecode.code, constants, registers, outputs, inputs, out)
