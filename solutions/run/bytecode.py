"""Programs for the machine: the format of their instructions, and a builder of programs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray


class Operation(IntEnum):
    """Semantics of each instruction: result from registers ``a``, ``b`` and constant ``c``."""

    ADD = 0  # a + b
    SUBTRACT = 1  # a - b
    MULTIPLY = 2  # a b
    CHOOSE = 3  # a where register c is 1, b where it is 0
    ADD_CONSTANT = 4  # a + c
    FROM_CONSTANT = 5  # c - a
    MULTIPLY_CONSTANT = 6  # a c
    SCALE = 7  # a c for a power of two c, or minus one
    CONSTANT = 8  # c
    RECIPROCAL = 9  # 1/a
    SQUARE_ROOT = 10
    LOGARITHM = 11
    EXPONENTIAL = 12
    TANH = 13
    SECH = 14
    SINE = 15  # of |a| <= 0.79
    COSINE = 16  # of |a| <= 0.79


WITH_CONSTANT = tuple(Operation)[Operation.ADD_CONSTANT : Operation.CONSTANT + 1]
"""Operations that read a constant."""


@dataclass(frozen=True)
class Bytecode:
    """Instructions ``(operation, target, a, b, c)``, one a row.

    ``a`` and ``b`` are registers, ``c`` is a constant or, for CHOOSE, a register. At the start the
    inputs are in registers ``0 .. inputs - 1``; ``outputs`` are the registers of the results.
    ``pool`` holds the constants: exact numbers, or expressions to be evaluated.
    """

    code: NDArray[np.int64]
    registers: int
    inputs: int
    outputs: tuple[int, ...]
    pool: tuple[Any, ...]

    def only(self, outputs: Sequence[int]) -> tuple[Bytecode, frozenset[int]]:
        """Return the code that computes only the registers ``outputs``, and the inputs it reads.

        >>> code = Code(inputs=2)
        >>> x, y = Value(code, 0), Value(code, 1)
        >>> both = code.assemble([(x * x).number, (x * y).number])
        >>> square, read = both.only(both.outputs[:1])
        >>> len(square.code), sorted(read)
        (1, [0])
        """
        live, rows = set(outputs), []
        for row in self.code[::-1].tolist():
            operation, target, *operands = row
            if target in live:
                live.remove(target)
                live.update(_operands(Operation(operation), *operands))
                rows.append(row)
        code = np.array(rows[::-1], dtype=np.int64).reshape(-1, 5)
        return replace(self, code=code, outputs=tuple(outputs)), frozenset(live)


class Code:
    """Builder of instructions on numbered values, inputs first; equal instructions are shared."""

    def __init__(self, inputs: int) -> None:
        self._inputs = inputs
        self._instructions: list[tuple[Operation, int, int, int]] = []
        self._numbered: dict[tuple[Operation, int, int, int], int] = {}
        self._pool: dict[Any, int] = {}

    def emit(self, operation: Operation, a: int = 0, b: int | None = None, c: int = 0) -> int:
        """Append an instruction and return the number of its result; ``b`` defaults to ``a``."""
        key = (operation, a, a if b is None else b, c)
        if key not in self._numbered:
            self._numbered[key] = self._inputs + len(self._instructions)
            self._instructions.append(key)
        return self._numbered[key]

    def with_constant(self, operation: Operation, constant: Any, a: int = 0) -> int:
        """Append an operation with a constant and return the number of its result."""
        return self.emit(operation, a, None, self._pool.setdefault(constant, len(self._pool)))

    def number(self, value: Any) -> int:
        """Return the number of a `Value`, or of a constant, which is appended if it is new."""
        is_value = isinstance(value, Value)
        return value.number if is_value else self.with_constant(Operation.CONSTANT, value)

    def assemble(self, outputs: Sequence[int]) -> Bytecode:
        """Return the code that computes the values ``outputs``, without unneeded instructions."""
        operands = [_operands(*instruction) for instruction in self._instructions]
        live, registers_of, registers = allocate(self._inputs, operands, outputs)
        rows = []
        for index in live:
            operation, a, b, c = self._instructions[index]
            read = (0, 0) if operation is Operation.CONSTANT else (registers_of[a], registers_of[b])
            third = registers_of[c] if operation is Operation.CHOOSE else c
            rows.append((operation, registers_of[self._inputs + index], *read, third))
        code = np.array(rows, dtype=np.int64).reshape(-1, 5)
        output_registers = tuple(registers_of[value] for value in outputs)
        return Bytecode(code, registers, self._inputs, output_registers, tuple(self._pool))


def _operands(operation: Operation, a: int, b: int, c: int) -> tuple[int, ...]:
    """Return the numbers of the values that an instruction reads."""
    if operation is Operation.CONSTANT:
        return ()
    if operation is Operation.CHOOSE:
        return tuple({a, b, c})
    return (a,) if operation in WITH_CONSTANT or a == b else (a, b)


class Value:
    """A value in a program under construction; Python's operators on it append instructions.

    Constants are exact (mpf or int); trivial operations with them take no instruction.

    >>> code = Code(inputs=1)
    >>> x = Value(code, 0)
    >>> y = 3 * x * (1 - x) + 0 * x
    >>> [Operation(row[0]).name for row in code.assemble([y.number]).code]
    ['MULTIPLY_CONSTANT', 'FROM_CONSTANT', 'MULTIPLY']
    """

    def __init__(self, code: Code, number: int) -> None:
        self.code = code
        self.number = number

    def apply(self, operation: Operation, *others: Value) -> Value:
        """Append an operation on this value and others; return its result."""
        numbers = [value.number for value in others]
        return Value(self.code, self.code.emit(operation, self.number, *numbers))

    def __add__(self, other: Any) -> Value:
        if isinstance(other, Value):
            return self.apply(Operation.ADD, other)
        return self if other == 0 else self._fixed(Operation.ADD_CONSTANT, other)

    def __sub__(self, other: Any) -> Value:
        return self.apply(Operation.SUBTRACT, other) if isinstance(other, Value) else self + -other

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, Value):
            return self.apply(Operation.MULTIPLY, other)
        if other in (0, 1):
            return self if other == 1 else 0
        mantissa, _ = math.frexp(other)
        is_exact = abs(mantissa) == 0.5 and float(other) == other
        return self._fixed(Operation.SCALE if is_exact else Operation.MULTIPLY_CONSTANT, other)

    def __rsub__(self, other: Any) -> Value:
        return self._fixed(Operation.FROM_CONSTANT, other)

    def _fixed(self, operation: Operation, constant: Any) -> Value:
        return Value(self.code, self.code.with_constant(operation, constant, self.number))

    __radd__, __rmul__ = __add__, __mul__


def allocate(
    inputs: int, operands: Sequence[tuple[int, ...]], outputs: Sequence[int]
) -> tuple[list[int], dict[int, int], int]:
    """Drop dead instructions and assign registers to values, reused after their last use.

    Value ``i < inputs`` is an input, value ``inputs + n`` the result of instruction n with the
    values ``operands[n]``. Returns the live instructions in order, the register of every live
    value and the number of registers. No instruction writes to a register that it reads, so that
    its loop over points has no overlap.

    >>> allocate(1, [(0,), (0,), (1,), (3,)], [4])
    ([0, 2, 3], {0: 0, 1: 1, 3: 0, 4: 1}, 2)
    """
    last = {value: len(operands) for value in outputs}  # last instruction that reads a live value
    for index in range(len(operands) - 1, -1, -1):
        if inputs + index in last:
            for value in operands[index]:
                last.setdefault(value, index)
    register_of = {value: value for value in range(inputs)}
    free = [value for value in range(inputs) if value not in last]
    count, live = inputs, []
    for index, used in enumerate(operands):
        if inputs + index not in last:
            continue
        live.append(index)
        count += not free
        register_of[inputs + index] = free.pop() if free else count - 1
        free += [register_of[value] for value in used if last[value] == index]
    return live, register_of, count
