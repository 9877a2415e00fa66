"""The certificate of a proof: its statement as plain data, and hints for `checker`.

An equality is proved part by part where that can be done.  If a sum in one formula has the value of
another sum in the other formula at a point, the two may be the same function.  Where that is
proved, one generator of which nothing is known takes the place of both; if the formulas are equal
with it, they are equal.

A square root that depends on others is named, as sqrt(6) = sqrt(2) sqrt(3).  The radicands' images
are factored; a root whose square, times those of some others, is a square is their product times a
known element.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from typing import Any

import sympy as sp
from flint import acb, ctx, fmpq_mpoly

from verify.subexpressions import distinct_nodes, replaced

from .arguments import Dependence, with_definitions
from .balls import BallEvaluator, JetShape
from .certificate_writer import Certificate, Data, NodeTable
from .checker.check import registered
from .checker.field import Field
from .checker.limits import NAME, CertificateError
from .checker.nodes import Nodes
from .checker.ring import Element
from .checker.statement import read_statement
from .domain_signs import DomainSigns
from .domains import Domains, Point
from .generator_search import GeneratorSearch
from .linear_forms import BITS
from .problem import Problem
from .simplification import Rewriting
from .statement_problem import StatementProblem

LEMMA_BITS = 320

Pair = tuple[sp.Expr, sp.Expr]
"""A sum of either formula."""

Key = tuple[str, int]
"""A prime or -1, or the place of a factor in the ring's list."""


def make_certificate(problem: Problem, parts: Iterable[Pair] = ()) -> Certificate:
    """The certificate for ``problem``, given equal ``parts`` of both sides of an equality.

    Raises ValueError for a function without an axiom, and without a regular point.
    """
    table = NodeTable(list(problem.solutions))
    statement = statement_data(problem, table)
    rewriting = Rewriting(DomainSigns(problem.domains))
    expressions = with_definitions(problem.expressions)
    for expression in expressions:
        rewriting(expression)
    point = regular_point(problem)

    def search(expressions: Sequence[sp.Expr], *, moving: bool) -> GeneratorSearch:
        found = rewriting.found
        return GeneratorSearch(table, expressions, problem.variables, found, moving=moving)

    whole = search(expressions, moving=problem.right is None)
    for pair in parts:
        proof = search(with_definitions(pair), moving=False).proof(point)
        whole.equal_part(*pair, with_square_roots(table, statement, proof))
    proof = with_square_roots(table, statement, whole.proof(point))
    return Certificate.signed(problem.name[:NAME], table, statement, proof)


def statement_data(problem: Problem, table: NodeTable) -> Data:
    """What a certificate states, as places in ``table``."""
    taken = {symbol.name for symbol in problem.domains}
    variables = [table.place(variable) for variable in problem.variables]
    unknowns = []
    for unknown, formula in problem.solutions.items():
        name = unknown.func.__name__
        while name in taken:
            name += "_"
        unknowns.append([name, table.place(formula)])
    return {
        "variables": variables,
        "unknowns": unknowns,
        "equations": [_equation_data(problem, table)],
        "domain": _domain_data(problem.domains, table),
    }


def _equation_data(problem: Problem, table: NodeTable) -> int | list[Any]:
    """A polynomial's terms, or the place of the left-hand side of any other equation."""
    if isinstance(problem, StatementProblem):
        return table.place(problem.left)
    return [
        [str(number), [table.place(factor) for factor in known], [[0, jet] for jet in jets]]
        for number, known, jets in problem.terms()
    ]


def regular_point(problem: Problem) -> Point:
    """A point at which all of a problem's formulas are finite; raises ValueError without one."""
    for bits, point in product((BITS, 2 * BITS), problem.points):
        with ctx.workprec(bits):
            balls = BallEvaluator(JetShape([(0,)]), (), point)
            try:
                values = [balls.jet(expression).value for expression in problem.expressions]
            except ValueError as error:
                reason = str(error)
                continue
        if all(value.is_finite() for value in values):
            return point
        reason = "no point was found at which every denominator is shown not to vanish"
    raise ValueError(reason)


def _domain_data(domains: Domains, table: NodeTable) -> list[list[Any]]:
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


def equal_parts(problem: Problem) -> Iterator[list[Pair]]:
    """Equal parts to prove first, if there may be any, and none."""
    if problem.right is not None:
        sides = problem.formula, problem.right
        lemmas = find_lemmas(*sides, problem.variables, regular_point(problem))
        if lemmas:
            yield lemmas
    yield []


