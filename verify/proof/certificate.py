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
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import product
from typing import Any

import sympy as sp
from flint import acb, ctx, fmpq_mpoly

from longwave.solutions.functions.jet_functions import THETA, JetFunction
from longwave.verify.kernel.check import opened, registered
from longwave.verify.kernel.field import Field
from longwave.verify.kernel.limits import NAME
from longwave.verify.kernel.ring import Element
from longwave.verify.kernel.root_rules import is_branch
from longwave.verify.subexpressions import distinct_nodes, replaced

from .angle_relations import angle_values
from .arguments import Dependence, with_definitions
from .balls import BallEvaluator, JetShape
from .certificate_writer import Certificate, Data, NodeTable, as_data
from .domain_signs import DomainSigns
from .domains import Point
from .generator_search import GeneratorSearch
from .linear_forms import BITS
from .problem import Problem
from .simplification import Rewriting
from .statement_problem import StatementProblem
from .text_writer import Written
from .typed_statement import StatementTexts

LEMMA_BITS = 320

Pair = tuple[sp.Expr, sp.Expr]
"""A sum of either formula."""

Key = tuple[str, int]
"""A prime or -1, or the place of a factor in the ring's list."""


def make_certificate(
    problem: Problem,
    parts: Iterable[Pair] = (),
    unsplit: tuple[type, ...] = (),
    values: Mapping[sp.Expr, sp.Expr] | None = None,
) -> Certificate:
    """Return the certificate for ``problem``, given equal ``parts`` of both sides of an equality.

    Functions in ``unsplit`` are not written as simpler ones; ``values`` has what some others are.
    Raises ValueError for a function without an axiom, and without a regular point.
    """
    table = NodeTable()
    statement = problem.texts or statement_texts(problem)
    rewriting = Rewriting(DomainSigns(problem.domains))
    expressions = with_definitions(problem.expressions)
    for expression in expressions:
        rewriting(expression)
    rewriting.found |= angle_values(expressions, problem.points)
    known = {f: value for f, value in rewriting.found.items() if not isinstance(f, unsplit)}
    known |= values or {}
    point = regular_point(problem)
    order = max((len(d.variables) for d in problem.left.atoms(sp.Derivative)), default=0)

    def search(expressions: Sequence[sp.Expr], *, moving: bool) -> GeneratorSearch:
        variables = problem.variables
        return GeneratorSearch(table, expressions, variables, known, moving=moving, order=order)

    whole = search(expressions, moving=problem.right is None)
    for pair in parts:
        proof = search(with_definitions(pair), moving=False).proof(point, problem.domains)
        whole.equal_part(*pair, with_square_roots(table, statement, proof))
    proof = with_square_roots(table, statement, whole.proof(point, problem.domains))
    return Certificate.signed(problem.name[:NAME], table, statement, proof)


def statement_texts(problem: Problem) -> StatementTexts:
    """Return the texts that a certificate of ``problem`` states."""
    table = NodeTable(list(problem.solutions))
    variables = [symbol.name for symbol in problem.variables]
    taken = {symbol.name for symbol in problem.domains}
    unknowns = []
    for unknown in problem.solutions:
        name = unknown.func.__name__
        while name in taken or any(other.startswith(f"{name}_") for other in taken):
            name += "_"
        unknowns.append(name)
    formulas = [table.place(formula) for formula in problem.solutions.values()]
    left = _left_side(problem, table)
    ends = {end for domain in problem.domains.values() for end in (domain.lower, domain.upper)}
    places = {end: table.place(end) for end in ends if abs(end) != sp.oo}
    written = Written(table.nodes, [*formulas, left, *places.values()], unknowns, variables)
    kinds = {
        symbol.name: "integer" if symbol.is_integer else "real"
        for symbol in {**problem.domains, **dict.fromkeys(problem.variables)}
        if bool(symbol.is_integer) != (symbol.name == "n" and symbol.name in variables)
    }
    limits = {
        symbol.name: domain.chain(symbol.name, lambda end: written.text(places[end]))
        for symbol, domain in problem.domains.items()
        if domain.lower != -sp.oo or domain.upper != sp.oo
    }
    pairs = zip(unknowns, formulas, strict=True)
    named = [f"{name} = {text}" for name, text in written.named.items()]
    own = {name: limit for name, limit in limits.items() if name not in variables}
    stated = [
        f"{name}: {', '.join(part[name] for part in (kinds, own) if name in part)}"
        for name in {**kinds, **own}
    ]
    stated += [f"{name}: function" for name in arbitrary_functions(problem)]
    return StatementTexts(
        tuple(variables),
        (written.text(left),),
        tuple(f"{name} = {written.text(place)}" for name, place in pairs),
        (*named, *stated),
        tuple(limit for name, limit in limits.items() if name in variables),
    )


def arbitrary_functions(problem: Problem) -> list[str]:
    """Return the names of the functions of which nothing is known."""
    parts = (problem.left, *problem.solutions.values())
    labels = {node.label for part in parts for node in part.atoms(JetFunction)}
    return sorted(labels - THETA.keys())


