"""Straight-line code with derivatives: one elementary operation a statement.

Every statement's derivatives follow from SymPy's derivative of that one operation and the chain
rule. The directions are d/dxi and the derivative along which the carrier phase (that of the first
Jacobi call) stays fixed, ``d/dtau - drift d/dxi``: most derivatives in it vanish identically.
"""

from collections.abc import Sequence

import sympy as sp

from solutions.compile.lowering import Lowering

__all__ = ["Statement", "Tape", "tape_of"]

Statement = tuple[sp.Symbol, sp.Expr]
Tangent = tuple[sp.Expr, sp.Expr]

_FIXED: Tangent = (sp.S.Zero, sp.S.Zero)


class Tape:
    """Statements ``symbol = operation`` and the two derivatives of every symbol."""

    def __init__(self) -> None:
        self.statements: list[Statement] = []
        self.tangents: dict[sp.Symbol, Tangent] = {}
        self._recorded: dict[sp.Expr, sp.Expr] = {}

    def record(self, expression: sp.Expr) -> sp.Expr:
        """The symbol (or number) that holds ``expression``."""
        if expression.is_Atom:
            return expression
        if expression not in self._recorded:
            self._recorded[expression] = self._record(expression)
        return self._recorded[expression]

    def tangent(self, symbol: sp.Expr) -> Tangent:
        """Both derivatives of a recorded symbol or number."""
        return self.tangents.get(symbol, _FIXED)

    def _record(self, expression: sp.Expr) -> sp.Expr:
        if expression.is_Mul:
            return self._product(list(expression.args))
        if expression.is_Pow and expression.exp.is_Integer and abs(expression.exp) != 1:
            return self._power(expression.base, int(expression.exp))
        arguments = [self._term(argument) for argument in expression.args]
        return self._append(expression.func(*arguments))

    def _term(self, argument: sp.Expr) -> sp.Expr:
        """A term of a sum keeps its numerical factor."""
        number, rest = argument.as_coeff_Mul()
        return number * self.record(rest)

    def _product(self, factors: Sequence[sp.Expr]) -> sp.Expr:
        ordered = sorted(factors, key=lambda factor: (self._is_varying(factor), str(factor)))
        result = self.record(ordered[0])
        for factor in ordered[1:]:
            result = self._append(result * self.record(factor))
        return result

    def _is_varying(self, factor: sp.Expr) -> bool:
        return any(symbol in self.tangents for symbol in factor.free_symbols)

    def _power(self, base: sp.Expr, exponent: int) -> sp.Expr:
        if exponent < 0:
            return self._append(1 / self.record(base**-exponent))
        half = self.record(base ** (exponent // 2))
        square = self._append(half * half)
        return square if exponent % 2 == 0 else self._append(square * self.record(base))

    def _append(self, operation: sp.Expr) -> sp.Expr:
        if operation.is_Atom:
            return operation
        if operation in self._recorded:
            return self._recorded[operation]
        symbol = sp.Symbol(f"x_{len(self.statements)}", real=True)
        self.statements.append((symbol, operation))
        self._recorded[operation] = symbol
        self._differentiate(symbol, operation)
        return symbol

    def _differentiate(self, symbol: sp.Symbol, operation: sp.Expr) -> None:
        varying = sorted((s for s in operation.free_symbols if s in self.tangents), key=str)
        partials = {s: self._partial(symbol, operation, s) for s in varying}
        tangent = []
        for place, name in enumerate(("xi", "along")):
            terms = [partials[s] * self.tangents[s][place] for s in varying]
            tangent.append(self.define(f"{symbol.name}_{name}", sp.Add(*terms)))
        if tangent != [0, 0]:
            self.tangents[symbol] = (tangent[0], tangent[1])

    def _partial(self, symbol: sp.Symbol, operation: sp.Expr, variable: sp.Symbol) -> sp.Expr:
        """``d operation/d variable``; that of tanh as sech**2, for ``1 - tanh**2`` cancels."""
        if operation.func is sp.tanh:
            argument = operation.args[0]
            return self.record(sp.sech(argument)) ** 2 * sp.diff(argument, variable)
        return sp.diff(operation, variable).subs(operation, symbol)

    def define(self, name: str, value: sp.Expr) -> sp.Expr:
        """A statement without derivatives; atoms and negated atoms need none."""
        if value.is_Atom or (-value).is_Atom:
            return value
        symbol = sp.Symbol(name, real=True)
        self.statements.append((symbol, value))
        return symbol


def tape_of(lowering: Lowering, value: sp.Expr) -> tuple[list[Statement], list[sp.Expr]]:
    """Statements for a lowered expression; outputs: value, xi derivative, tau derivative."""
    tape = Tape()
    drift = _seed(tape, lowering)
    replacements, (result,) = sp.cse(value, symbols=sp.numbered_symbols("y_", real=True))
    recorded: dict[sp.Expr, sp.Expr] = {}
    for symbol, right in replacements:
        recorded[symbol] = tape.record(right.xreplace(recorded))
    output = tape.record(result.xreplace(recorded))
    xi_rate, along = tape.tangent(output)
    return tape.statements, [output, xi_rate, along + drift * xi_rate]


def _seed(tape: Tape, lowering: Lowering) -> sp.Expr:
    """Set the derivatives of phases and Jacobi functions; return the carrier's drift q/p."""
    phases = {phase.symbol: phase for phase in lowering.phases.values()}
    calls = list(lowering.calls.values())
    carrying = [phases[call.phase] for call in calls] + [ph for ph in phases.values() if ph.p != 0]
    if not carrying:
        return sp.S.Zero
    carrier = carrying[0]
    for phase in phases.values():
        along = sp.S.Zero
        if (phase.p, phase.q) not in ((carrier.p, carrier.q), (-carrier.p, -carrier.q)):
            along = lowering.constant(phase.q - phase.p * carrier.q / carrier.p)
        tape.tangents[phase.symbol] = (lowering.constant(phase.p), along)
    for call in calls:
        mean = lowering.constant(sp.elliptic_e(call.m) / sp.elliptic_k(call.m))
        fixed = {call.m: lowering.constant(call.m)}
        for symbol, rate in call.derivatives(mean).items():
            slope = tape.define(f"{symbol.name}_u", rate.xreplace(fixed))
            rates = tape.tangents[call.phase]
            tape.tangents[symbol] = (rates[0] * slope, rates[1] * slope)
    return lowering.constant(carrier.q / carrier.p)
