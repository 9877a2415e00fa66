"""The certificate of a proof: its statement as plain data, and hints for `checker`.

`Plan` walks over the formulas and says which generators, argument sums, roots and signs the
checker needs.  It decides nothing: what is wrong here is rejected there.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from typing import Any

import sympy as sp
from flint import acb, ctx

from solutions.special import (
    jacobi_cn,
    jacobi_dn,
    jacobi_epsilon,
    jacobi_eta,
    jacobi_sn,
    jacobi_theta,
    jacobi_zeta,
)
from solutions.special.function import JacobiFunction
from verify.tree import distinct_nodes

from .balls import BallEvaluator, Point, ball_value
from .checker.check import FORMAT, FORMS, digest, registered
from .checker.limits import JETS
from .checker.nodes import Nodes
from .checker.statement import read_statement
from .domain import Domains
from .jet import Shape
from .kernels import HYPERBOLIC, TRIGONOMETRIC, Kernels
from .lattice import without_logarithms
from .linear import Form, linear_forms, pivot_columns, with_one_integral
from .problem import Problem, coefficients, terms_in
from .radicals import Radicals
from .rewriting import Rewriting
from .signs import Signs
from .tree import NodeTable

Data = dict[str, Any]
BITS = 160
TRIPLE = (jacobi_sn, jacobi_cn, jacobi_dn)


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


def with_radicals(table: NodeTable, statement: Data, proof: Data) -> Data:
    """The proof with each square root that depends on earlier ones named, not a generator."""
    roots = {
        entry[1]
        for entry in proof["generators"]
        if entry[0] == "atom"
        and table.nodes[entry[1]][0] == "Pow"
        and table.nodes[entry[1]][2] == "1/2"
    }
    if not roots:
        return proof
    nodes = Nodes(table.nodes)
    field = registered(nodes, read_statement(nodes, statement), proof)
    radicals = Radicals(field, table, {node: place for place, node in enumerate(nodes.places)})
    dependent: dict[int, int] = {}
    for entry in proof["generators"]:
        if entry[0] == "atom" and entry[1] in roots:
            value = radicals.value(nodes.places[entry[1]])
            if value is not None and _is_not_negative(table, statement, proof, value):
                dependent[entry[1]] = value
    kept = [e for e in proof["generators"] if e[0] != "atom" or e[1] not in dependent]
    values = [*proof["values"], *([root, value] for root, value in dependent.items())]
    return {**proof, "generators": kept, "values": values}


def _is_not_negative(table: NodeTable, statement: Data, proof: Data, value: int) -> bool:
    nodes = Nodes(table.nodes)
    field = registered(nodes, read_statement(nodes, statement), proof)
    return field.signs.not_negative(nodes.places[value])


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


class Unsupported(ValueError):
    """A formula contains something that no axiom speaks of."""


class Plan:
    """The generators and hints with which a checker can find the images of ``expressions``.

    ``values`` are the simpler forms of roots and absolute values that a domain allows; with
    ``moving`` the derivatives of the generators are wanted too.
    """

    def __init__(
        self,
        table: NodeTable,
        expressions: Sequence[sp.Expr],
        variables: Sequence[sp.Symbol],
        values: Mapping[sp.Expr, sp.Expr] | None = None,
        *,
        moving: bool = True,
    ) -> None:
        self.table, self.variables = table, tuple(variables)
        self._expressions = list(expressions)
        self._values = dict(values or {})
        self._moving = moving
        self._done: set[sp.Expr] = set()
        self._generators: list[list[Any]] = []
        self._registered: set[int] = set()
        self._hints: dict[str, dict[int, Any]] = {n: {} for n in ("sums", "values", "logs")}
        self._signs: dict[int, int] = {}
        self._parts: list[list[Any]] = []
        self._epsilon = any(
            isinstance(node, jacobi_epsilon) for e in expressions for node in distinct_nodes(e)
        )

    def equal_part(self, left: sp.Expr, right: sp.Expr, proof: Data) -> None:
        """Take one generator for two formulas that ``proof`` shows to be equal."""
        place = len(self._parts)
        self._parts.append([self.table.place(left), self.table.place(right), proof])
        self._generators.append(["part", place, place])
        self._done |= {left, right}

    def proof(self, point: Point) -> Data:
        """The proof's part of a certificate; ``point`` is where no denominator vanishes."""
        visible = _visible(self._expressions, self._done)
        values = [self._factors_in(node, value) for node, value in self._values.items()]
        self.kernels = Kernels([*visible, *values], self.variables)
        found = _forms(self._expressions, self.kernels, self._done, point)
        self._pivots, self._others, self._rows = found
        for expression in self._expressions:
            self.need(expression)
        return {
            "generators": self._generators,
            **{name: [[z, v] for z, v in hints.items()] for name, hints in self._hints.items()},
            "signs": [[node, other] for node, other in self._signs.items()],
            "point": [[self.table.place(s), str(value)] for s, value in point.items()],
            "parts": self._parts,
        }

    @staticmethod
    def _factors_in(node: sp.Expr, value: sp.Expr) -> sp.Expr:
        """What the value of ``node`` brings in: of a logarithm, the factors of its argument."""
        if not isinstance(node, sp.log):
            return value
        terms = [term for term in sp.Add.make_args(value) if not term.has(sp.log)]
        return sp.Tuple(value, *map(sp.exp, terms))

    def need(self, node: sp.Expr) -> None:
        """Provide for the image of ``node``."""
        if node in self._done:
            return
        self._done.add(node)
        if node in self._values and isinstance(node, sp.log):
            self._logarithm(node, self._values[node])
            return
        if node in self._values and not _follows_from_others(node):
            self._hints["values"][self.table.place(node)] = self.table.place(self._values[node])
            self.need(self._values[node])
            self.need(node.args[0])
            return
        if node.is_Rational:
            return
        if node.is_Add or node.is_Mul:
            for part in node.args:
                self.need(part)
        elif node.is_Pow:
            self._power(node)
        elif node.is_Symbol or node in (sp.I, sp.pi):
            self._primitive(node)
        elif node is sp.E:
            self._exponential(sp.S.One, self.table.place(sp.S.One))
        else:
            self._function(node)

    def _atom(self, place: int, *rest: Any) -> None:
        if place not in self._registered:
            self._registered.add(place)
            self._generators.append([*(rest or ("atom", place))])

    def _primitive(self, node: sp.Expr) -> None:
        """A symbol or a constant."""
        if node in self._pivots:
            self._register_forms()
            return
        if node in self.kernels.circles:
            other = self.table.place(sp.sqrt(1 - node**2))
            self._atom(other, "circle", other, self.table.place(node))
        self._atom(self.table.place(node))

    def _register_forms(self) -> None:
        """The linear forms, at the first of their primitives that is needed."""
        pivots, self._pivots = self._pivots, []
        if not pivots:
            return
        rows = []
        for row in self._rows:
            factors, rest = row[: len(pivots)], row[len(pivots) :]
            shift = sp.Add(*(v * p for v, p in zip(rest, self._others, strict=True)))
            for part in (*factors, shift):
                self.need(part)
                self._show_sign_of_roots(part)
            rows.append([[self.table.place(f) for f in factors], self.table.place(shift)])
        for pivot in pivots:
            if isinstance(pivot, sp.Tuple):
                self.need(pivot[1])
        places = [self._primitive_place(pivot) for pivot in pivots]
        self._registered |= set(places)
        self._done |= {pivot for pivot in pivots if isinstance(pivot, sp.Symbol)}
        self._generators.append(["forms", places, rows])

    def _primitive_place(self, primitive: sp.Basic) -> int:
        if isinstance(primitive, sp.Tuple):
            return self.table.made("jacobi_epsilon", *map(self.table.place, primitive))
        return self.table.place(primitive)

    def _power(self, node: sp.Expr) -> None:
        base, exponent = node.base, node.exp
        if not exponent.is_Rational:
            raise Unsupported(f"no generator is known for the power {node}")
        if isinstance(base, sp.Abs) and exponent.is_Integer and exponent % 2 == 0:
            self.need(base.args[0])
            return
        self.need(base)
        if exponent.is_Integer:
            return
        root = sp.Pow(base, sp.Rational(1, exponent.q))
        if root != node and (root in self._values or not root.is_Pow or root.base != base):
            self.need(root)
        place = self.table.made("Pow", self.table.place(base), f"1/{exponent.q}")
        if not root.is_Pow or root.base != base:
            self._hints["values"][place] = self.table.place(root)
        elif root not in self._values:
            self._atom(place)

    def _show_sign_of_roots(self, expression: sp.Expr) -> None:
        for node in distinct_nodes(expression):
            if node.is_Pow and node.exp.is_Rational and not node.exp.is_Integer:
                self.show_sign(node.base)

    def show_sign(self, node: sp.Expr) -> None:
        """Offer the factors of ``node`` as witness of its sign."""
        other = sp.factor(node)
        if other != node:
            self._signs[self.table.place(node)] = self.table.place(other)

    def _function(self, node: sp.Expr) -> None:
        if isinstance(node, JacobiFunction):
            self._elliptic(node)
            return
        (z,) = node.args
        self.need(z)
        if isinstance(node, (sp.exp, *HYPERBOLIC)):
            self._exponential(z, self.table.place(z))
        elif isinstance(node, TRIGONOMETRIC):
            self.need(sp.I)
            place = self.table.made("Mul", self.table.place(sp.I), self.table.place(z))
            self._exponential(sp.I * z, place)
        elif isinstance(node, sp.elliptic_k | sp.elliptic_e):
            self._below_one(z)
            self._atom(self.table.place(node))
        elif isinstance(node, sp.log):
            self._atom(self.table.place(node))
        elif isinstance(node, sp.atan):
            if isinstance(z, sp.tan):
                self._hints["values"][self.table.place(node)] = self.table.place(z.args[0])
                self.need(z.args[0])
            else:
                self._atom(self.table.place(node))
        elif isinstance(node, sp.conjugate | sp.re | sp.im):
            if isinstance(node, sp.im):
                self.need(sp.I)
            self.need(z.xreplace({sp.I: -sp.I}))
        elif isinstance(node, sp.Abs):
            self._atom(self.table.place(node))
        elif isinstance(node, sp.sign):
            self.need(sp.Abs(z))
        else:
            raise Unsupported(f"no generator is known for {node.func.__name__}")

    def _logarithm(self, node: sp.Expr, value: sp.Expr) -> None:
        """log of a product as a sum of logarithms, and of exponentials' arguments."""
        self.need(node.args[0])
        found = []
        for term in sp.Add.make_args(value):
            q, rest = term.as_coeff_Mul(rational=True)
            factor = rest.args[0] if isinstance(rest, sp.log) else sp.exp(term)
            q = q if isinstance(rest, sp.log) else sp.S.One
            self.need(rest)
            self.need(sp.Pow(factor, q))
            found.append([str(q), self.table.place(factor)])
        self._hints["logs"][self.table.place(node)] = found

    def _exponential(self, z: sp.Expr, place: int) -> None:
        rest, logarithms = without_logarithms(z)
        lattice = self.kernels.exponents
        found = []
        for basis, n in zip(lattice.basis, lattice.coordinates(rest), strict=True):
            if n:
                self.need(basis)
                self._atom(self.table.made("exp", self.table.place(basis)))
                found.append([str(n), self.table.place(basis)])
        for logarithm, q in logarithms.items():
            if isinstance(logarithm, sp.log):
                self.need(sp.Pow(logarithm.args[0], q))
            self.need(logarithm)
            found.append([str(q), self.table.place(logarithm)])
        self._hints["sums"][self.table.made("exp", place)] = found

    def _elliptic(self, node: sp.Expr) -> None:
        z, m = node.args
        self.need(z)
        self.need(m)
        self._below_one(m)
        if isinstance(node, jacobi_theta):
            self._theta(z, m)
        elif isinstance(node, jacobi_eta):
            self._root_of_parameter(m, sp.sqrt(sp.sqrt(m)), "1/4")
            self.need(jacobi_sn(z, m))
            self.need(jacobi_theta(z, m))
        elif isinstance(node, jacobi_zeta) and self._epsilon:
            for part in (jacobi_epsilon(z, m), sp.elliptic_e(m), sp.elliptic_k(m)):
                self.need(part)
        else:
            self._station(z, m, node.func if node.func not in TRIPLE else None)

    def _below_one(self, m: sp.Expr) -> None:
        """Offer the factors of 1 - m as witness of its sign."""
        one, minus = (self.table.place(sp.Integer(n)) for n in (1, -1))
        rest = self.table.made("Add", one, self.table.made("Mul", minus, self.table.place(m)))
        other = self.table.place(sp.factor(1 - m))
        if other != rest:
            self._signs[rest] = other

    def _root_of_parameter(self, base: sp.Expr, root: sp.Expr, exponent: str) -> None:
        """The root as SymPy writes it, of a node as the checker writes it."""
        self.need(base)
        self.need(root)
        place = self.table.made("Pow", self.table.place(base), exponent)
        if place != self.table.place(root):
            self._hints["values"][place] = self.table.place(root)

    def _station(self, z: sp.Expr, m: sp.Expr, second: type | None) -> None:
        """The Jacobi functions of the arguments whose combination is ``z``."""
        variable, constant = self.kernels.parts(z)
        found = []
        for lattice, part in (
            (self.kernels.moving(m), variable),
            (self.kernels.fixed(m), constant),
        ):
            if part == 0:
                continue
            for u, n in zip(lattice.basis, lattice.coordinates(part), strict=True):
                if n:
                    side = -1 if u.could_extract_minus_sign() else 1
                    self._argument(side * u, m, second)
                    found.append([str(side * n), self.table.place(side * u)])
        place = self.table.place(z)
        if found != [["1", place]]:
            sine = self.table.made("jacobi_sn", place, self.table.place(m))
            self._hints["sums"][sine] = found

    def _argument(self, u: sp.Expr, m: sp.Expr, second: type | None) -> None:
        self.need(u)
        place, parameter = self.table.place(u), self.table.place(m)
        if u == sp.elliptic_k(m):
            one, minus = (self.table.place(sp.Integer(n)) for n in (1, -1))
            rest = self.table.made("Add", one, self.table.made("Mul", minus, parameter))
            self.need(sp.sqrt(1 - m))
            node = self.table.made("Pow", rest, "1/2")
            if node != self.table.place(sp.sqrt(1 - m)):
                self._hints["values"][node] = self.table.place(sp.sqrt(1 - m))
            if second is jacobi_epsilon:
                self.need(sp.elliptic_e(m))
            return
        modulus = sp.sqrt(m)
        for function in sorted(TRIPLE, key=lambda f: -self.kernels.count[f, m]):
            own = self.table.made(function.__name__, place, parameter)
            if modulus.is_Symbol and function is not jacobi_dn:
                self._atom(own, "scaled", own, self.table.place(modulus))
            else:
                self._atom(own)
        if second is not None:
            self._second(second, u, m)

    def _second(self, kind: type, u: sp.Expr, m: sp.Expr) -> None:
        """Epsilon or zeta of a generator's argument, and what its derivative needs."""
        if kind is jacobi_zeta and self._moves(u):
            self.need(sp.elliptic_e(m))
            self.need(sp.elliptic_k(m))
        own = self.table.made(kind.__name__, self.table.place(u), self.table.place(m))
        if sp.Tuple(u, m) in self._pivots and kind is jacobi_epsilon:
            self._register_forms()
        self._atom(own)

    def _moves(self, node: sp.Expr) -> bool:
        return self._moving and self.kernels.dependence.moves(node)

    def _theta(self, z: sp.Expr, m: sp.Expr) -> None:
        variable, constant = self.kernels.parts(z)
        if variable == 0:
            self._atom(self.table.place(jacobi_theta(constant, m)))
            return
        basis = self.kernels.moving(m).basis
        if -variable in basis:
            variable, constant = -variable, -constant
        if variable not in basis:
            raise Unsupported(f"theta of a multiple of another argument: theta({z})")
        here = self.table.place(jacobi_theta(variable, m))
        self._slope_of_theta(variable, m)
        self._atom(here)
        if constant == 0:
            return
        shift = -constant if constant.could_extract_minus_sign() else constant
        self._quotient(variable, shift, m, here)
        if shift != constant:
            for part in (jacobi_theta(shift, m), jacobi_theta(0, m)):
                self._atom(self.table.place(part))
            for argument in (variable, shift):
                self.need(argument)
                self._station(argument, m, None)
            ends = [self.table.place(variable), self.table.place(shift)]
            if sp.expand(z - variable + shift) != 0:
                ends.reverse()
            pair = [["1", ends[0]], ["-1", ends[1]]]
            node = self.table.made("jacobi_theta", self.table.place(z), self.table.place(m))
            self._hints["sums"][node] = pair

    def _slope_of_theta(self, u: sp.Expr, m: sp.Expr) -> None:
        if self._moves(u):
            self.need(jacobi_zeta(u, m))

    def _quotient(self, u: sp.Expr, d: sp.Expr, m: sp.Expr, here: int) -> None:
        total = self.table.made("Add", self.table.place(u), self.table.place(d))
        ahead = self.table.made("jacobi_theta", total, self.table.place(m))
        if ahead in self._registered:
            return
        self.need(u)
        self.need(d)
        if self._moves(u):
            self._station(u, m, jacobi_zeta)
            self._station(d, m, jacobi_zeta)
            pair = [["1", self.table.place(u)], ["1", self.table.place(d)]]
            sine = self.table.made("jacobi_sn", total, self.table.place(m))
            self._hints["sums"][sine] = pair
        self._atom(ahead, "quotient", ahead, here)


