"""The certificate of a proof: its statement as plain data, and hints for `checker`.

An equality is proved part by part where that can be done.  If a sum in one formula has the value of
another sum in the other formula at a point, the two may be the same function.  Where that is
proved, one generator of which nothing is known takes the place of both; if the formulas are equal
with it, they are equal.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import product
from typing import Any

import sympy as sp
from flint import acb, ctx

from verify.subexpressions import distinct_nodes, replaced

from .arguments import Dependence
from .balls import BallEvaluator, Shape
from .certificate_writer import Data, NodeTable, Unsupported
from .checker.check import FORMAT, digest
from .checker.limits import JETS
from .domain_signs import Signs
from .domains import Domains, Point
from .generator_search import GeneratorSearch
from .linear_forms import BITS
from .problem import Problem, coefficients, terms_in
from .simplification import Rewriting
from .square_roots import with_radicals


def equation_certificate(problem: Problem) -> Data:
    """The certificate that the formula of ``problem`` solves its equation.

    Raises Unsupported for a function without an axiom, ValueError without a regular point.
    """
    table = NodeTable()
    known = coefficients(problem.left, problem.unknown)
    statement = {
        "variables": [table.place(variable) for variable in problem.variables],
        "unknowns": [
            [
                _unknown_name(problem.unknown.func.__name__, problem.domains),
                table.place(problem.expression),
            ]
        ],
        "equations": [_terms(problem, table)],
        "domain": domain_data(problem.domains, table),
    }
    expressions = [problem.expression, *known]
    search = GeneratorSearch(table, expressions, problem.variables, _simpler(problem, expressions))
    point = regular_point(expressions, problem.points)
    proof = with_radicals(table, statement, search.proof(point))
    return signed(problem.name, table, statement, proof)


def equality_certificate(
    problem: Problem,
    left: sp.Expr,
    right: sp.Expr,
    variables: Sequence[sp.Symbol],
    parts: Iterable[tuple[sp.Expr, sp.Expr]] = (),
) -> Data:
    """The certificate that two formulas are equal, given ``parts`` of them that are equal."""
    table = NodeTable()
    statement = {
        "variables": [table.place(variable) for variable in variables],
        "unknowns": [[_unknown_name("u", problem.domains), table.place(left)]],
        "equations": [
            [
                ["1", [], [[0, [0] * len(variables)]]],
                ["-1", [table.place(right)], []],
            ]
        ],
        "domain": domain_data(problem.domains, table),
    }
    point, values = regular_point([left, right], problem.points), _simpler(problem, [left, right])
    search = GeneratorSearch(table, [left, right], variables, values, moving=False)
    for own, other in parts:
        proof = GeneratorSearch(table, [own, other], variables, values, moving=False).proof(point)
        proof = with_radicals(table, statement, proof)
        search.equal_part(own, other, proof)
    return signed(
        problem.name, table, statement, with_radicals(table, statement, search.proof(point))
    )


def regular_point(expressions: Sequence[sp.Expr], points: Sequence[Point]) -> Point:
    """A point at which all of ``expressions`` are finite; raises ValueError if there is none."""
    for bits, point in product((BITS, 2 * BITS), points):
        with ctx.workprec(bits):
            balls = BallEvaluator(Shape([(0,)]), (), point)
            try:
                values = [balls.jet(expression).value for expression in expressions]
            except ValueError as error:
                reason = str(error)
                continue
        if all(value.is_finite() for value in values):
            return point
        reason = "no point was found at which every denominator is shown not to vanish"
    raise ValueError(reason)


def _simpler(problem: Problem, expressions: Sequence[sp.Expr]) -> dict[sp.Expr, sp.Expr]:
    """The roots and absolute values in ``expressions`` that the domains simplify."""
    rewriting = Rewriting(Signs(problem.domains))
    for expression in expressions:
        rewriting(expression)
    return rewriting.found


def generator_count(certificate: Data) -> int:
    """How many generators a proof has."""
    entries = certificate["proof"]["generators"]
    return sum(len(entry[2]) if entry[0] == "forms" else 1 for entry in entries)


def point_text(certificate: Data) -> str:
    """The point of a proof in words."""
    nodes = certificate["nodes"]
    found = (f"{nodes[place][1]} = {value}" for place, value in certificate["proof"]["point"])
    return ", ".join(sorted(found))


def signed(name: str, table: NodeTable, statement: Data, proof: Data) -> Data:
    """The certificate with its digest."""
    body: Data = {"format": FORMAT, "name": name, "nodes": table.nodes}
    body |= {"statement": statement, "proof": proof}
    return body | {"digest": digest(body)}


def domain_data(domains: Domains, table: NodeTable) -> list[list[Any]]:
    """The domains as inequalities between nodes."""
    found: list[list[Any]] = []
    for symbol, domain in domains.items():
        if domain.lower != -sp.oo:
            relation = "<" if domain.lower_open else "<="
            found.append([relation, table.place(domain.lower), table.place(symbol)])
        if domain.upper != sp.oo:
            relation = "<" if domain.upper_open else "<="
            found.append([relation, table.place(symbol), table.place(domain.upper)])
    return found


def _terms(problem: Problem, table: NodeTable) -> list[list[Any]]:
    """Each term: a rational number, known factors, and derivatives by their orders."""
    return [_term(term, problem, table) for term in terms_in(problem.left, problem.unknown)]


def _term(term: sp.Expr, problem: Problem, table: NodeTable) -> list[Any]:
    number, known, jets = sp.S.One, [], []
    for factor in sp.Mul.make_args(term):
        if factor.is_Rational:
            number *= factor
        elif not factor.has(problem.unknown):
            known.append(table.place(factor))
        else:
            jets += _jets(factor, problem)
    return [str(number), known, jets]


def _jets(factor: sp.Expr, problem: Problem) -> list[list[Any]]:
    """A power of the unknown or of one of its derivatives, as that many orders."""
    base, power = factor.as_base_exp()
    inner = base.expr if isinstance(base, sp.Derivative) else base
    pairs = base.variable_count if isinstance(base, sp.Derivative) else ()
    counts = {symbol: int(count) for symbol, count in pairs}
    whole = power.is_Integer and 0 < power <= JETS
    if inner != problem.unknown or not whole or counts.keys() - set(problem.variables):
        raise Unsupported(
            f"equations must be polynomials in {problem.unknown} and its derivatives in its own "
            f"variables, got {factor} (multiply it out)"
        )
    return [[0, [counts.get(variable, 0) for variable in problem.variables]]] * int(power)


def _unknown_name(name: str, domains: Domains) -> str:
    """``name``, longer where a symbol is called so."""
    taken = {symbol.name for symbol in domains}
    while name in taken:
        name += "_"
    return name


LEMMA_BITS = 320

Pair = tuple[sp.Expr, sp.Expr]
"""A sum of either formula."""


def find_lemmas(
    left: sp.Expr, right: sp.Expr, variables: Sequence[sp.Symbol], point: Point
) -> list[Pair]:
    """The largest proper sums that differ as formulas and agree at ``point``.

    None lies in another; a sum is passed over for a smaller one that it holds and that stands
    elsewhere too.
    """
    with ctx.workprec(LEMMA_BITS):
        balls = BallEvaluator(Shape([(0,)]), (), point)
        sums = [_values(formula, variables, balls) for formula in (left, right)]
        pairs = [
            (own, other)
            for own, value in sums[0].items()
            for other, image in sums[1].items()
            if own not in sums[1] and other not in sums[0] and (value - image).contains(0)
        ]
    lemmas: list[Pair] = []
    for own, other in sorted(pairs, key=lambda pair: -len(distinct_nodes(pair[0]))):
        symbol = sp.Dummy()
        shorter = (replaced(left, own, symbol), replaced(right, other, symbol))
        if shorter[0] == left or shorter[1] == right:
            continue
        inner = [pair for pair in pairs if pair[0] != own and pair[0] in distinct_nodes(own)]
        if not _occurs(inner, *map(distinct_nodes, shorter)):
            lemmas.append((own, other))
            left, right = shorter
    return lemmas


def _values(
    formula: sp.Expr, variables: Sequence[sp.Symbol], balls: BallEvaluator
) -> dict[sp.Expr, acb]:
    """The values of the proper sums in ``formula`` that contain a variable."""
    dependence = Dependence(variables)
    sums = [node for node in distinct_nodes(formula)[1:] if node.is_Add and dependence.moves(node)]
    values = {node: balls.jet(node).value for node in sums}
    return {node: value for node, value in values.items() if value.is_finite()}


def _occurs(pairs: Sequence[Pair], left: Sequence[sp.Expr], right: Sequence[sp.Expr]) -> bool:
    return any(own in left or other in right for own, other in pairs)
