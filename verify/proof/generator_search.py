"""Search for a proof: the generators, argument sums, roots and signs that the checker needs.

Nothing is decided here; the checker rejects wrong hints.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy as sp
from sympy.functions.special.bessel import BesselBase

from longwave.solutions.functions import jacobi_epsilon, weierstrass
from longwave.solutions.functions.jacobi import JacobiFunction
from longwave.solutions.functions.jet_functions import JetFunction, jet_function
from longwave.verify.subexpressions import distinct_nodes

from . import arguments
from .certificate_writer import NAMES, Data, NodeTable, ProofWriter
from .domain_signs import excess_of_exponential, is_small_polynomial
from .domains import Domains, Point
from .elliptic_search import EllipticSearch
from .linear_forms import independent_forms, with_dummies
from .simplification import needs_integers

AIRY_PAIRS = (sp.airyai, sp.airyaiprime), (sp.airybi, sp.airybiprime)
AIRY = {function: pair for pair in AIRY_PAIRS for function in pair}
"""For each Airy function, the pair of functions that expresses its derivatives."""


ELLIPTIC = (JacobiFunction, sp.elliptic_k, sp.elliptic_e)
"""Functions that are elementary for the parameters 0 and 1."""


class GeneratorSearch:
    """Generators and hints with which the checker can find the images of ``expressions``.

    ``values`` has the simpler forms of roots and absolute values that a domain allows.  With
    ``moving`` the derivatives of the generators are needed too, up to the order ``order``.
    """

    def __init__(
        self,
        table: NodeTable,
        expressions: Sequence[sp.Expr],
        variables: Sequence[sp.Symbol],
        values: Mapping[sp.Expr, sp.Expr],
        *,
        moving: bool,
        order: int = 0,
    ) -> None:
        self._writer, self._place, self._add = ProofWriter(table), table.place, table.add
        self._variables, self._expressions = tuple(variables), list(expressions)
        self._values, self._moving, self._order = values, moving, order
        self._orders: set[tuple[type, sp.Expr, sp.Expr]] = set()
        self._done: set[sp.Expr] = set()
        nodes = (node for expression in expressions for node in distinct_nodes(expression))
        self._has_epsilon = any(isinstance(node, jacobi_epsilon) for node in nodes)

    def equal_part(self, left: sp.Expr, right: sp.Expr, proof: Data) -> None:
        """Add one generator for two formulas that ``proof`` shows to be equal."""
        place = len(self._writer.parts)
        self._writer.parts.append([self._place(left), self._place(right), proof])
        self._writer.generators.append(["part", place])
        self._done |= {left, right}

    def proof(self, point: Point, domains: Domains | None = None) -> Data:
        """Return the proof part of a certificate; no denominator vanishes at ``point``."""
        visible = with_dummies(self._expressions, self._done)
        values = [self._factors_in(node, value) for node, value in self._values.items()]
        logarithms = {f: value for f, value in self._values.items() if isinstance(f, sp.log)}
        self._arguments = arguments.Arguments([*visible, *values], self._variables, logarithms)
        self._elliptic = EllipticSearch(
            self._writer, self._arguments, self.need, self._begin_forms,
            moving=self._moving, epsilon=self._has_epsilon,
        )  # fmt: skip
        forms = independent_forms(self._expressions, self._arguments, self._done, point)
        self._pivots, self._others, self._rows = forms
        for expression in self._expressions:
            self.need(expression)
        self._show_ends(domains or {})
        return self._writer.data(point)

    @staticmethod
    def _factors_in(node: sp.Expr, value: sp.Expr) -> sp.Expr:
        """Return the hinted ``value``; for a logarithm, also exp of each term without a log."""
        if not isinstance(node, sp.log):
            return value
        terms = [term for term in sp.Add.make_args(value) if not term.has(sp.log)]
        return sp.Tuple(value, *map(sp.exp, terms))

    def need(self, node: sp.Expr) -> None:
        """Register the generators and hints that the image of ``node`` needs."""
        if node in self._done:
            return
        self._done.add(node)
        if node in self._values and isinstance(node, sp.log):
            self._logarithm(node, self._values[node])
            return
        if node in self._values and not _follows_from_others(node):
            value = self._values[node]
            self._writer.name(value=self._place(value), place=self._place(node))
            self.need(value)
            self.need(node.args[0])
            if isinstance(node, sp.atan | sp.asin):
                self._angle(node, value)
            return
        if node.is_Add or node.is_Mul:
            for part in node.args:
                self.need(part)
            self._show_excess(node)
        elif node.is_Pow:
            self._power(node)
        elif node.is_Symbol or node in (sp.I, sp.pi):
            if not self._begin_forms(node):
                if node in self._arguments.circles:
                    self._writer.atom(self._place(sp.sqrt(1 - node**2)))
                self._writer.atom(self._place(node))
        elif node is sp.E:
            self._exponential(sp.S.One, self._place(sp.S.One))
        elif not node.is_Rational:
            self._function(node)

    def _begin_forms(self, primitive: sp.Basic) -> bool:
        """Register the linear forms if ``primitive`` is their first one; return whether it is."""
        if primitive not in self._pivots:
            return False
        pivots, self._pivots = self._pivots, []
        rows = []
        for row in self._rows:
            factors, rest = row[: len(pivots)], row[len(pivots) :]
            shift = sp.Add(*(v * p for v, p in zip(rest, self._others, strict=True)))
            for part in (*factors, shift):
                self.need(part)
                for node in distinct_nodes(part):
                    if node.is_Pow and node.exp.is_Rational and not node.exp.is_Integer:
                        self.show_sign(node.base)
            rows.append([[self._place(f) for f in factors], self._place(shift)])
        for pivot in pivots:
            if isinstance(pivot, sp.Tuple):
                self.need(pivot[1])
        places = []
        for pivot in pivots:
            pair = map(self._place, pivot) if isinstance(pivot, sp.Tuple) else None
            places.append(self._add("jacobi_epsilon", *pair) if pair else self._place(pivot))
        self._writer.registered |= set(places)
        self._done |= {pivot for pivot in pivots if isinstance(pivot, sp.Symbol)}
        self._writer.generators.append(["forms", places, rows])
        return True

    def _power(self, node: sp.Expr) -> None:
        base, exponent = node.base, node.exp
        if base is sp.S.NegativeOne and exponent.is_integer and not exponent.is_Integer:
            for symbol in exponent.free_symbols:
                self.need(symbol)
                self._writer.atom(self._place(sp.Pow(base, symbol)))
            return
        if not exponent.is_Rational:
            raise ValueError(f"no generator is known for the power {node}")
        if isinstance(base, sp.Abs) and exponent.is_Integer and exponent % 2 == 0:
            self.need(base.args[0])
            return
        self.need(base)
        if exponent.is_Integer:
            return
        if is_small_polynomial(base):
            self.show_sign(base)
        root = sp.Pow(base, sp.Rational(1, exponent.q))
        if root != node and (root in self._values or not root.is_Pow or root.base != base):
            self.need(root)
        place = self._add("Pow", self._place(base), f"1/{exponent.q}")
        if not root.is_Pow or root.base != base:
            self._writer.name(place=place, value=self._place(root))
        elif root not in self._values:
            self._root(place, base, int(exponent.q))

    def _root(self, place: int, base: sp.Expr, degree: int) -> None:
        """Register a root, as a power of the single root of its radicand that is a generator."""
        whole = self._arguments.degrees.get(base, degree)
        finest = self._add("Pow", self._place(base), f"1/{whole}")
        self._writer.atom(finest)
        if whole != degree:
            self._writer.name(place=place, value=self._add("Pow", finest, f"{whole // degree}"))

    def _angle(self, node: sp.Expr, value: sp.Expr) -> None:
        """Register the exponential with which the value of an inverse function is checked.

        Except for atan f, the sign of 1 - f**2 gets a witness too."""
        self.need(sp.I)
        turned = [self._place(part) for part in (sp.I, value)]
        if isinstance(node, sp.atan):
            place = self._add("Mul", self._place(sp.Integer(2)), *turned)
            self._exponential(2 * sp.I * value, place)
            return
        self._exponential(sp.I * value, self._add("Mul", *turned))
        rest, known = self._cosine_square(node.args[0])
        self._writer.signs[rest] = self._place(sp.factor(known))

    def _name_cosine(self, f: sp.Expr) -> None:
        """Record SymPy's value of sqrt(1 - f**2) in the definition of asin f, for a number f."""
        if f.is_Rational:
            rest, known = self._cosine_square(f)
            self.need(sp.sqrt(known))
            root = self._add("Pow", rest, "1/2")
            self._writer.name(place=root, value=self._place(sp.sqrt(known)))

    def _cosine_square(self, f: sp.Expr) -> tuple[int, sp.Expr]:
        """Return 1 - f**2 as the checker writes it, and as SymPy does."""
        one, minus = (self._place(sp.Integer(n)) for n in (1, -1))
        square = self._add("Mul", minus, self._add("Pow", self._place(f), "2"))
        return self._add("Add", one, square), 1 - f**2

    def show_sign(self, node: sp.Expr) -> None:
        """Record the factored ``node`` as the witness that shows its sign."""
        other = sp.factor(node)
        if other != node:
            self._writer.signs[self._place(node)] = self._place(other)

    def _show_excess(self, node: sp.Expr) -> None:
        """Record r*(exp(x - log(r)) - 1) as witness of the sign of exp(x) - r."""
        excess = excess_of_exponential(node) if node.is_Add else None
        if excess is not None:
            one = sp.Add(excess[1], sp.S.NegativeOne, evaluate=False)
            witness = sp.Mul(excess[0], one, evaluate=False)
            self._writer.signs[self._place(node)] = self._place(witness)

    def _show_ends(self, domains: Domains) -> None:
        """Record k = (k - l) + l as witness of the sign of a symbol k > l."""
        registered = self._writer.registered
        for symbol, domain in domains.items():
            ends = (domain.lower, 1), (domain.upper, -1)
            known = any(end.is_Rational and end * side >= 0 for end, side in ends)
            for end, side in ends:
                names = [self._place(s) for s in (symbol, *end.free_symbols)]
                if not known and is_small_polynomial(end) and registered.issuperset(names):
                    gap = sp.Add(side * symbol, -side * end, evaluate=False)
                    part = gap if side == 1 else sp.Mul(-1, gap, evaluate=False)
                    whole = sp.Add(part, end, evaluate=False)
                    self._writer.signs.setdefault(names[0], self._place(whole))

    def _function(self, node: sp.Expr) -> None:
        if isinstance(node, ELLIPTIC) and node.args[-1] in (0, 1):
            self.need(node.func(*node.args))
            return
        if isinstance(node, JacobiFunction):
            self._elliptic.provide(node)
            return
        for argument in node.args:
            self.need(argument)
        z = node.args[0]
        if isinstance(node, JetFunction | weierstrass.WeierstrassFunction | BesselBase):
            self._special(node)
        elif isinstance(node, (sp.exp, *arguments.HYPERBOLIC)):
            self._exponential(z, self._place(z))
        elif isinstance(node, arguments.TRIGONOMETRIC):
            self.need(sp.I)
            place = self._add("Mul", self._place(sp.I), self._place(z))
            self._exponential(sp.I * z, place)
        elif isinstance(node, sp.log | sp.atan | sp.LambertW | sp.elliptic_k | sp.elliptic_e):
            if isinstance(node, sp.elliptic_k | sp.elliptic_e):
                self._elliptic.below_one(z)
            self._writer.atom(self._place(node))
        elif node.func in AIRY:
            for function in AIRY[node.func]:
                self._writer.atom(self._place(function(z)))
        elif isinstance(node, sp.erf):
            if self._moving:
                self.need(sp.sqrt(sp.pi))
                self.need(sp.exp(-(z**2)))
            self._writer.atom(self._place(node))
        elif isinstance(node, arguments.INVERSE):
            if isinstance(node, sp.asin | sp.acos):
                self.need(sp.I)
                self._name_cosine(z)
            self.need(sp.asin(z) if isinstance(node, sp.acos) else arguments.definition(node))
        elif isinstance(node, sp.conjugate | sp.re | sp.im):
            if isinstance(node, sp.im):
                self.need(sp.I)
            self.need(z.xreplace({sp.I: -sp.I}))
        elif isinstance(node, sp.Abs | sp.sign):
            modulus, place = sp.Abs(z), self._add("Abs", self._place(z))
            if node == modulus or needs_integers(node):
                self._writer.atom(place)
            else:
                if not (isinstance(modulus, sp.Abs) and modulus.args[0] == z):
                    self._writer.name(place=place, value=self._place(modulus))
                self.need(modulus)
        else:
            raise ValueError(f"no generator is known for {node.func.__name__}")

    def _special(self, node: sp.Expr) -> None:
        """Register the functions that express the derivatives of a jet, p or Bessel function."""
        if isinstance(node, JetFunction):
            steps = self._order * len(node.args) if self._moving else 0
            orders = range(node.order, node.order + steps + 1)
            functions = [jet_function(node.label, order)(*node.args) for order in orders]
            for nome in node.args[1:]:
                self._show_nome(nome)
        elif isinstance(node, weierstrass.WeierstrassFunction):
            pair = weierstrass.weierstrass_p, weierstrass.weierstrass_p_prime
            functions = [function(*node.args) for function in pair]
        else:
            v, z = node.args
            if arguments.has_half_order(node):
                for part in (arguments.definition(node), sp.sqrt(2), sp.sqrt(z)):
                    self.need(part)
                root = self._add("Pow", self._place(z), "1/2")
                self._writer.name(place=root, value=self._place(sp.sqrt(z)))
                return
            plain = sp.expand(arguments.cancelled(v))
            sides = (plain, -plain) if isinstance(node, sp.besselk) else (plain,)
            keys = [(node.func, v - sp.floor(v.as_coeff_Add(rational=True)[0]), z) for v in sides]
            if self._orders.isdisjoint(keys):  # two orders determine all others
                self._orders.add(keys[0])
                name, argument = NAMES[node.func], self._place(z)
                for order in (v, v + 1):
                    self._writer.atom(self._add(name, self._place(order), argument))
            return
        for function in functions:
            self._writer.atom(self._place(function))

    def _show_nome(self, q: sp.Expr) -> None:
        """Record the nome q, written in exponentials, as witness of the signs of q and 1 - q."""
        plain = sp.expand(q.rewrite(sp.exp))
        if plain != q:
            self.need(plain)
            one, places = self._place(sp.S.One), map(self._place, (q, plain))
            negatives = [self._add("Mul", self._place(sp.S.NegativeOne), p) for p in places]
            rest, witness = (self._add("Add", one, negative) for negative in negatives)
            self._writer.signs |= {self._place(q): self._place(plain), rest: witness}

    def _logarithm(self, node: sp.Expr, value: sp.Expr) -> None:
        """Record the logarithm of a product as a sum of logarithms and exponents."""
        self.need(node.args[0])
        terms = []
        for term in filter(None, sp.Add.make_args(value)):
            q, rest = term.as_coeff_Mul(rational=True)
            factor = rest.args[0] if isinstance(rest, sp.log) else sp.exp(term)
            q = q if isinstance(rest, sp.log) else sp.S.One
            self.need(rest)
            self.need(sp.Pow(factor, q))
            terms.append((str(q), self._add("log", self._place(factor))))
        self._writer.values[self._place(node)] = self._writer.table.combination(terms)

    def _exponential(self, z: sp.Expr, place: int) -> None:
        rest, logarithms = self._arguments.exponent(z)
        combinations = self._arguments.exponents
        terms = []
        for basis, n in zip(combinations.basis, combinations.coordinates(rest), strict=True):
            if n:
                self.need(basis)
                self._writer.atom(self._add("exp", self._place(basis)))
                terms.append((str(n), self._place(basis)))
        for logarithm, q in logarithms.items():
            if isinstance(logarithm, sp.log):
                self.need(sp.Pow(logarithm.args[0], q))
            elif logarithm == arguments.TURN:
                for part in (sp.I, sp.cos(q * sp.pi), sp.sin(q * sp.pi)):
                    self.need(part)
            elif isinstance(logarithm, sp.LambertW):
                self.need(logarithm.args[0])
            elif q % 2:
                self.need(sp.sqrt(1 + (logarithm / sp.I).args[0] ** 2))
            self.need(logarithm)
            terms.append((str(q), self._place(logarithm)))
        self._writer.words(self._add("exp", place), terms)


def _follows_from_others(node: sp.Expr) -> bool:
    """Return whether the checker derives the image of ``node`` from that of another function."""
    is_power = node.is_Pow and node.exp.is_Rational and node.exp.p != 1
    return is_power or isinstance(node, sp.conjugate | sp.re | sp.im | sp.sign)
