"""The certificate of a proof: its statement as plain data, and hints for `checker`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import product
from typing import Any

import sympy as sp
from flint import ctx

from .balls import BallEvaluator, Point
from .checker.check import FORMAT, digest
from .checker.limits import JETS
from .domain import Domains
from .domain_signs import Signs
from .draft import Data, Unsupported
from .independent import BITS
from .jet import Shape
from .plan import Plan
from .problem import Problem, coefficients, terms_in
from .radicals import with_radicals
from .rewriting import Rewriting
from .tree import NodeTable


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
    plan = Plan(table, expressions, problem.variables, _simpler(problem, expressions))
    point = regular_point(expressions, problem.points)
    proof = with_radicals(table, statement, plan.proof(point))
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
    plan = Plan(table, [left, right], variables, values, moving=False)
    for own, other in parts:
        proof = Plan(table, [own, other], variables, values, moving=False).proof(point)
        proof = with_radicals(table, statement, proof)
        plan.equal_part(own, other, proof)
    return signed(
        problem.name, table, statement, with_radicals(table, statement, plan.proof(point))
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
