"""From SymPy statements to bytecode for a register machine, one operation an instruction.

``Assembler`` makes instructions on numbered values, equal ones shared and everything constant
folded into a pool; it drops what no output needs and assigns registers, of which few are live at
a time.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import sympy as sp
from numpy.typing import NDArray

__all__ = ["Assembler", "Bytecode", "Operation"]


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


def allocate(
    inputs: int, operands: Sequence[tuple[int, ...]], outputs: Sequence[int]
) -> tuple[list[int], dict[int, int], int]:
    """Drop dead instructions and give every value a register, reused after its last use.

    Value ``i < inputs`` is an input, value ``inputs + n`` the result of instruction n with the
    values ``operands[n]``. Returns the kept instructions in order, the register of every live
    value and the number of registers. No instruction writes to a register it reads, so that its
    loop over points has no overlap.

    >>> allocate(1, [(0,), (0,), (1,), (3,)], [4])
    ([0, 2, 3], {0: 0, 1: 1, 3: 0, 4: 1}, 2)
    """
    last = _last_uses(inputs, operands, outputs)
    place = {value: value for value in range(inputs)}
    free = [value for value in range(inputs) if value not in last]
    count, kept = inputs, []
    for index, used in enumerate(operands):
        if inputs + index not in last:
            continue
        kept.append(index)
        if free:
            place[inputs + index] = free.pop()
        else:
            place[inputs + index] = count
            count += 1
        free += [place[value] for value in used if last[value] == index]
    return kept, place, count


def _last_uses(
    inputs: int, operands: Sequence[tuple[int, ...]], outputs: Sequence[int]
) -> dict[int, int]:
    """The last instruction that needs each live value; outputs live to the end."""
    last = {value: len(operands) for value in outputs}
    for index in range(len(operands) - 1, -1, -1):
        if inputs + index in last:
            for value in operands[index]:
                last.setdefault(value, index)
    return last


_FUNCTIONS = {
    sp.log: Operation.LOGARITHM,
    sp.exp: Operation.EXPONENTIAL,
    sp.tanh: Operation.TANH,
    sp.sech: Operation.SECH,
}


class Assembler:
    """Instructions on numbered values; the inputs are the first values.

    >>> x, c = sp.symbols("x c")
    >>> assembler = Assembler([x])
    >>> result = assembler.value(c * x + 2 * c)
    >>> assembler.assemble([result]).pool
    (c, 2*c)
    """

    def __init__(self, inputs: Sequence[sp.Symbol]) -> None:
        self._inputs = len(inputs)
        self._values: dict[sp.Expr, int] = {symbol: i for i, symbol in enumerate(inputs)}
        self._instructions: list[tuple[Operation, int, int]] = []
        self._numbered: dict[tuple[Operation, int, int], int] = {}
        self._pool: dict[sp.Expr, int] = {}
        self._fixed: dict[sp.Expr, sp.Expr] = {}

    def define(self, symbol: sp.Symbol, expression: sp.Expr) -> None:
        """Let ``symbol`` stand for ``expression`` in what follows."""
        expression = expression.xreplace(self._fixed)
        if self._is_constant(expression):
            self._fixed[symbol] = expression
        else:
            self._values[symbol] = self._value(expression)

    def value(self, expression: sp.Expr) -> int:
        """The number of the value that holds ``expression``."""
        return self._value(expression.xreplace(self._fixed))

    def _value(self, expression: sp.Expr) -> int:
        if expression not in self._values:
            self._values[expression] = self._compile(expression)
        return self._values[expression]

    def assemble(self, outputs: Sequence[int]) -> Bytecode:
        """The code for these values."""
        operands = [_operands(*instruction) for instruction in self._instructions]
        kept, place, registers = allocate(self._inputs, operands, outputs)
        rows = []
        for index in kept:
            operation, a, b = self._instructions[index]
            second = b if operation in WITH_CONSTANT else place[b]
            first = 0 if operation is Operation.CONSTANT else place[a]
            rows.append((operation, place[self._inputs + index], first, second))
        code = np.array(rows, dtype=np.int64).reshape(-1, 4)
        found = tuple(place[value] for value in outputs)
        return Bytecode(code, registers, self._inputs, found, tuple(self._pool))

    def _compile(self, expression: sp.Expr) -> int:
        if self._is_constant(expression):
            return self._emit(Operation.CONSTANT, 0, self._constant(expression))
        if expression.is_Add:
            return self._sum(expression)
        if expression.is_Mul:
            return self._product(expression)
        if expression.is_Pow:
            return self._power(expression.base, expression.exp)
        if expression.func in _FUNCTIONS:
            return self._unary(_FUNCTIONS[expression.func], self._value(expression.args[0]))
        raise ValueError(
            f"functions must be among those with an instruction, got {expression.func.__name__} "
            "(add one to solutions.compile.assembler)"
        )

    def _sum(self, expression: sp.Expr) -> int:
        constant, terms = self._split(expression)
        total, negative = self._signed(terms[0])
        for term in terms[1:]:
            other, other_negative = self._signed(term)
            if negative == other_negative:
                total = self._emit(Operation.ADD, *sorted((total, other)))
            else:
                first, second = (other, total) if negative else (total, other)
                total, negative = self._emit(Operation.SUBTRACT, first, second), False
        if constant == 0:
            return self._times(total, sp.S.NegativeOne) if negative else total
        operation = Operation.FROM_CONSTANT if negative else Operation.ADD_CONSTANT
        return self._emit(operation, total, self._constant(constant))

    def _signed(self, term: sp.Expr) -> tuple[int, bool]:
        negative = bool(term.as_coeff_Mul()[0].is_negative)
        return self._value(-term if negative else term), negative

    def _product(self, expression: sp.Expr) -> int:
        constant, factors = self._split(expression)
        numbers = sorted(self._value(factor) for factor in factors)
        total = numbers[0]
        for number in numbers[1:]:
            total = self._emit(Operation.MULTIPLY, *sorted((total, number)))
        return total if constant == 1 else self._times(total, constant)

    def _power(self, base: sp.Expr, exponent: sp.Expr) -> int:
        if not (2 * exponent).is_Integer:
            raise ValueError(
                f"exponents must be multiples of 1/2, got {exponent} (write it with exp and log)"
            )
        if exponent < 0:
            return self._unary(Operation.RECIPROCAL, self._value(base**-exponent))
        if not exponent.is_Integer:
            root = self._unary(Operation.SQUARE_ROOT, self._value(base))
            return self._integer_power(root, int(2 * exponent))
        return self._integer_power(self._value(base), int(exponent))

    def _integer_power(self, base: int, exponent: int) -> int:
        if exponent == 1:
            return base
        half = self._integer_power(base, exponent // 2)
        square = self._emit(Operation.MULTIPLY, half, half)
        if exponent % 2 == 0:
            return square
        return self._emit(Operation.MULTIPLY, *sorted((base, square)))

    def _split(self, expression: sp.Expr) -> tuple[sp.Expr, list[sp.Expr]]:
        """The constant part of a sum or product, and the other arguments."""
        fixed = [part for part in expression.args if self._is_constant(part)]
        varying = [part for part in expression.args if not self._is_constant(part)]
        return expression.func(*fixed), varying

    def _is_constant(self, expression: sp.Expr) -> bool:
        return not any(symbol in self._values for symbol in expression.free_symbols)

    def _constant(self, expression: sp.Expr) -> int:
        return self._pool.setdefault(expression, len(self._pool))

    def _times(self, value: int, constant: sp.Expr) -> int:
        exact = constant.is_Rational and _is_power_of_two(constant)
        operation = Operation.SCALE if exact else Operation.MULTIPLY_CONSTANT
        return self._emit(operation, value, self._constant(constant))

    def _unary(self, operation: Operation, value: int) -> int:
        return self._emit(operation, value, value)

    def _emit(self, operation: Operation, first: int, second: int) -> int:
        key = (operation, first, second)
        if key not in self._numbered:
            self._numbered[key] = self._inputs + len(self._instructions)
            self._instructions.append(key)
        return self._numbered[key]


def _is_power_of_two(number: sp.Rational) -> bool:
    """Whether multiplication by ``number`` rounds nothing."""
    return min(abs(number.p), number.q) == 1 and max(abs(number.p), number.q).bit_count() == 1


def _operands(operation: Operation, first: int, second: int) -> tuple[int, ...]:
    """The values that an instruction reads."""
    if operation is Operation.CONSTANT:
        return ()
    if operation in WITH_CONSTANT or first == second:
        return (first,)
    return first, second