def _follows_from_others(node: sp.Expr) -> bool:
    """Whether the checker takes the image of ``node`` from that of another function."""
    is_power = node.is_Pow and node.exp.is_Rational and node.exp.p != 1
    return is_power or isinstance(node, sp.conjugate | sp.re | sp.im | sp.sign)


def _visible(expressions: Iterable[sp.Expr], hidden: set[sp.Expr]) -> list[sp.Expr]:
    """The expressions with what one generator stands for left out."""
    names = {node: sp.Dummy() for node in hidden}
    return [expression.xreplace(names) for expression in expressions]


def _forms(
    expressions: Sequence[sp.Expr], kernels: Kernels, hidden: set[sp.Expr], point: Point
) -> tuple[list[sp.Basic], list[sp.Expr], list[list[sp.Expr]]]:
    """Pivots, other primitives, and independent linear forms: rows of factors of all of them.

    The primitives are variables and, for epsilon(u), the pair (u, m).  Independence is that of
    balls at ``point``: any choice makes generators.
    """
    written = with_one_integral(_visible(expressions, hidden), kernels.dependence)
    forms = [_by_argument(f, kernels) for f in linear_forms(written, kernels.dependence)]
    primitives = sorted(
        {p for form in forms for p in form}, key=lambda p: (not isinstance(p, sp.Tuple), str(p))
    )
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


def _by_argument(form: Form, kernels: Kernels) -> dict[sp.Basic, sp.Expr]:
    """A linear form with the pairs (u, m) for epsilon(u) up to the sign of u."""
    found: dict[sp.Basic, sp.Expr] = {}
    for primitive, value in form.items():
        key: sp.Basic = primitive
        if isinstance(primitive, jacobi_epsilon):
            u, m = kernels.parts(primitive.args[0])[0], primitive.args[1]
            side = -1 if u.could_extract_minus_sign() else 1
            key, value = sp.Tuple(side * u, m), side * value
        found[key] = found.get(key, sp.S.Zero) + value
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
