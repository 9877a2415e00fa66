"""Linear combinations of primitives: generators that occur only in a few combinations.

A primitive here is a variable or Jacobi's epsilon: its derivative is free of itself.  Where xi,
tau and epsilon occur only as ``epsilon(xi) + a xi + b tau``, this sum is one generator in place
of three, and polynomials in it are far shorter.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import sympy as sp
from flint import acb, ctx

from solutions.special import jacobi_epsilon

from .balls import Point, ball_value
from .dependence import Dependence
from .generator import Unsupported

if TYPE_CHECKING:
    from .translation import Translation

Form = dict[sp.Expr, sp.Expr]
"""The constant coefficients of primitives."""

BITS = 160


class MissingForm(Unsupported):
    """A linear form with a primitive that the basis was not made for: ``form``."""

    def __init__(self, form: Form) -> None:
        super().__init__(f"no basis was made for the linear form {form}")
        self.form = form


def split_linear(expression: sp.Expr, dependence: Dependence) -> tuple[Form, list[sp.Expr]]:
    """The part of a sum that is linear in primitives with constant coefficients, and the rest.

    >>> x, t, a = sp.symbols("x t a")
    >>> split_linear(a * (x - 2 * t) + x**2 + 3, Dependence([x, t]))
    ({x: a, t: -2*a}, [3, x**2])
    """
    form: Form = {}
    rest: list[sp.Expr] = []
    waiting = [(sp.S.One, expression)]
    while waiting:
        factor, term = waiting.pop(0)
        if term.is_Add:
            waiting += [(factor, part) for part in term.args]
            continue
        constant, moving = dependence.factors(term)
        if moving.is_Add:
            waiting.append((factor * constant, moving))
        elif moving in dependence.variables or isinstance(moving, jacobi_epsilon):
            form[moving] = form.get(moving, sp.S.Zero) + factor * constant
        else:
            rest.append(factor * term)
    return form, rest


def linear_forms(expressions: Iterable[sp.Expr], dependence: Dependence) -> list[Form]:
    """The linear parts of the sums in ``expressions`` (not in arguments), the shortest first."""
    found: list[Form] = []
    seen: set[sp.Expr] = set()
    waiting = list(expressions)
    while waiting:
        node = waiting.pop(0)
        if node in seen or not dependence.moves(node):
            continue
        seen.add(node)
        form, rest = split_linear(node, dependence)
        if form:
            found.append(form)
            waiting += rest
        elif node.is_Add or node.is_Mul or node.is_Pow:
            waiting += node.args
    return sorted(found, key=lambda form: sp.Add(*form.values()).count_ops())


class LinearForms:
    """A basis of linear forms, chosen with balls at a point and used with exact coefficients.

    ``obligations`` lists what must vanish for the images to be right; `algebra` sees to it.
    """

    def __init__(self, forms: Sequence[Form], point: Point) -> None:
        self.primitives = list(dict.fromkeys(p for form in forms for p in form))
        self.basis: list[Form] = []
        self.obligations: list[sp.Expr] = []
        rows: list[list[acb]] = []
        with ctx.workprec(BITS):
            for form in forms:
                row = [ball_value(form.get(p, sp.S.Zero), point, BITS) for p in self.primitives]
                if len(_pivots([*rows, row])) > len(rows):
                    rows.append(row)
                    self.basis.append(form)
            self._pivots = [self.primitives[place] for place in _pivots(rows)]

    def image(self, translation: Translation, form: Form) -> sp.Expr:
        """``form`` as a combination of the generators that stand for the basis.

        Raises `MissingForm` for a primitive that no form of the basis was gathered with.
        """
        if not form.keys() <= set(self.primitives):
            raise MissingForm(form)
        parts = []
        for coefficient, basis_form in zip(self._coordinates(form), self.basis, strict=True):
            if coefficient != 0:
                meaning = sp.Add(*(value * p for p, value in basis_form.items()))
                symbol = translation.primitive("w", meaning)
                parts.append(translation.image(coefficient) * symbol)
        return sp.Add(*parts)

    def _coordinates(self, form: Form) -> list[sp.Expr]:
        if form in self.basis:
            return [sp.Integer(form == other) for other in self.basis]
        matrix = sp.Matrix([[b.get(p, sp.S.Zero) for p in self._pivots] for b in self.basis])
        row = sp.Matrix([[form.get(p, sp.S.Zero) for p in self._pivots]])
        found = list(row * matrix.adjugate() / matrix.det(method="berkowitz"))
        for primitive in self.primitives:
            if primitive not in self._pivots:
                sides = zip(found, self.basis, strict=True)
                total = sp.Add(*(c * b.get(primitive, sp.S.Zero) for c, b in sides))
                self.obligations.append(form.get(primitive, sp.S.Zero) - total)
        return found


def _pivots(rows: Sequence[Sequence[acb]]) -> list[int]:
    """The pivot columns of a matrix; an entry whose ball contains 0 counts as 0."""
    table = [list(row) for row in rows]
    pivots: list[int] = []
    for column in range(len(table[0]) if table else 0):
        place = len(pivots)
        left = [i for i in range(place, len(table)) if not table[i][column].contains(0)]
        if not left:
            continue
        table[place], table[left[0]] = table[left[0]], table[place]
        for i in range(place + 1, len(table)):
            ratio = table[i][column] / table[place][column]
            table[i] = [a - ratio * b for a, b in zip(table[i], table[place], strict=True)]
        pivots.append(column)
    return pivots