def find_lemmas(
    left: sp.Expr, right: sp.Expr, variables: Sequence[sp.Symbol], point: Point
) -> list[Pair]:
    """The largest proper sums that differ as formulas and agree at ``point``.

    None lies in another; a sum is passed over for a smaller one that it holds and that stands
    elsewhere too.
    """
    with ctx.workprec(LEMMA_BITS):
        balls = BallEvaluator(JetShape([(0,)]), (), point)
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
        nodes = [set(distinct_nodes(formula)) for formula in shorter]
        if not any(a in nodes[0] or b in nodes[1] for a, b in inner):
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


class SquareRoots:
    """The square roots among the generators of a field, and what the dependent ones are."""

    def __init__(self, field: Field, table: NodeTable) -> None:
        self._field, self._table = field, table
        self._places = {node: place for place, node in enumerate(field.nodes.places)}
        self._rows: list[tuple[frozenset[Key], frozenset[int]]] = []
        self._images: dict[int, Element] = {}

    def value(self, root: int) -> int | None:
        """The place of what ``root``, a node of the field, is; None if it is independent."""
        base = self._field.nodes.all[root][1]
        image = self._field.image(base)
        odd = frozenset(key for key, power in self._exponents(image).items() if power % 2)
        members = frozenset[int]()
        for row, row_members in self._rows:
            if max(row) in odd:
                odd, members = odd ^ row, members ^ row_members
        if odd:
            self._rows.append((odd, members | {root}))
            self._images[root] = image
            return None
        quotient = image
        for member in members:
            quotient = quotient / self._images[member]
        parts = [self._places[member] for member in members]
        for key, power in self._exponents(quotient).items():
            parts.append(self._made_power(key, power // 2))
        return self._table.made("Mul", *(parts or [self._table.place(sp.S.One)]))

    def _exponents(self, element: Element) -> Counter[Key]:
        ring = element.ring
        unit, powers = ring.split(element.numerator)
        found: Counter[Key] = Counter({("factor", i): n for i, n in powers.items()})
        found.subtract({("factor", i): n for i, n in element.powers.items()})
        for number, sign in ((unit.p, 1), (unit.q, -1)):
            for prime, power in sp.factorint(int(number)).items():
                found["number", int(prime)] += sign * power
        return found

    def _made_power(self, key: Key, power: int) -> int:
        kind, value = key
        if kind == "factor":
            base = self._written(self._field.ring.factors[value])
        else:
            base = self._table.place(sp.Integer(value))
        return self._table.made("Pow", base, str(power))

    def _written(self, polynomial: fmpq_mpoly) -> int:
        """A polynomial in the generators as a node in their meanings."""
        terms = []
        for exponents, coefficient in polynomial.terms():
            powers = [
                self._table.made("Pow", self._meaning(place), str(int(n)))
                for place, n in enumerate(reversed(exponents))
                if n
            ]
            number = self._table.made("number", str(coefficient))
            terms.append(self._table.made("Mul", number, *powers))
        return terms[0] if len(terms) == 1 else self._table.made("Add", *terms)

    def _meaning(self, place: int) -> int:
        generator = self._field.generators[place]
        if generator.form:
            raise CertificateError("a linear form under a root is not written out")
        node = self._places[generator.node]
        if generator.scale is not None:
            return self._table.made("Mul", node, self._written(generator.scale))
        if generator.below is not None:
            below = self._table.made("Pow", self._places[generator.below], "-1")
            return self._table.made("Mul", node, below)
        return node


def with_square_roots(table: NodeTable, statement: Data, proof: Data) -> Data:
    """The proof with each square root that depends on earlier ones named, not a generator."""
    atoms = (entry[1] for entry in proof["generators"] if entry[0] == "atom")
    roots = [place for place in atoms if table.nodes[place][::2] == ["Pow", "1/2"]]
    if not roots:
        return proof
    field = _field(table, statement, proof)
    square_roots, dependent = SquareRoots(field, table), dict[int, int]()
    for root in roots:
        value = square_roots.value(field.nodes.places[root])
        if value is not None:
            known = _field(table, statement, proof)
            if known.signs.not_negative(known.nodes.places[value]):
                dependent[root] = value
    kept = [e for e in proof["generators"] if e[0] != "atom" or e[1] not in dependent]
    values = [*proof["values"], *([root, value] for root, value in dependent.items())]
    return {**proof, "generators": kept, "values": values}


def _field(table: NodeTable, statement: Data, proof: Data) -> Field:
    """What the checker makes of a proof."""
    nodes = Nodes(table.nodes)
    return registered(nodes, read_statement(nodes, statement), proof)
