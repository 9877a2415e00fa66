"""Assembly of SymPy expressions into bytecode, one operation an instruction.

Constant subexpressions are evaluated once and kept in the pool.
"""

from collections.abc import Sequence

import sympy as sp

from longwave.solutions.run.bytecode import Code, Operation

_FUNCTIONS = {
    sp.log: Operation.LOGARITHM,
    sp.exp: Operation.EXPONENTIAL,
    sp.tanh: Operation.TANH,
    sp.sech: Operation.SECH,
}


class Assembler(Code):
    """Builder of instructions from SymPy expressions; its values are numbered, inputs first.

    >>> x, c = sp.symbols("x c")
    >>> assembler = Assembler([x])
    >>> result = assembler.value(c * x + 2 * c)
    >>> assembler.assemble([result]).pool
    (c, 2*c)
    """

    def __init__(self, inputs: Sequence[sp.Symbol]) -> None:
        super().__init__(len(inputs))
        self._values: dict[sp.Expr, int] = {symbol: i for i, symbol in enumerate(inputs)}
        self._fixed: dict[sp.Expr, sp.Expr] = {}

    def define(self, symbol: sp.Symbol, expression: sp.Expr) -> None:
        """Let ``symbol`` stand for ``expression`` in later expressions."""
        expression = expression.xreplace(self._fixed)
        if self._is_constant(expression):
            self._fixed[symbol] = expression
        else:
            self._values[symbol] = self._value(expression)

    def value(self, expression: sp.Expr) -> int:
        """Append instructions for ``expression`` if needed; return the number of its value."""
        return self._value(expression.xreplace(self._fixed))

    def _value(self, expression: sp.Expr) -> int:
        if expression not in self._values:
            self._values[expression] = self._compile(expression)
        return self._values[expression]

    def _compile(self, expression: sp.Expr) -> int:
        if self._is_constant(expression):
            return self.with_constant(Operation.CONSTANT, expression)
        if expression.is_Add:
            return self._sum(expression)
        if expression.is_Mul:
            return self._product(expression)
        if expression.is_Pow:
            return self._power(expression.base, expression.exp)
        if expression.func in _FUNCTIONS:
            return self.emit(_FUNCTIONS[expression.func], self._value(expression.args[0]))
        raise ValueError(
            f"functions must be among those with an instruction, got {expression.func.__name__} "
            "(add one to longwave.solutions.compile.assembler)"
        )

    def _sum(self, expression: sp.Expr) -> int:
        constant, terms = self._split(expression)
        total, negative = self._signed(terms[0])
        for term in terms[1:]:
            other, other_negative = self._signed(term)
            if negative == other_negative:
                total = self.emit(Operation.ADD, *sorted((total, other)))
            else:
                first, second = (other, total) if negative else (total, other)
                total, negative = self.emit(Operation.SUBTRACT, first, second), False
        if constant == 0:
            return self._times(total, sp.S.NegativeOne) if negative else total
        operation = Operation.FROM_CONSTANT if negative else Operation.ADD_CONSTANT
        return self.with_constant(operation, constant, total)

    def _signed(self, term: sp.Expr) -> tuple[int, bool]:
        negative = bool(term.as_coeff_Mul()[0].is_negative)
        return self._value(-term if negative else term), negative

    def _product(self, expression: sp.Expr) -> int:
        constant, factors = self._split(expression)
        numbers = sorted(self._value(factor) for factor in factors)
        total = numbers[0]
        for number in numbers[1:]:
            total = self.emit(Operation.MULTIPLY, *sorted((total, number)))
        return total if constant == 1 else self._times(total, constant)

    def _power(self, base: sp.Expr, exponent: sp.Expr) -> int:
        if not (2 * exponent).is_Integer:
            raise ValueError(
                f"exponents must be multiples of 1/2, got {exponent} (write it with exp and log)"
            )
        if exponent < 0:
            return self.emit(Operation.RECIPROCAL, self._value(base**-exponent))
        if not exponent.is_Integer:
            root = self.emit(Operation.SQUARE_ROOT, self._value(base))
            return self._integer_power(root, int(2 * exponent))
        return self._integer_power(self._value(base), int(exponent))

    def _integer_power(self, base: int, exponent: int) -> int:
        if exponent == 1:
            return base
        half = self._integer_power(base, exponent // 2)
        square = self.emit(Operation.MULTIPLY, half)
        if exponent % 2 == 0:
            return square
        return self.emit(Operation.MULTIPLY, *sorted((base, square)))

    def _split(self, expression: sp.Expr) -> tuple[sp.Expr, list[sp.Expr]]:
        """Return the constant arguments of a sum or product, combined, and the other arguments."""
        constant_parts = [part for part in expression.args if self._is_constant(part)]
        varying = [part for part in expression.args if not self._is_constant(part)]
        return expression.func(*constant_parts), varying

    def _is_constant(self, expression: sp.Expr) -> bool:
        return not any(symbol in self._values for symbol in expression.free_symbols)

    def _times(self, value: int, constant: sp.Expr) -> int:
        exact = constant.is_Rational and _is_power_of_two(constant)
        operation = Operation.SCALE if exact else Operation.MULTIPLY_CONSTANT
        return self.with_constant(operation, constant, value)


def _is_power_of_two(number: sp.Rational) -> bool:
    """Return whether multiplication by ``number`` is exact."""
    return min(abs(number.p), number.q) == 1 and max(abs(number.p), number.q).bit_count() == 1
