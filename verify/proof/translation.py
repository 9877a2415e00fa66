"""From a SymPy expression to a rational expression in generators.

`Translation.image` walks the expression; what it meets other than sums, products and integer
powers is looked up in `table.TABLE`.  The images are SymPy expressions that are rational in the
symbols of the generators; `algebra` makes exact fractions of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import sympy as sp

from .generator import Generator, GeneratorList, Unsupported
from .kernels import Kernels
from .linear import LinearForms, split_linear
from .rewriting import Rewriting

NOT_ANALYTIC = (sp.Abs, sp.sign, sp.conjugate, sp.re, sp.im)
"""Functions whose derivatives are made by rules of their own and not by SymPy."""

Handler = Callable[["Translation", sp.Expr], sp.Expr]


class Translation:
    """The generators of some expressions and the images of these in them."""

    def __init__(
        self,
        expressions: Iterable[sp.Expr],
        variables: Sequence[sp.Symbol],
        table: Mapping[type, Handler],
        rewriting: Rewriting,
        forms: LinearForms | None = None,
    ) -> None:
        self.variables = tuple(variables)
        self.generators = GeneratorList()
        self.kernels = Kernels(expressions, self.variables)
        self.rewriting = rewriting
        self.forms = forms
        self._table = table
        self._images: dict[sp.Expr, sp.Expr] = {}

    def image(self, expression: sp.Expr) -> sp.Expr:
        """The image of ``expression``; raises `Unsupported` for what the table lacks."""
        if expression not in self._images:
            self._images[expression] = self._image(expression)
        return self._images[expression]

    def is_constant(self, expression: sp.Expr) -> bool:
        """Whether ``expression`` contains none of the variables."""
        return not self.kernels.dependence.moves(expression)

    def derivatives(self, expression: sp.Expr) -> dict[sp.Symbol, sp.Expr]:
        """The images of the derivatives that are not 0, by variable."""
        if expression.has(*NOT_ANALYTIC):
            return self.derivatives_of_image(self.image(expression))
        slopes = {v: self.rewriting(sp.diff(expression, v)) for v in self.variables}
        return {v: self.image(slope) for v, slope in slopes.items() if slope != 0}

    def derivatives_of_image(self, image: sp.Expr) -> dict[sp.Symbol, sp.Expr]:
        """By the chain rule from the slopes of the generators in ``image``."""
        totals = dict.fromkeys(self.variables, sp.S.Zero)
        for generator in self.generators:
            if image.has(generator.symbol):
                partial = sp.diff(image, generator.symbol)
                for variable, slope in generator.slopes.items():
                    totals[variable] += partial * slope
        return {v: total for v, total in totals.items() if total != 0}

    def primitive(self, name: str, meaning: sp.Expr) -> sp.Symbol:
        """The generator for ``meaning``; if it is new, its slopes are SymPy's derivatives."""
        known = self.generators.known(meaning)
        if known is not None:
            return known
        slopes = self.derivatives(meaning)
        return self.register(self.generators.symbol(name), meaning, slopes)

    def register(
        self,
        symbol: sp.Symbol,
        meaning: sp.Expr,
        slopes: Mapping[sp.Symbol, sp.Expr],
        degree: int = 0,
        value: sp.Expr = sp.S.Zero,
    ) -> sp.Symbol:
        """Register a generator under a symbol of its own and return the symbol."""
        return self.generators.add(Generator(symbol, meaning, dict(slopes), degree, value))

    def _image(self, expression: sp.Expr) -> sp.Expr:
        if expression.is_Rational:
            return expression
        if self.forms is not None and not self.is_constant(expression):
            vector, rest = split_linear(expression, self.kernels.dependence)
            if vector:
                return self.forms.image(self, vector) + sum(map(self.image, rest))
        if expression.is_Add or expression.is_Mul:
            return expression.func(*map(self.image, expression.args))
        if is_integer_power(expression) and not isinstance(expression.base, sp.Abs):
            return self.image(expression.base) ** expression.exp
        handler = self._table.get(expression.func)
        if handler is None:
            raise Unsupported(f"no generator is known for {expression.func.__name__}")
        return handler(self, expression)


def is_integer_power(expression: sp.Expr) -> bool:
    """Whether ``expression`` is a power with an integer exponent."""
    return bool(expression.is_Pow and expression.exp.is_Integer)
