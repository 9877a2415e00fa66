"""Straight-line code for a register machine: one elementary operation an instruction."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import sympy as sp
from numpy.typing import NDArray

__all__ = ["WITH_CONSTANT", "Bytecode", "Operation"]


class Operation(IntEnum):
    """What an instruction does with registers ``a``, ``b`` and the constant ``c``."""

    ADD = 0  # a + b
    SUBTRACT = 1  # a - b
    MULTIPLY = 2  # a b
    ADD_CONSTANT = 3  # a + c
    FROM_CONSTANT = 4  # c - a
    MULTIPLY_CONSTANT = 5  # a c
    SCALE = 6  # a c for a power of two c, or minus one
    CONSTANT = 7  # c
    RECIPROCAL = 8  # 1/a
    SQUARE_ROOT = 9
    LOGARITHM = 10
    EXPONENTIAL = 11
    TANH = 12
    SECH = 13


WITH_CONSTANT = (
    Operation.ADD_CONSTANT,
    Operation.FROM_CONSTANT,
    Operation.MULTIPLY_CONSTANT,
    Operation.SCALE,
    Operation.CONSTANT,
)


@dataclass(frozen=True)
class Bytecode:
    """Instructions ``(operation, target, a, b or constant)``, one a row.

    The inputs are in registers ``0 .. inputs - 1`` at the start; ``outputs`` are the registers of
    the results. ``pool`` holds the constants as expressions.
    """

    code: NDArray[np.int64]
    registers: int
    inputs: int
    outputs: tuple[int, ...]
    pool: tuple[sp.Expr, ...]
