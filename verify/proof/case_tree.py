"""Solve polynomial systems in constants by cases: factors, linear symbols, pseudo-division.

Every step is exhaustive: a product vanishes if one of its factors does, a coefficient is 0 or not,
and a sum of nonnegative terms vanishes if all terms do.  So no real solution is lost, except those
that `CaseTree.left_out` names.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import sympy as sp
from flint import Ordering, fmpq, fmpq_mpoly, fmpq_mpoly_ctx

from longwave.derive.algebra.formula_printing import formula_as_text

from .balls import ball_value
from .constant_terms import Relations, Terms, terms_of
from .domain_signs import DomainSigns, domain_of
from .domains import Domains
from .factors import written
from .linear_forms import BITS
from .problem import POINTS
from .samples import sample

SIGNED_TERMS = 8
"""Most terms of a polynomial whose sign is examined."""

MOST_SYSTEMS = 4_000
"""Most systems examined; the costliest problem of the tests needs 150."""


class Constants:
    """Polynomial ring in constants: parameters, and roots and functions of parameters."""

    def __init__(self, constants: Iterable[sp.Expr], relations: Relations) -> None:
        self.all = sorted(set(constants), key=sp.default_sort_key)
        names = tuple(f"c{place}" for place in range(max(1, len(self.all))))
        self.context = fmpq_mpoly_ctx.get(names, Ordering.lex)
        self.places = {constant: place for place, constant in enumerate(self.all)}
        known = {g: pair for g, pair in relations.items() if g in self.places}
        pairs = ((g, degree, self.polynomial(terms)) for g, (degree, terms) in known.items())
        self.relations = {self.places[g]: (degree, value) for g, degree, value in pairs}

    def polynomial(self, terms: Terms) -> fmpq_mpoly:
        """Return the polynomial with these terms."""
        table: dict[tuple[int, ...], fmpq] = {}
        for monomial, c in terms.items():
            powers = [0] * self.context.nvars()
            for constant, power in monomial:
                powers[self.places[constant]] += power
            table[tuple(powers)] = table.get(tuple(powers), fmpq(0)) + c
        return self.context.from_dict(table)

    def written(self, polynomial: fmpq_mpoly) -> sp.Expr:
        """Return a polynomial as a SymPy expression."""
        return written(polynomial, self.all)

    def used(self, polynomial: fmpq_mpoly) -> list[int]:
        """Return the indices of the constants that occur."""
        return [place for place, degree in enumerate(polynomial.degrees()) if degree]

    def coefficients(self, polynomial: fmpq_mpoly, place: int) -> list[fmpq_mpoly]:
        """Return the coefficients of the powers of constant number ``place``, lowest first."""
        count = int(polynomial.degrees()[place]) + 1
        rows: list[dict[tuple[int, ...], fmpq]] = [{} for _ in range(count)]
        for exponents, c in polynomial.terms():
            rest = tuple(0 if i == place else int(n) for i, n in enumerate(exponents))
            rows[int(exponents[place])][rest] = c
        return [self.context.from_dict(row) for row in rows]

    def reduced(self, polynomial: fmpq_mpoly) -> fmpq_mpoly:
        """Reduce the powers of algebraic constants in a polynomial by their relations."""
        for place, (degree, value) in self.relations.items():
            while int(polynomial.degrees()[place]) >= degree:
                rows = self.coefficients(polynomial, place)
                gen = self.context.gens()[place]
                polynomial = self.context.constant(0)
                for power, row in enumerate(rows):
                    whole, rest = divmod(power, degree)
                    polynomial += row * gen**rest * value**whole
        return polynomial

    def quotient_put_in(
        self, polynomial: fmpq_mpoly, place: int, above: fmpq_mpoly, below: fmpq_mpoly
    ) -> fmpq_mpoly:
        """Substitute ``above/below`` for constant number ``place``; return the numerator."""
        rows = self.coefficients(polynomial, place)
        top = len(rows) - 1
        if top == 0:
            return polynomial
        total = self.context.constant(0)
        for power, row in enumerate(rows):
            total += row * above**power * below ** (top - power)
        return self.reduced(total)

    def remainder(self, polynomial: fmpq_mpoly, other: fmpq_mpoly, place: int) -> fmpq_mpoly:
        """Return the pseudo-remainder modulo ``other`` in constant number ``place``."""
        rows = self.coefficients(other, place)
        degree, lead, gen = len(rows) - 1, rows[-1], self.context.gens()[place]
        while (top := int(polynomial.degrees()[place])) >= degree:
            first = self.coefficients(polynomial, place)[-1]
            polynomial = self.reduced(lead * polynomial - first * gen ** (top - degree) * other)
        return polynomial


@dataclass(frozen=True)
class Rule:
    """Condition ``polynomial = 0`` that determines ``symbol``; its leading coefficient is not 0."""

    symbol: sp.Symbol
    polynomial: fmpq_mpoly


@dataclass(frozen=True)
class SystemCase:
    """Rules of one case, in triangular form; necessary, and sufficient only if ``complete``."""

    rules: tuple[Rule, ...]
    complete: bool


@dataclass(frozen=True)
class _Node:
    equations: tuple[fmpq_mpoly, ...]
    rules: tuple[Rule, ...] = ()
    nonzero: tuple[fmpq_mpoly, ...] = ()

    def adding(self, *more: fmpq_mpoly, nonzero: Iterable[fmpq_mpoly] = ()) -> _Node:
        return _Node((*more, *self.equations), self.rules, (*self.nonzero, *nonzero))


class CaseTree:
    """Real solutions of polynomial systems, solved for the symbols ``solve_for``, in that order.

    An equation without these symbols is solved for one of the ``others``.  ``left_out`` has
    conditions under which more solutions may exist, ``unknown`` relations that may hold everywhere.
    """

    def __init__(
        self,
        constants: Constants,
        solve_for: Sequence[sp.Symbol],
        others: Sequence[sp.Symbol],
        domains: Domains,
    ) -> None:
        self._constants, self._signs = constants, DomainSigns(domains)
        self._points = sample(domains, POINTS)
        self._solve_for = {constants.places[s] for s in solve_for if s in constants.places}
        symbols, self._dependent = (*solve_for, *others), dict[int, set[int]]()
        self._symbols = [constants.places[s] for s in symbols if s in constants.places]
        for place in self._symbols:
            containing = {i for i, c in enumerate(constants.all) if c.has(constants.all[place])}
            self._dependent[place] = containing - {place}
        self._nonzero: dict[str, bool] = {}
        self._steps = 0
        self.left_out: dict[str, None] = {}
        self.unknown: dict[str, None] = {}

    def branches(self, equations: Sequence[fmpq_mpoly]) -> Iterator[SystemCase]:
        """Yield the cases of a system; raises ValueError if there are too many."""
        waiting = [_Node(tuple(self._constants.reduced(e) for e in equations))]
        while waiting:
            self._steps += 1
            if self._steps > MOST_SYSTEMS:
                raise ValueError(f"the conditions are too many to be solved ({MOST_SYSTEMS} cases)")
            node = self._cleaned(waiting.pop())
            if node is None:
                continue
            step = self._next(node) if node.equations else SystemCase(node.rules, True)
            if isinstance(step, SystemCase):
                yield step
            else:
                waiting += reversed(step)

    def _cleaned(self, node: _Node) -> _Node | None:
        """Drop repeated and nonzero factors from a system; None if it has no solution."""
        products: dict[str, fmpq_mpoly] = {}
        for equation in node.equations:
            if equation.is_zero():
                continue
            product = self._constants.context.constant(1)
            for factor, _ in equation.factor()[1]:
                if factor not in node.nonzero and not self._is_nonzero(factor):
                    product *= factor
            if product.is_constant():
                return None
            products[str(product)] = product
        equations = sorted(products.values(), key=lambda e: (len(e), e.total_degree()))
        return replace(node, equations=tuple(equations))

    def _is_nonzero(self, factor: fmpq_mpoly) -> bool:
        """Return whether ``factor`` is shown to be nowhere 0 on the domains."""
        if len(factor) > SIGNED_TERMS:
            return False
        key = str(factor)
        if key not in self._nonzero:
            known = self._signs.is_nonzero(self._constants.written(factor))
            self._nonzero[key] = known or self._has_no_root(factor)
        return self._nonzero[key]

    def _has_no_root(self, factor: fmpq_mpoly) -> bool:
        """Return whether a polynomial in one function has no root in the range of that function."""
        used = self._constants.used(factor)
        function = self._constants.all[used[0]]
        values = self._signs.range(function) if len(used) == 1 else None
        if values is None or function.is_Symbol:
            return False
        name = sp.Dummy("value")
        polynomial = self._constants.written(factor).xreplace({function: name})
        return DomainSigns({name: domain_of(values)}).is_nonzero(polynomial)

    def _next(self, node: _Node) -> list[_Node] | SystemCase:
        """Return the cases after one step, or a case that needs no further step."""
        for equation in node.equations:
            factors = [factor for factor, _ in equation.factor()[1]]
            if len(factors) > 1:
                rest = self._without(node, equation)
                return [rest.adding(f, nonzero=factors[:i]) for i, f in enumerate(factors)]
        for equation in node.equations:
            terms = self._signed_terms(equation)
            if terms:
                return [self._without(node, equation).adding(*terms)]
        return self._solved(node)

    @staticmethod
    def _without(node: _Node, equation: fmpq_mpoly) -> _Node:
        return replace(node, equations=tuple(e for e in node.equations if e is not equation))

    def _signed_terms(self, equation: fmpq_mpoly) -> list[fmpq_mpoly]:
        """Return the terms of a sum if all have one sign, so that each must be 0; else []."""
        if not 1 < len(equation) <= SIGNED_TERMS:
            return []
        terms = [self._constants.context.from_dict({e: c}) for e, c in equation.terms()]
        written = [self._constants.written(term) for term in terms]
        positive = all(map(self._signs.is_nonnegative, written))
        return terms if positive or all(map(self._signs.is_nonpositive, written)) else []

    def _candidates(self, equation: fmpq_mpoly) -> list[int]:
        """Return the symbols for which an irreducible equation may be solved."""
        used = self._constants.used(equation)
        possible = [s for s in self._symbols if s in used and not self._dependent[s] & set(used)]
        return [s for s in possible if s in self._solve_for] or possible

    def _solved(self, node: _Node) -> list[_Node] | SystemCase:
        """Solve for a symbol of lowest degree, preferably with a nonzero leading coefficient."""
        choices: list[tuple[tuple[int, ...], fmpq_mpoly, int]] = []
        for equation in node.equations:
            candidates = self._candidates(equation)
            if not candidates:
                return self._unsolved(node, equation)
            for place in candidates:
                rows = self._constants.coefficients(equation, place)
                unclean = int(not (rows[-1].is_constant() or self._is_known(rows[-1], node)))
                touched, order = int(bool(self._dependent[place])), self._symbols.index(place)
                rank = (len(rows), unclean, touched, order, len(equation))
                choices.append((rank, equation, place))
        (degree, is_unclean, *_), equation, place = min(choices, key=lambda choice: choice[0])
        rows = self._constants.coefficients(equation, place)
        rest = self._without(node, equation)
        if is_unclean:
            lead = [f for f, _ in rows[-1].factor()[1]]
            tail = equation - rows[-1] * self._constants.context.gens()[place] ** (degree - 1)
            return [node.adding(nonzero=lead), rest.adding(rows[-1], tail)]
        if degree > 2:
            return self._nonlinear(node, rest, equation, place)
        rule = Rule(self._constants.all[place], equation)
        if self._dependent[place] and rest.equations:
            return SystemCase((*node.rules, rule), False)

        def put_in(polynomial: fmpq_mpoly) -> fmpq_mpoly:
            return self._constants.quotient_put_in(polynomial, place, -rows[0], rows[1])

        known = [put_in(e) for e in node.nonzero]
        if any(e.is_zero() for e in known):
            return []
        known = [f for e in known for f, _ in e.factor()[1]]
        rules = (Rule(r.symbol, put_in(r.polynomial)) for r in node.rules)
        return [_Node(tuple(map(put_in, rest.equations)), (*rules, rule), tuple(known))]

    def _is_known(self, polynomial: fmpq_mpoly, node: _Node) -> bool:
        factors = (factor for factor, _ in polynomial.factor()[1])
        return all(factor in node.nonzero or self._is_nonzero(factor) for factor in factors)

    def _nonlinear(
        self, node: _Node, rest: _Node, equation: fmpq_mpoly, place: int
    ) -> list[_Node] | SystemCase:
        """Reduce the other equations modulo ``equation``, in constant number ``place``.

        If no other equation contains that constant, ``equation`` becomes a rule."""
        others = [e for e in rest.equations if int(e.degrees()[place])]
        if others:
            reduced = [self._constants.remainder(e, equation, place) for e in others]
            free = [e for e in rest.equations if e not in others]
            return [_Node((*free, *reduced, equation), node.rules, node.nonzero)]
        rows, power = self._constants.coefficients(equation, place), 1
        if len(rows) == 5 and rows[1].is_zero() and rows[3].is_zero():
            rows, power = rows[::2], 2
        if len(rows) == 3:
            inner = self._constants.reduced(rows[1] ** 2 - 4 * rows[2] * rows[0])
            vertex = 2 * rows[2] * self._constants.context.gens()[place] ** power + rows[1]
            written = self._constants.written(inner) if 0 < len(inner) <= SIGNED_TERMS else None
            if written is not None and self._signs.is_nonpositive(written):
                return [rest.adding(inner, vertex)]
            square = self._vanishing_square(inner, node)
            if square is not None:
                return [rest.adding(square, vertex), node.adding(nonzero=[square])]
        rule = Rule(self._constants.all[place], equation)
        if self._dependent[place] and rest.equations:
            return SystemCase((*node.rules, rule), False)
        remainder = self._constants.remainder
        rules = (Rule(r.symbol, remainder(r.polynomial, equation, place)) for r in node.rules)
        nonzero = tuple(e for e in node.nonzero if not int(e.degrees()[place]))
        return [_Node(rest.equations, (*rules, rule), nonzero)]

    def _vanishing_square(self, inner: fmpq_mpoly, node: _Node) -> fmpq_mpoly | None:
        """Return a factor f whose square divides the discriminant ``inner``; None if not needed.

        The roots are real where f = 0, although ``inner`` may be negative elsewhere."""
        number, factors = inner.factor()
        odd = [factor for factor, power in factors if power % 2]
        rest = self._constants.context.constant(number)
        for factor in odd:
            rest *= factor
        if len(rest) <= SIGNED_TERMS and self._signs.is_nonnegative(self._constants.written(rest)):
            return None
        squares = (factor for factor, power in factors if power > 1)
        return next((f for f in squares if not self._is_known(f, node)), None)

    def _unsolved(self, node: _Node, equation: fmpq_mpoly) -> list[_Node]:
        """Replace an equation with roots by its norm; record one with functions in ``left_out``."""
        for place in self._constants.used(equation):
            if place in self._constants.relations and self._constants.all[place].is_Pow:
                degree, value = self._constants.relations[place]
                name = self._constants.context.names()[place]
                relation = self._constants.context.gens()[place] ** degree - value
                norm = self._constants.reduced(equation.resultant(relation, name))
                return [self._without(node, equation).adding(norm)]
        linear = self._exponents_difference(equation)
        if linear is not None:
            return [self._without(node, equation).adding(linear)]
        written = sp.factor(self._constants.written(equation))
        factors = [f for f in sp.Mul.make_args(written) if not self._signs.is_nonzero(f)]
        self.left_out[f"{formula_as_text(sp.Mul(*factors))} = 0"] = None
        if self._vanishes(equation):
            self.unknown[f"a relation of {', '.join(map(str, written.atoms(sp.Function)))}"] = None
        return []

    def _vanishes(self, equation: fmpq_mpoly) -> bool:
        """Return whether ``equation`` may be 0 everywhere: no sample point shows otherwise."""
        written = self._constants.written(equation)
        for point in self._points:
            with suppress(ValueError, ZeroDivisionError):
                if not ball_value(written, point, BITS, self._signs).contains(0):
                    return False
        return True

    def _exponents_difference(self, equation: fmpq_mpoly) -> fmpq_mpoly | None:
        """Return u - v if ``equation`` is c exp(u) - c exp(v) with real u and v; else None."""
        terms = list(equation.terms())
        used = [self._constants.all[place] for place in self._constants.used(equation)]
        if len(terms) != 2 or terms[0][1] != -terms[1][1]:
            return None
        if not all(isinstance(g, sp.exp) and self._signs.is_real(g.args[0]) for g in used):
            return None
        one, other = (dict(zip(self._constants.all, powers, strict=False)) for powers, _ in terms)
        sums = [sp.Add(*(int(powers[g]) * g.args[0] for g in used)) for powers in (one, other)]
        symbols = sorted(sums[0].free_symbols | sums[1].free_symbols, key=str)
        difference = (sums[0] - sums[1]).as_poly(*symbols)
        if difference is None or not all(c.is_Rational for c in difference.coeffs()):
            return None
        return self._constants.polynomial(terms_of(difference))
