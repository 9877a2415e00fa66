"""Straight-line code with derivatives: one elementary operation a line.

The derivative of a line follows from SymPy's derivative of that line alone by the chain rule. A
third derivative is then a few times the size of the expression, where the expanded SymPy tree is
hundreds of times as large. The machine's programs and the residuals are both built from a tape.
"""

from collections.abc import Iterable, Sequence
from itertools import product

import sympy as sp

from longwave.solutions.compile.lowering import Lowering
from longwave.solutions.functions.multiprecision import MpmathFormula
from longwave.solutions.symbols import xi, zeta

_CARRIER_DIRECTION = sp.Dummy("along")
"""Direction in which the carrier phase, that of the first Jacobi call, is constant:
``d/dtau - drift d/dxi``. Most derivatives in it vanish identically."""


class UnknownDerivativeError(ValueError):
    """Error for a function on the tape whose derivative SymPy does not know."""


class Tape:
    """Lines ``symbol = operation`` in order of evaluation; equal operations share one line.

    A value is represented by an entry: a number, or a symbol times a number. Derivatives in
    ``directions`` are recorded after every line, others when they are requested.

    >>> from mpmath import mp
    >>> x = sp.Symbol("x")
    >>> tape = Tape()
    >>> entry = tape.record(sp.sin(x**2) + x**2)
    >>> len(tape.lines)
    3
    >>> slope = tape.derivative(entry, x)
    >>> print(tape.formula([x], [slope])(mp, mp.zero)[0])
    0.0
    """

    def __init__(self, directions: Iterable[sp.Symbol] = ()) -> None:
        self.lines: list[tuple[sp.Symbol, sp.Expr]] = []
        self._directions = tuple(directions)
        self._operation: dict[sp.Expr, sp.Expr] = {}
        self._recorded: dict[sp.Basic, sp.Expr] = {}
        self._derivative: dict[tuple[sp.Expr, sp.Symbol], sp.Expr] = {}
        self._depth = 0

    def seed(self, symbol: sp.Symbol, direction: sp.Symbol, rate: sp.Expr) -> None:
        """Set the derivative of the input ``symbol`` in ``direction`` to ``rate``.

        The lines that compute ``rate`` get no derivatives yet.
        """
        self._depth += 1
        self._derivative[symbol, direction] = self.record(rate)
        self._depth -= 1

    def record(self, expression: sp.Basic) -> sp.Expr:
        """Append the new operations of ``expression``; return the entry of its value.

        Entries from earlier calls may occur in ``expression``.
        """
        if not expression.args or _is_negated_symbol(expression):
            return expression
        if expression not in self._recorded:
            self._recorded[expression] = self._record(expression)
        return self._recorded[expression]

    def _record(self, expression: sp.Basic) -> sp.Expr:
        if expression.is_Mul:
            return self._product(expression.args)
        if expression.is_Pow and expression.exp.is_Integer and abs(expression.exp) != 1:
            return self._power(expression.base, int(expression.exp))
        return self._line(expression.func(*map(self._term, expression.args)))

    def _term(self, argument: sp.Basic) -> sp.Expr:
        """Record a term without its numerical factor; return its entry times the factor."""
        if not isinstance(argument, sp.Expr):
            return self.record(argument)
        number, factor = argument.as_coeff_Mul()
        return number * self.record(factor)

    def _product(self, factors: Sequence[sp.Expr]) -> sp.Expr:
        """Record a product two factors at a time: SymPy is slow to differentiate long products."""
        ordered = sorted(factors, key=self._is_varying)
        result = self.record(ordered[0])
        for factor in ordered[1:]:
            result = self._line(result * self.record(factor))
        return result

    def _is_varying(self, factor: sp.Expr) -> bool:
        pairs = product(factor.free_symbols, self._directions)
        return any(pair in self._derivative for pair in pairs)

    def _power(self, base: sp.Expr, exponent: int) -> sp.Expr:
        if exponent < 0:
            return self._line(1 / self.record(base**-exponent))
        half = self.record(base ** (exponent // 2))
        square = self._line(half * half)
        return square if exponent % 2 == 0 else self._line(square * self.record(base))

    def _line(self, operation: sp.Expr) -> sp.Expr:
        if not operation.args or _is_negated_symbol(operation):
            return operation
        if operation not in self._recorded:
            symbol = sp.Symbol(f"_w{len(self.lines)}", real=True if self._directions else None)
            self.lines.append((symbol, operation))
            self._operation[symbol] = operation
            self._recorded[operation] = symbol
            if not self._depth:
                for direction in self._directions:
                    self.derivative(symbol, direction)
        return self._recorded[operation]

    def derivative(self, entry: sp.Expr, variable: sp.Symbol) -> sp.Expr:
        """Return the entry of the derivative of ``entry`` with respect to the real ``variable``.

        Raises UnknownDerivativeError if SymPy leaves the derivative of a function unevaluated.
        """
        number, symbol = entry.as_coeff_Mul()
        if symbol == variable:
            return number
        key = (symbol, variable)
        if key not in self._derivative:
            if symbol not in self._operation:
                return sp.S.Zero
            self._depth += 1
            self._derivative[key] = self.record(self._chain_rule(symbol, variable))
            self._depth -= 1
        return self.record(number * self._derivative[key])

    def _chain_rule(self, symbol: sp.Symbol, variable: sp.Symbol) -> sp.Expr:
        operation = self._operation[symbol]
        if isinstance(operation, sp.conjugate | sp.re | sp.im):
            return operation.func(self.derivative(operation.args[0], variable))
        products = []
        for inner in sorted(operation.free_symbols, key=str):
            slope = self.derivative(inner, variable)
            if slope != 0:
                products.append(self._partial(symbol, operation, inner) * slope)
        return sp.Add(*products)

    def _partial(self, symbol: sp.Symbol, operation: sp.Expr, inner: sp.Symbol) -> sp.Expr:
        """Return ``d operation/d inner``; for tanh as sech**2, because ``1 - tanh**2`` cancels."""
        if operation.func is sp.tanh:
            argument = operation.args[0]
            return sp.sech(argument) ** 2 * sp.diff(argument, inner)
        partial = sp.diff(operation, inner)
        if partial.has(sp.Derivative, sp.Subs):
            raise UnknownDerivativeError(
                f"{operation.func.__name__} has no known derivative in that argument "
                "(give it an fdiff)"
            )
        return partial.subs(operation, symbol)

    def formula(self, arguments: Sequence[sp.Symbol], entries: Sequence[sp.Expr]) -> MpmathFormula:
        """Return a formula of ``entries`` as functions of ``arguments``, for any mpmath context."""
        return MpmathFormula.of(arguments, entries, self.lines)


def _is_negated_symbol(expression: sp.Basic) -> bool:
    return isinstance(expression, sp.Mul) and bool((-expression).is_Symbol)


def tape_of(
    lowering: Lowering, values: Sequence[sp.Expr], has_across: bool
) -> tuple[Tape, list[sp.Expr]]:
    """Return a tape of lowered expressions, and the entries of values, xi and tau derivatives.

    With ``has_across`` there are zeta derivatives too.
    """
    transverse = [zeta] if has_across else []
    tape = Tape((xi, _CARRIER_DIRECTION, *transverse))
    drift = _seed(tape, lowering)
    replacements, results = sp.cse(values, symbols=sp.numbered_symbols("y_", real=True))
    recorded: dict[sp.Expr, sp.Expr] = {}
    for symbol, right in replacements:
        recorded[symbol] = tape.record(right.xreplace(recorded))
    outputs: list[sp.Expr] = []
    for result in results:
        output = tape.record(result.xreplace(recorded))
        rate, carrier_rate = (tape.derivative(output, d) for d in (xi, _CARRIER_DIRECTION))
        outputs += [output, rate, carrier_rate + drift * rate]
        outputs += [tape.derivative(output, direction) for direction in transverse]
    return tape, outputs


def _seed(tape: Tape, lowering: Lowering) -> sp.Expr:
    """Set the derivatives of phases and Jacobi functions; return the carrier's drift q/p.

    The carrier's p is nonzero for all parameters; without a carrier, the drift is 0.
    """
    phases = {phase.symbol: phase for phase in lowering.phases.values()}
    calls = list(lowering.calls.values())
    candidates = [phases[call.phase] for call in calls] + list(phases.values())
    carrier = next((phase for phase in candidates if phase.p.is_nonzero), None)
    rates = {}
    for phase in phases.values():
        carrier_rate = phase.q
        if carrier is not None:
            carrier_rate -= phase.p * carrier.q / carrier.p
            if (phase.p, phase.q) in ((carrier.p, carrier.q), (-carrier.p, -carrier.q)):
                carrier_rate = sp.S.Zero
        p, of_carrier = lowering.constant(phase.p), lowering.constant(carrier_rate)
        rates[phase.symbol] = {xi: p, _CARRIER_DIRECTION: of_carrier}
        if phase.w != 0:
            rates[phase.symbol][zeta] = lowering.constant(phase.w)
    for call in calls:
        mean = lowering.constant(sp.elliptic_e(call.m) / sp.elliptic_k(call.m))
        to_constant = {call.m: lowering.constant(call.m)}
        for symbol, derivative in call.derivatives(mean).items():
            slope, of_phase = derivative.xreplace(to_constant), rates[call.phase].items()
            rates[symbol] = {direction: rate * slope for direction, rate in of_phase}
    for symbol, in_directions in rates.items():
        for direction, rate in in_directions.items():
            tape.seed(symbol, direction, rate)
    return sp.S.Zero if carrier is None else lowering.constant(carrier.q / carrier.p)
