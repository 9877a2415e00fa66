"""Build the certificate of a proof: its statement as plain data, and hints for the checker.

An equality is proved part by part if possible.  If a sum in one formula and a sum in the other have
the same value at a point, they may be the same function.  Once that is proved, one free generator
replaces both; if the formulas with it are equal, the original ones are.

A square root that depends on others gets a value instead of a generator: sqrt(6) = sqrt(2) sqrt(3).
The radicands' images are factored.  If the product of a radicand and some others is a square, the
root is the product of the other roots and a known element.
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
from .text_writer import Written, numbered
from .typed_statement import StatementTexts

LEMMA_BITS = 320

Pair = tuple[sp.Expr, sp.Expr]
"""A sum within the left formula and one within the right formula that may be equal."""

FactorKey = tuple[str, int]
"""("number", prime or -1), or ("factor", index in the ring's list)."""


def make_certificate(
    problem: Problem,
    parts: Iterable[Pair] = (),
    unsplit: tuple[type, ...] = (),
    values: Mapping[sp.Expr, sp.Expr] | None = None,
) -> Certificate:
    """Return the certificate for ``problem``, given equal ``parts`` of both sides of an equality.

    Functions in ``unsplit`` are not rewritten; ``values`` has extra values of functions.  Raises
    ValueError for a function without an axiom, or if no regular point is found.
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
    """Return the typed texts (equations, solutions, domains) that a certificate states."""
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
    domains = {name: [part[name] for part in (kinds, own) if name in part] for name in kinds | own}
    stated = [f"{name}: {', '.join(words)}" for name, words in domains.items()]
    stated += [f"{name}: function" for name in arbitrary_functions(problem)]
    return StatementTexts(
        tuple(variables),
        (written.text(left),),
        tuple(f"{name} = {written.text(place)}" for name, place in pairs),
        (*named, *stated),
        tuple(limit for name, limit in limits.items() if name in variables),
    )


def arbitrary_functions(problem: Problem) -> list[str]:
    """Return the names of the arbitrary functions in a problem."""
    parts = (problem.left, *problem.solutions.values())
    labels = {node.label for part in parts for node in part.atoms(JetFunction)}
    return sorted(labels - THETA.keys())


def _left_side(problem: Problem, table: NodeTable) -> int:
    """Return the node of the left-hand side; a polynomial is written term by term."""
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
    """Return a point at which all formulas are finite; raises ValueError if there is none."""
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
    """Yield the equal parts to prove first, if any are found, and then an empty list."""
    if problem.right is not None:
        sides = problem.formula, problem.right
        lemmas = find_lemmas(*sides, problem.variables, regular_point(problem))
        if lemmas:
            yield lemmas
    yield []


def find_lemmas(
    left: sp.Expr, right: sp.Expr, variables: Sequence[sp.Symbol], point: Point
) -> list[Pair]:
    """Return pairs of large disjoint sums that differ as formulas and agree at ``point``."""
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
    """Map the sums within ``formula`` that contain a variable to their values, if finite."""
    dependence = Dependence(variables)
    inner = distinct_nodes(formula)[1:]
    sums = [node for node in inner if node.is_Add and dependence.depends(node)]
    values = {node: balls.jet(node).value for node in sums}
    return {node: value for node, value in values.items() if value.is_finite()}


class SquareRoots:
    """Square roots among the generators of a field, and the values of the dependent ones."""

    def __init__(self, field: Field, table: NodeTable) -> None:
        self._field, self._table = field, table
        self._places = {node: place for place, node in enumerate(field.nodes.places)}
        self._rows: list[tuple[frozenset[FactorKey], frozenset[int]]] = []
        self._images: dict[int, Element] = {}

    def odd_factors(self, root: int) -> frozenset[FactorKey]:
        """Return the factors of a square root's radicand that have odd powers in it."""
        image = self._field.image(self._field.nodes.all[root][1])
        return frozenset(key for key, power in self._exponents(image).items() if power % 2)

    def value(self, root: int) -> tuple[int, list[int]] | None:
        """Return the node of a dependent root's value, and the roots in it; None if independent."""
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
        roots = [self._places[member] for member in members]
        parts = [*roots]
        for (kind, value), power in self._exponents(quotient).items():
            if kind == "factor":
                base = self._written(self._field.ring.factors[value])
            else:
                base = self._table.place(sp.Integer(value))
            parts.append(self._table.add("Pow", base, str(power // 2)))
        return self._table.add("Mul", *(parts or [self._table.place(sp.S.One)])), roots

    def _exponents(self, element: Element) -> Counter[FactorKey]:
        ring = element.ring
        unit, powers = ring.split(element.numerator)
        exponents: Counter[FactorKey] = Counter({("factor", i): n for i, n in powers.items()})
        exponents.subtract({("factor", i): n for i, n in element.powers.items()})
        for number, sign in ((unit.p, 1), (unit.q, -1)):
            for prime, power in sp.factorint(int(number)).items():
                exponents["number", int(prime)] += sign * power
        return exponents

    def _written(self, polynomial: fmpq_mpoly) -> int:
        """Return the index of a node for a polynomial in the generators."""
        terms = []
        for exponents, coefficient in polynomial.terms():
            pairs = [(place, int(n)) for place, n in enumerate(reversed(exponents)) if n]
            powers = [self._table.add("Pow", self._meaning(place), str(n)) for place, n in pairs]
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
        """Return the index in the table of a node of the field, added with its arguments if new."""
        if node not in self._places:
            name, *parts = self._field.nodes.all[node]
            inner = [str(parts[0])] if name == "number" else map(self._formula, parts)
            return self._table.add(name, *inner)
        return self._places[node]


def with_square_roots(table: NodeTable, statement: StatementTexts, proof: Data) -> Data:
    """Return the proof with values, not generators, for square roots that depend on others."""
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
        value = square_roots.value(field.nodes.places[root])
        if value is not None and _is_root(_field(table, statement, proof), root, value[0]):
            values.append([root, value[0]])
            members[root] = value[1]
    generators: list[list[Any]] = []
    for entry in proof["generators"]:  # the roots in its value replace a dependent root
        own = members.get(entry[1]) if entry[0] == "atom" else None
        taken = [entry] if own is None else [["atom", root] for root in own]
        generators += [new for new in taken if new not in generators]
    return {**proof, "generators": generators, "values": values}


def _is_root(field: Field, root: int, value: int) -> bool:
    """Return whether a value is shown to be the root: equal square, and the principal branch."""
    _, base, exponent = field.nodes.all[field.nodes.places[root]]
    node = field.nodes.places[value]
    same = (field.image(node) ** 2 - field.image(base)).is_zero
    return bool(same and is_branch(field, node, exponent))


def _field(table: NodeTable, statement: StatementTexts, proof: Data) -> Field:
    """Return the field that the checker builds from a proof."""
    declared = (text.partition(":") for text in statement.parameters)
    complexes = [name.strip() for name, _, kind in declared if kind.strip() == "complex"]
    proof = with_conjugates({"formulas": numbered(table.nodes), **proof}, complexes)
    opening = opened({"statement": as_data(statement), "proof": proof})
    return registered(opening, proof)


def with_conjugates(proof: Data, complexes: Sequence[str]) -> Data:
    """Return the proof with complex parameters and their conjugates as first generators."""
    formulas, first = [*proof["formulas"]], []
    for name in complexes:
        first += [["atom", len(formulas)], ["atom", len(formulas) + 1]]
        formulas += [name, f"conjugate({name})"]
    own = [place for place, text in enumerate(formulas) if text in complexes]
    rest = [e for e in proof["generators"] if e[0] != "atom" or e[1] not in own]
    return {**proof, "formulas": formulas, "generators": [*first, *rest]}