def _left_side(problem: Problem, table: NodeTable) -> int:
    """Return the place of the left-hand side, a polynomial's written term by term."""
    if isinstance(problem, StatementProblem):
        return table.place(problem.left)
    terms = []
    for number, known, jets in problem.terms():
        factors = [table.add("number", str(number))] if number != 1 or not (known or jets) else []
        factors += map(table.place, known)
        for orders, power in Counter(map(tuple, jets)).items():
            jet = table.jet(orders, problem.variables)
            factors.append(jet if power == 1 else table.add("Pow", jet, str(power)))
        terms.append(factors[0] if len(factors) == 1 else table.add("Mul", *factors))
    return terms[0] if len(terms) == 1 else table.add("Add", *terms)


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
    """Return the largest proper sums that differ as formulas and agree at ``point``.

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
    """Return the values of the proper sums in ``formula`` that contain a variable."""
    dependence = Dependence(variables)
    inner = distinct_nodes(formula)[1:]
    sums = [node for node in inner if node.is_Add and dependence.depends(node)]
    values = {node: balls.jet(node).value for node in sums}
    return {node: value for node, value in values.items() if value.is_finite()}


class SquareRoots:
    """The square roots among the generators of a field, and what the dependent ones are."""

    def __init__(self, field: Field, table: NodeTable) -> None:
        self._field, self._table = field, table
        self._places = {node: place for place, node in enumerate(field.nodes.places)}
        self._rows: list[tuple[frozenset[Key], frozenset[int]]] = []
        self._images: dict[int, Element] = {}

    def odd_factors(self, root: int) -> frozenset[Key]:
        """Return the factors of a root's radicand that are no squares in it."""
        image = self._field.image(self._field.nodes.all[root][1])
        return frozenset(key for key, power in self._exponents(image).items() if power % 2)

    def value(self, root: int) -> tuple[int, list[int]] | None:
        """Return the place of what ``root`` is, and the roots in it; None if it is independent."""
        image = self._field.image(self._field.nodes.all[root][1])
        odd, members = self.odd_factors(root), frozenset[int]()
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
        for (kind, value), power in self._exponents(quotient).items():
            if kind == "factor":
                base = self._written(self._field.ring.factors[value])
            else:
                base = self._table.place(sp.Integer(value))
            parts.append(self._table.add("Pow", base, str(power // 2)))
        roots = [self._places[member] for member in members]
        return self._table.add("Mul", *(parts or [self._table.place(sp.S.One)])), roots

    def _exponents(self, element: Element) -> Counter[Key]:
        ring = element.ring
        unit, powers = ring.split(element.numerator)
        found: Counter[Key] = Counter({("factor", i): n for i, n in powers.items()})
        found.subtract({("factor", i): n for i, n in element.powers.items()})
        for number, sign in ((unit.p, 1), (unit.q, -1)):
            for prime, power in sp.factorint(int(number)).items():
                found["number", int(prime)] += sign * power
        return found

    def _written(self, polynomial: fmpq_mpoly) -> int:
        """Return a polynomial in the generators as a node in their meanings."""
        terms = []
        for exponents, coefficient in polynomial.terms():
            powers = [
                self._table.add("Pow", self._meaning(place), str(int(n)))
                for place, n in enumerate(reversed(exponents))
                if n
            ]
            number = self._table.add("number", str(coefficient))
            terms.append(self._table.add("Mul", number, *powers))
        return terms[0] if len(terms) == 1 else self._table.add("Add", *terms)

    def _meaning(self, place: int) -> int:
        generator = self._field.generators[place]
        node = self._formula(generator.formula)
        if generator.scale.is_one():
            return node
        return self._table.add("Mul", node, self._written(generator.scale))

    def _formula(self, node: int) -> int:
        """Return a formula of sums and products of those of the table."""
        if node not in self._places:
            name, *parts = self._field.nodes.all[node]
            if name == "number":
                return self._table.add("number", str(parts[0]))
            return self._table.add(name, *map(self._formula, parts))
        return self._places[node]


def with_square_roots(table: NodeTable, statement: StatementTexts, proof: Data) -> Data:
    """The proof with each square root that depends on earlier ones named, not a generator."""
    atoms = (entry[1] for entry in proof["generators"] if entry[0] == "atom")
    roots = [place for place in atoms if table.nodes[place][::2] == ["Pow", "1/2"]]
    if not roots:
        return proof
    field = _field(table, statement, proof)
    square_roots, members = SquareRoots(field, table), dict[int, list[int]]()
    values = [*proof["values"]]
    for root in sorted(roots, key=lambda r: len(square_roots.odd_factors(field.nodes.places[r]))):
        if field.nodes.places[root] in field.circles.values():
            continue
        found = square_roots.value(field.nodes.places[root])
        if found is not None and _is_root(_field(table, statement, proof), root, found[0]):
            values.append([root, found[0]])
            members[root] = found[1]
    generators: list[list[Any]] = []
    for entry in proof["generators"]:  # what a root is made of comes in its place
        own = members.get(entry[1]) if entry[0] == "atom" else None
        taken = [entry] if own is None else [["atom", root] for root in own]
        generators += [new for new in taken if new not in generators]
    return {**proof, "generators": generators, "values": values}


def _is_root(field: Field, root: int, value: int) -> bool:
    """Return whether a value is seen to be the root: factors may get lost in the ring."""
    _, base, exponent = field.nodes.all[field.nodes.places[root]]
    node = field.nodes.places[value]
    same = (field.image(node) ** 2 - field.image(base)).is_zero
    return bool(same and is_branch(field, node, exponent))


def _field(table: NodeTable, statement: StatementTexts, proof: Data) -> Field:
    """Return the checker's field of a proof."""
    proof = {"formulas": table.texts(), **proof}
    found = opened({"statement": as_data(statement), "proof": proof})
    return registered(found, proof)
