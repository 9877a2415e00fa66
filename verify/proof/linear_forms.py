"""Linear forms of primitives: generators that occur only in a few combinations.

A primitive is a variable or Jacobi's epsilon: its derivative does not contain it.  If xi, tau and
epsilon occur only as ``epsilon(xi) + a xi + b tau``, this sum becomes one generator instead of
three, and polynomials in it are far shorter.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import sympy as sp
from flint import acb, ctx

from longwave.solutions.functions import jacobi_epsilon, jacobi_sn, jacobi_zeta
from longwave.verify.kernel.limits import FORMS
from longwave.verify.subexpressions import distinct_nodes, replaced

from .arguments import Arguments, Dependence
from .balls import ball_value
from .domains import Point

Form = dict[sp.Expr, sp.Expr]
"""Linear form: the constant coefficient of each primitive."""


def split_linear(expression: sp.Expr, dependence: Dependence) -> tuple[Form, list[sp.Expr]]:
    """Split a sum into its linear form in primitives, with constant coefficients, and the rest.

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
    """Return the linear parts of sums in ``expressions`` (not in arguments), shortest first."""
    forms: list[Form] = []
    visited: set[sp.Expr] = set()
    waiting = list(expressions)
    while waiting:
        node = waiting.pop(0)
        if node in visited or not dependence.depends(node):
            continue
        visited.add(node)
        form, rest = split_linear(node, dependence)
        if form:
            forms.append(form)
            waiting += rest
        elif node.is_Add or node.is_Mul or node.is_Pow:
            waiting += node.args
    return sorted(forms, key=lambda form: sp.Add(*form.values()).count_ops())


def with_one_integral(expressions: Sequence[sp.Expr], dependence: Dependence) -> list[sp.Expr]:
    """Remove shifts in epsilon's arguments; if epsilon occurs, zeta(z) = epsilon(z) - z E/K."""
    nodes = {expression: distinct_nodes(expression) for expression in expressions}
    if not any(isinstance(node, jacobi_epsilon) for inner in nodes.values() for node in inner):
        return list(expressions)

    def epsilon(z: sp.Expr, m: sp.Expr) -> sp.Expr:
        shift, variable = dependence.summands(sp.expand(z))
        total = jacobi_epsilon(variable, m) + jacobi_epsilon(shift, m)
        return total - m * sp.Mul(*(jacobi_sn(u, m) for u in (variable, shift, z)))

    def zeta(z: sp.Expr, m: sp.Expr) -> sp.Expr:
        return epsilon(z, m) - z * sp.elliptic_e(m) / sp.elliptic_k(m)

    def rewritten(expression: sp.Expr) -> sp.Expr:
        result = expression
        for kind, image in ((jacobi_epsilon, epsilon), (jacobi_zeta, zeta)):
            for node in nodes[expression]:
                if isinstance(node, kind):
                    result = replaced(result, node, image(*node.args))
        return result

    return [*map(rewritten, expressions)]


def pivot_columns(rows: Sequence[Sequence[acb]]) -> list[int]:
    """Return the pivot columns of a matrix; an entry whose ball contains 0 counts as 0."""
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


BITS = 160


def with_dummies(expressions: Iterable[sp.Expr], hidden: set[sp.Expr]) -> list[sp.Expr]:
    """Replace each of the ``hidden`` subexpressions by a dummy symbol."""
    names = {node: sp.Dummy() for node in hidden}
    return [expression.xreplace(names) for expression in expressions]


def independent_forms(
    expressions: Sequence[sp.Expr], arguments: Arguments, hidden: set[sp.Expr], point: Point
) -> tuple[list[sp.Basic], list[sp.Expr], list[list[sp.Expr]]]:
    """Return pivot primitives, other primitives, and the coefficient rows of independent forms.

    A row has the coefficients of the pivots, then those of the others.  The primitives are
    variables and, for epsilon(u), the pair (u, m).  Independence is judged by
    balls at ``point``; any choice gives valid generators.
    """
    written = with_one_integral(with_dummies(expressions, hidden), arguments.dependence)
    forms = [_by_argument(f, arguments) for f in linear_forms(written, arguments.dependence)]
    primitives = sorted({p for form in forms for p in form}, key=str)
    primitives.sort(key=lambda p: not isinstance(p, sp.Tuple))
    rows: list[list[sp.Expr]] = []
    balls: list[list[acb]] = []
    with ctx.workprec(BITS):
        for form in forms:
            row = [form.get(p, sp.S.Zero) for p in primitives]
            values = [ball_value(value, point, BITS) for value in row]
            if len(pivot_columns([*balls, values])) > len(rows):
                rows.append(row)
                balls.append(values)
        pivots = pivot_columns(balls)
    if len(rows) == len(primitives) or len(rows) > FORMS:
        return [], [], []
    own = [primitives[i] for i in pivots]
    others = [p for p in primitives if p not in own]
    if any(isinstance(p, sp.Tuple) for p in others):
        return [], [], []
    order = [*pivots, *(primitives.index(p) for p in others)]
    return own, others, [[row[i] for i in order] for row in rows]


def _by_argument(form: Form, arguments: Arguments) -> dict[sp.Basic, sp.Expr]:
    """Return a linear form with the pair (u, m) or (-u, m) as key in place of epsilon(u)."""
    factors: dict[sp.Basic, sp.Expr] = {}
    for primitive, value in form.items():
        key: sp.Basic = primitive
        if isinstance(primitive, jacobi_epsilon):
            u, m = arguments.parts(primitive.args[0])[0], primitive.args[1]
            side = -1 if u.could_extract_minus_sign() else 1
            key, value = sp.Tuple(side * u, m), side * value
        factors[key] = factors.get(key, sp.S.Zero) + value
    return factors
