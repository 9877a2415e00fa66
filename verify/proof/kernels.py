"""What an expression contains, found before any generator is made."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from math import lcm

import sympy as sp

from solutions.functions.jacobi import JacobiFunction

from .dependence import Dependence
from .lattice import ArgumentLattice, without_logarithms

HYPERBOLIC = (sp.sinh, sp.cosh, sp.tanh, sp.coth, sp.sech, sp.csch)
TRIGONOMETRIC = (sp.sin, sp.cos, sp.tan, sp.cot, sp.sec, sp.csc)


class Kernels:
    """The arguments of the exponentials and of the elliptic functions, as lattices.

    ``exponents`` is the lattice of what stands in exponentials.  For an elliptic parameter m,
    ``moving(m)`` and ``fixed(m)`` are the lattices of the variable and of the constant parts of
    the arguments.  ``count`` says how often each function occurs; ``circles`` are the symbols s
    for which sqrt(1 - s**2) occurs and no other root of a sum with s.  ``degrees`` has, for the
    base of roots, the common multiple of their degrees.
    """

    def __init__(self, expressions: Iterable[sp.Expr], variables: Sequence[sp.Symbol]) -> None:
        self.dependence = Dependence(variables)
        self.count: Counter[tuple[type, sp.Expr]] = Counter()
        self.circles: set[sp.Symbol] = set()
        self.degrees: dict[sp.Expr, int] = {}
        self._exponents: dict[sp.Expr, None] = {}
        self._moving: defaultdict[sp.Expr, dict[sp.Expr, None]] = defaultdict(dict)
        self._fixed: defaultdict[sp.Expr, dict[sp.Expr, None]] = defaultdict(dict)
        seen: set[sp.Basic] = set()
        for expression in expressions:
            self._visit(expression, seen)
        self._close_circles()
        self.exponents = ArgumentLattice(self._exponents)
        self._lattices: dict[tuple[str, sp.Expr], ArgumentLattice] = {}

    def moving(self, m: sp.Expr) -> ArgumentLattice:
        """The lattice of the variable parts of the elliptic arguments with parameter ``m``."""
        return self._lattice("moving", m, self._moving)

    def fixed(self, m: sp.Expr) -> ArgumentLattice:
        """The lattice of the constant parts."""
        return self._lattice("fixed", m, self._fixed)

    def parts(self, argument: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
        """``argument`` as a sum of a variable and a constant part."""
        constant, variable = self.dependence.summands(sp.expand(argument))
        return variable, constant

    def _lattice(
        self, kind: str, m: sp.Expr, found: defaultdict[sp.Expr, dict[sp.Expr, None]]
    ) -> ArgumentLattice:
        if (kind, m) not in self._lattices:
            self._lattices[kind, m] = ArgumentLattice(found[m])
        return self._lattices[kind, m]

    def _visit(self, node: sp.Basic, seen: set[sp.Basic]) -> None:
        for inner in node.args:
            self._visit(inner, seen)
        if isinstance(node, JacobiFunction):
            self.count[type(node), node.args[1]] += 1
        if node in seen:
            return
        seen.add(node)
        if isinstance(node, (sp.exp, *HYPERBOLIC)):
            self._exponents[without_logarithms(node.args[0])[0]] = None
        elif isinstance(node, TRIGONOMETRIC):
            self._exponents[sp.I * node.args[0]] = None
        elif isinstance(node, JacobiFunction):
            self._elliptic(*node.args)
        elif isinstance(node, sp.Pow) and node.exp.is_Rational and not node.exp.is_Integer:
            self._root(node.base, int(node.exp.q))
        elif node is sp.E:
            self._exponents[sp.S.One] = None

    def _elliptic(self, argument: sp.Expr, m: sp.Expr) -> None:
        variable, constant = self.parts(argument)
        if variable != 0:
            self._moving[m][variable] = None
        if constant != 0:
            self._fixed[m][constant] = None

    def _root(self, base: sp.Expr, degree: int) -> None:
        self.degrees[base] = lcm(degree, self.degrees.get(base, 1))
        rest = 1 - base
        is_square = rest.is_Pow and rest.exp == 2 and rest.base.is_Symbol
        if is_square and rest.base not in self.dependence.variables:
            self.circles.add(rest.base)

    def _close_circles(self) -> None:
        """Without another root of a sum with s: its relation with sqrt(1 - s**2) would be lost."""
        for symbol in list(self.circles):
            sums = [base for base in self.degrees if not base.is_Symbol and base.has(symbol)]
            if sums != [1 - symbol**2]:
                self.circles.remove(symbol)
