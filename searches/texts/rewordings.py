"""A formula in other words, and with one change that may make it false."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction

from searches.texts.trees import (
    MINUS,
    ONE,
    Tree,
    as_tree,
    call,
    changed_at,
    name,
    total,
)

Change = Callable[[Tree, random.Random], Tree]

HALF = Fraction(1, 2)


def _of(image: Callable[[Tree], Tree]) -> Change:
    return lambda node, _: image(node.args[0])


def _half_angle(node: Tree, _: random.Random) -> Tree:
    half = as_tree(HALF) * node.args[0]
    if node.head == "sin":
        return as_tree(2) * call("sin", half) * call("cos", half)
    return ONE - as_tree(2) * call("sin", half) ** 2


def _split_exponential(node: Tree, draw: random.Random) -> Tree:
    z = node.args[0]
    if z.head == "+":
        return call("exp", z.args[0]) * call("exp", total(*z.args[1:]))
    return draw.choice((call("exp", as_tree(HALF) * z) ** 2, ONE / call("exp", -z)))


def _difference_of_squares(node: Tree, draw: random.Random) -> Tree:
    shift = as_tree(Fraction(draw.choice((7, 11)), 17))
    return (node**2 - shift**2) / (node + shift) + shift


def _over_a_sum(node: Tree, _: random.Random) -> Tree:
    letter = next((x for x in "xtyzn" if x in node.names()), "")
    if not letter:
        return node
    factor = name(letter) ** 2 + 1
    return total(*(term * factor for term in node.args)) / factor


def _power(node: Tree, draw: random.Random) -> Tree:
    base, exponent = node.args
    if exponent == as_tree(2) and base.head == "+" and len(base.args) == 2:
        a, b = base.args
        return a**2 + as_tree(2) * a * b + b**2
    squares = {"sech": "tanh", "cos": "sin", "sin": "cos", "tanh": "sech"}
    if exponent == as_tree(2) and base.head in squares:
        return ONE - call(squares[base.head], base.args[0]) ** 2
    return node


def _swapped(node: Tree, _: random.Random) -> Tree:
    return Tree(node.head, tuple(reversed(node.args)))


REWORDINGS: Mapping[str, tuple[Change, ...]] = {
    "sin": (
        _half_angle,
        _of(lambda z: (call("exp", name("I") * z) - call("exp", -name("I") * z)) / name("I") / 2),
    ),
    "cos": (
        _half_angle,
        _of(lambda z: (call("exp", name("I") * z) + call("exp", -name("I") * z)) / 2),
    ),
    "tan": (_of(lambda z: call("sin", z) / call("cos", z)),),
    "exp": (_split_exponential, _of(lambda z: call("cosh", z) + call("sinh", z))),
    "tanh": (
        _of(lambda z: call("sinh", z) / call("cosh", z)),
        _of(lambda z: ONE - as_tree(2) / (call("exp", as_tree(2) * z) + 1)),
    ),
    "sech": (
        _of(lambda z: ONE / call("cosh", z)),
        _of(lambda z: as_tree(2) * call("exp", z) / (call("exp", as_tree(2) * z) + 1)),
    ),
    "cosh": (_of(lambda z: (call("exp", z) + call("exp", -z)) / 2),),
    "sinh": (_of(lambda z: (call("exp", z) - call("exp", -z)) / 2),),
    "sqrt": (_of(lambda z: z ** as_tree(HALF)),),
    "**": (_power,),
    "+": (_difference_of_squares, _over_a_sum, _swapped),
    "*": (_swapped,),
}
"""Each holds wherever both sides are smooth, of complex arguments too."""


def reworded(tree: Tree, draw: random.Random, changes: int) -> Tree:
    """The formula after some random identities."""
    for _ in range(changes):
        places = [
            place
            for place, node in enumerate(tree.nodes())
            if node.head in REWORDINGS and not any(n.head == "jet" for n in node.nodes())
        ]
        if places:
            tree = changed_at(
                tree,
                draw.choice(places),
                lambda node: draw.choice(REWORDINGS[node.head])(node, draw),
            )
    return tree


# one change


OTHER_FUNCTION = {
    "sin": "cos", "cos": "sin", "tanh": "coth", "sech": "tanh", "sinh": "cosh", "cosh": "sinh",
    "exp": "cosh", "re": "im", "im": "re", "atan": "asinh", "asin": "acos", "acos": "asin",
    "jacobi_sn": "jacobi_cn", "jacobi_cn": "jacobi_dn", "jacobi_dn": "jacobi_cn",
    "log": "asinh", "asinh": "atan", "sec": "csc", "coth": "tanh", "csch": "sech",
}  # fmt: skip
DROPPED = ("conjugate", "abs", "sign", "sqrt", "re")


def _other_number(node: Tree, draw: random.Random) -> Tree:
    value = node.number
    tiny = Fraction(1, 10 ** draw.choice((3, 12, 40)))
    choices = (value + 1, value - 1, -value, value * (1 + tiny), value + tiny, value * 2)
    return as_tree(draw.choice(choices))


def _other_name(node: Tree, draw: random.Random) -> Tree:
    factor = draw.choice((Fraction(2), Fraction(-1), Fraction(1001, 1000), 1 + Fraction(1, 10**30)))
    return as_tree(factor) * node


def _other_sum(node: Tree, draw: random.Random) -> Tree:
    place = draw.randrange(len(node.args))
    kept = [arg for index, arg in enumerate(node.args) if index != place]
    tiny = Fraction(1, 10 ** draw.choice((2, 20, 60)))
    return draw.choice(
        (
            total(*kept, -node.args[place]),
            total(*kept),
            total(*node.args, as_tree(tiny) * node.args[place]),
        )
    )


def _other_jet(node: Tree, draw: random.Random) -> Tree:
    unknown, steps, shift = node.jet
    if shift is not None and draw.random() < 0.5:
        return Tree("jet", value=(unknown, steps, draw.choice((shift + 1, -shift, shift - 1))))
    if steps and draw.random() < 0.4:
        return Tree("jet", value=(unknown, steps[1:], shift))
    return draw.choice((-node, as_tree(Fraction(11, 10)) * node, call("conjugate", node)))


def _other_call(node: Tree, draw: random.Random) -> Tree:
    if node.head in DROPPED and draw.random() < 0.6:
        return node.args[0]
    if node.head in OTHER_FUNCTION and draw.random() < 0.5:
        return Tree(OTHER_FUNCTION[node.head], node.args)
    first = draw.choice((-node.args[0], as_tree(Fraction(3, 2)) * node.args[0]))
    return Tree(node.head, (first, *node.args[1:]))


def changed_once(node: Tree, draw: random.Random) -> Tree:
    """The node with something else in its place."""
    if node.head == "number":
        return _other_number(node, draw)
    if node.head == "name":
        return _other_name(node, draw)
    if node.head == "+":
        return _other_sum(node, draw)
    if node.head == "jet":
        return _other_jet(node, draw)
    if node.head in ("*", "**", "diff"):
        return MINUS * node
    return _other_call(node, draw)


def mutated(
    draw: random.Random, equations: Sequence[Tree], solutions: Mapping[str, Tree]
) -> tuple[Sequence[Tree], Mapping[str, Tree]]:
    """Equations and solutions with one node of one of them changed."""
    if draw.random() < 0.6:
        unknown = draw.choice(sorted(solutions))
        return equations, {**solutions, unknown: _with_change(solutions[unknown], draw)}
    place = draw.randrange(len(equations))
    changed = [_with_change(e, draw) if i == place else e for i, e in enumerate(equations)]
    return changed, solutions


def _with_change(tree: Tree, draw: random.Random) -> Tree:
    """A change anywhere but in an exponent, which might grow beyond reason."""
    exponents = {id(node.args[1]) for node in tree.nodes() if node.head == "**"}
    places = [i for i, node in enumerate(tree.nodes()) if id(node) not in exponents]
    return changed_at(tree, draw.choice(places), lambda node: changed_once(node, draw))
