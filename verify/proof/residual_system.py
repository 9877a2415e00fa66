"""Reduce the residual of a statement to polynomials in constants, one per independent function.

The prover's field writes the residual as a fraction of polynomials in generators.  The moving ones
contain a variable, the others are constants.  If the moving ones are independent over the real
constants, the numerator's coefficients in them and in the imaginary unit vanish wherever the
statement holds.  Independence is known (J. Ax, Ann. of Math. 93, 1971; Amer. J. Math. 94, 1972) for
the variables, for exponentials of arguments that are independent over the rationals modulo
constants, and for the Jacobi functions of one argument that is not constant.  The conditions under
which an argument becomes constant or a denominator 0 form separate systems.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations
from math import gcd

import sympy as sp
from flint import fmpq, fmpq_mpoly

from longwave.solutions.functions.jacobi import JacobiFunction
from longwave.solutions.functions.jet_functions import jet_function
from longwave.verify.kernel.check import opened, registered
from longwave.verify.kernel.field import Field, Generator
from longwave.verify.kernel.ring import Element

from .arguments import Dependence, expanded_terms
from .certificate import make_certificate
from .certificate_writer import FUNCTIONS
from .constant_terms import Monomial, Relations, Terms, is_turn, real_parts
from .domain_signs import DomainSigns
from .factors import rational
from .problem import Problem

Vector = dict[tuple[sp.Expr, bool], sp.Expr]
"""Constant coefficients by (monomial in the variables, whether it is the imaginary part)."""


@dataclass
class ResidualSystem:
    """Conditions for a statement to hold, valid as far as its generators are independent.

    ``polynomials`` in constants must vanish; ``relations`` has powers of algebraic constants.
    Generators may be dependent, or a denominator 0, where all entries of a list in ``degenerate``
    vanish.  ``left_out`` has conditions under which more solutions are not excluded, ``unknown``
    generators not known to be independent.
    """

    polynomials: list[Terms] = field(default_factory=list)
    relations: Relations = field(default_factory=dict)
    degenerate: list[list[Terms | sp.Expr]] = field(default_factory=list)
    left_out: dict[str, None] = field(default_factory=dict)
    unknown: dict[str, None] = field(default_factory=dict)

    def add(self, problem: Problem) -> None:
        """Add the conditions of an equality; raises ValueError if it has no image in a field."""
        _Coefficients(problem, self).collect()

    def judge_phase(self, rest: sp.Expr, variables: Sequence[sp.Symbol]) -> None:
        """Record when the replacement of ``rest`` plus a constant by a variable loses cases.

        It does where ``rest`` is constant or has finitely many values up to periods."""
        vector = argument_vector(rest, Dependence(variables))
        if rest == 0:
            return
        if vector is None:
            self.unknown[str(rest)[:SHOWN_LENGTH]] = None
        elif all(v.is_integer for v, _ in vector):
            self.left_out[f"{rest} takes finitely many values up to periods"] = None
        else:
            self.degenerate.append([c for (v, _), c in vector.items() if not v.is_integer])


class _Coefficients:
    """Coefficients of one residual, and the independence of its generators."""

    def __init__(self, problem: Problem, system: ResidualSystem) -> None:
        certificate = make_certificate(problem)
        stated = opened(certificate)
        self._field = registered(stated, certificate["proof"])
        self._field.walk(stated.formulas)
        self._image: Element = self._field.image(stated.formulas[0])
        self._system, self._variables = system, problem.variables
        self._dependence = Dependence(problem.variables)
        self._signs = DomainSigns(problem.domains)
        symbols = {symbol.name: symbol for symbol in (*problem.domains, *problem.variables)}
        self._meanings = GeneratorFormulas(self._field, symbols, self._dependence)

    def collect(self) -> None:
        groups = self._by_moving(self._image.numerator)
        phases = self._phases(groups)
        self._system.polynomials += [p for part in groups.values() for p in real_parts(part)]
        self._relate()
        self._relate_turns(groups.values())
        factors = [self._by_moving(factor) for factor in self._field.ring.factors]
        present = {g for moving in groups for g, _ in moving} - phases.keys()
        sums = [parts for parts in factors if len(parts) > 1]
        self._judge(present | {g for parts in sums for moving in parts for g, _ in moving})
        self._judge_exponentials([groups, *sums])
        for parts in factors:
            entries = [p for part in parts.values() for p in real_parts(part)]
            if not any(list(entry) == [()] for entry in entries):
                self._system.degenerate.append(list(entries))
        for constant in {g for part in groups.values() for key in part for g, _ in key}:
            if constant is not sp.I and not is_turn(constant) and not self._signs.is_real(constant):
                self._system.unknown[f"{str(constant)[:SHOWN_LENGTH]} may not be real"] = None

    def _split(self, exponents: Sequence[int]) -> tuple[Monomial, Monomial]:
        """Split a monomial into its moving and its constant part."""
        moving, constant = dict[sp.Expr, int](), dict[sp.Expr, int]()
        for place, power in enumerate(reversed(exponents)):
            if power:
                meaning = self._meanings[place]
                part = moving if self._dependence.depends(meaning) else constant
                part[meaning] = part.get(meaning, 0) + int(power)
        return tuple(moving.items()), tuple(constant.items())

    def _by_moving(self, polynomial: fmpq_mpoly) -> dict[Monomial, Terms]:
        """Return the coefficients, in constants, of a polynomial in the moving generators."""
        parts: defaultdict[Monomial, dict[Monomial, fmpq]] = defaultdict(dict)
        for exponents, c in polynomial.terms():
            moving, constant = self._split(exponents)
            parts[moving][constant] = parts[moving].get(constant, fmpq(0)) + c
        return dict(parts)

    @staticmethod
    def _phases(monomials: Iterable[Monomial]) -> dict[sp.Expr, int]:
        """Return the generators with the same power in all monomials, which can be divided out."""
        rows = [dict(monomial) for monomial in monomials]
        first = rows[0] if rows else {}
        return {g: n for g, n in first.items() if all(row.get(g) == n for row in rows)}

    def _relate(self) -> None:
        """Record in the system the relations of the algebraic constants among the generators."""
        ring, count = self._field.ring, len(self._field.generators)
        for index, degree, modulus in ring.relations:
            meaning = self._meanings[count - 1 - index]
            if meaning is not sp.I and not self._dependence.depends(meaning):
                value = self._by_moving(ring.context.gens()[index] ** degree - modulus)
                self._system.relations[meaning] = (degree, value.get((), {}))

    def _relate_turns(self, polynomials: Iterable[Terms]) -> None:
        """Record sin**2 = 1 - cos**2 for the sines that replace complex exponentials."""
        constants = {g for terms in polynomials for monomial in terms for g, _ in monomial}
        for constant in filter(is_turn, constants):
            angle = constant.args[0].as_real_imag()[1]
            (sine,), (cosine,) = sp.sin(angle).atoms(sp.sin), sp.cos(angle).atoms(sp.cos)
            square: Terms = {(): fmpq(1), ((cosine, 2),): fmpq(-1)}
            self._system.relations[sine] = (2, square)

    def _judge(self, present: set[sp.Expr]) -> None:
        """Record moving generators not known to be independent, and conditions of dependence."""
        triples = dict[sp.Expr, dict[sp.Expr, None]]()
        for generator in sorted(present - {sp.I, *self._variables}, key=sp.default_sort_key):
            if isinstance(generator, sp.exp):
                self._judge_exponent(generator.args[0])
            elif isinstance(generator, JacobiFunction) and generator.func.__name__ in INDEPENDENT:
                z, m = generator.args
                triples.setdefault(m, {})[z] = None
            elif generator in self._meanings.forms:
                self._judge_form(generator, present)
            else:
                self._system.unknown[str(generator)[:SHOWN_LENGTH]] = None
        if len(triples) > 1:
            self._system.unknown["elliptic functions of several parameters"] = None
        for m, arguments in triples.items():
            self._judge_elliptic(m, list(arguments))
        for place in range(len(self._field.generators)):
            if self._meanings[place] in present:
                self._system.degenerate += [[entry] for entry in self._meanings.scale(place)]

    def _judge_form(self, form: sp.Expr, present: set[sp.Expr]) -> None:
        """Record when a linear form depends on other generators, or that this is not known."""
        others = [g for g in present if g in self._meanings.forms and g != form]
        vector = argument_vector(form, self._dependence)
        rest = [c for (v, _), c in vector.items() if v not in present] if vector else []
        if others or not rest:
            self._system.unknown[str(form)[:SHOWN_LENGTH]] = None
        else:
            self._system.degenerate.append(list(rest))

    def _judge_exponent(self, exponent: sp.Expr) -> None:
        vector = argument_vector(exponent, self._dependence)
        if vector is None:
            self._system.unknown[str(sp.exp(exponent))[:SHOWN_LENGTH]] = None
        elif any(is_imaginary and v.is_integer for v, is_imaginary in vector):
            words = f"{sp.expand(exponent / sp.I)} takes finitely many values up to periods"
            self._system.left_out[words] = None

    def _judge_exponentials(self, polynomials: Iterable[Iterable[Monomial]]) -> None:
        """Record when products of exponentials depend: if their exponents differ by a constant."""
        directions: dict[frozenset[tuple[sp.Expr, int]], None] = {}
        for monomials in polynomials:
            rows: defaultdict[Monomial, list[Counter[sp.Expr]]] = defaultdict(list)
            for monomial in monomials:
                powers = Counter({g: n for g, n in monomial if isinstance(g, sp.exp)})
                rows[tuple(pair for pair in monomial if pair[0] not in powers)].append(powers)
            for row in rows.values():
                for one, other in combinations(row, 2):
                    directions[_direction(one, other)] = None
        if len(directions) > MOST_DIRECTIONS:
            self._system.left_out["exponents have a rational ratio"] = None
            directions = {frozenset({(g, 1)}): None for d in directions for g, _ in d}
        for direction in directions:
            total: Vector = {}
            for g, n in direction:
                for key, value in (argument_vector(g.args[0], self._dependence) or {}).items():
                    total[key] = total.get(key, sp.S.Zero) + n * value
            self._system.degenerate.append([sp.expand(value) for value in total.values()])

    def _judge_together(self, vectors: Sequence[Vector], listed: str) -> None:
        """Record the minors of the matrix of ``vectors``; a nonzero one makes them independent."""
        columns = list(dict.fromkeys(key for vector in vectors for key in vector))
        if len(vectors) < 2:
            return
        minors: list[Terms | sp.Expr] = []
        if len(vectors) <= LARGEST_MINOR:
            table = sp.Matrix([[vector.get(key, 0) for key in columns] for vector in vectors])
            chosen = combinations(range(len(columns)), len(vectors))
            minors = [sp.expand(table[:, list(place)].det()) for place in chosen]
        if any(minors):
            self._system.degenerate.append(minors)
        else:
            self._system.left_out[f"a combination of {listed} with integers is constant"] = None

    def _judge_elliptic(self, m: sp.Expr, arguments: Sequence[sp.Expr]) -> None:
        vectors = [argument_vector(z, self._dependence) for z in arguments]
        for z, vector in zip(arguments, vectors, strict=True):
            if vector is None or any(is_imaginary for _, is_imaginary in vector):
                self._system.unknown[f"elliptic functions of {z}"] = None
                continue
            self._system.degenerate.append(list(vector.values()))
            if all(v.is_integer for v, _ in vector):
                self._system.left_out[f"{z} takes finitely many values up to periods"] = None
        self._judge_together([v for v in vectors if v], ", ".join(map(str, arguments)))
        self._system.degenerate += [[m], [1 - m]]


def _direction(one: Counter[sp.Expr], other: Counter[sp.Expr]) -> frozenset[tuple[sp.Expr, int]]:
    """Return the exponents' difference of two products of exponentials, up to factor and sign."""
    table = {g: one[g] - other[g] for g in one | other if one[g] != other[g]}
    first = min(table, key=sp.default_sort_key)
    scale = gcd(*table.values()) * (1 if table[first] > 0 else -1)
    return frozenset((g, n // scale) for g, n in table.items())


def argument_vector(argument: sp.Expr, dependence: Dependence) -> Vector | None:
    """Return the coefficients of a polynomial by (monomial, is imaginary); None for other terms.

    >>> x, a, b = sp.symbols("x a b")
    >>> argument_vector((a + sp.I * b) * x, Dependence([x]))
    {(x, False): a, (x, True): b}
    """
    vector: Vector = {}
    for term, number in expanded_terms(argument).items():
        constant, moving = dependence.factors(number * term)
        if moving == 1:
            continue
        powers = [factor.as_base_exp() for factor in sp.Mul.make_args(moving)]
        if not all(b in dependence.variables and n.is_Integer for b, n in powers):
            return None
        real, imaginary = constant.coeff(sp.I, 0), constant.coeff(sp.I, 1)
        for value, side in ((real, False), (imaginary, True)):
            if value != 0:
                vector[moving, side] = vector.get((moving, side), sp.S.Zero) + value
    return vector


INDEPENDENT = ("jacobi_sn", "jacobi_cn", "jacobi_dn", "jacobi_epsilon", "jacobi_zeta")

MOST_DIRECTIONS = 60
"""Most differences of exponents examined; two solitons have about 15."""

LARGEST_MINOR = 3
"""Most arguments whose independence is decided by minors."""

SHOWN_LENGTH = 60
"""Most characters of a function that a message shows."""


class GeneratorFormulas:
    """SymPy expressions of a field's generators; ``forms`` has those that are linear forms."""

    def __init__(
        self, field: Field, symbols: Mapping[str, sp.Symbol], dependence: Dependence
    ) -> None:
        self._field, self._symbols, self._dependence = field, symbols, dependence
        self._nodes: dict[int, sp.Expr] = {}
        self.forms: set[sp.Expr] = set()

    def __getitem__(self, place: int) -> sp.Expr:
        """Return the expression of a generator; for a moving one, without its scale."""
        return self._all[place]

    @cached_property
    def _all(self) -> list[sp.Expr]:
        return [self._meaning(generator) for generator in self._field.generators]

    def _meaning(self, generator: Generator) -> sp.Expr:
        formula = self._node(generator.formula)
        if self._is_form(generator):
            self.forms.add(formula)
            return formula
        node = self._node(generator.form[0][1]) if generator.form else formula
        if self._dependence.depends(node):
            return node
        return formula * self._polynomial(generator.scale)

    def _is_form(self, generator: Generator) -> bool:
        """Return whether a generator is a linear form and not a multiple of one function."""
        pairs = generator.form
        known = (self._field.nodes.product(*pairs[0]), pairs[0][1]) if len(pairs) == 1 else ()
        return bool(pairs) and generator.formula not in known

    def scale(self, place: int) -> Iterator[sp.Expr]:
        """Yield the non-numeric factor by which a generator is a multiple of a function."""
        generator = self._field.generators[place]
        if generator.form and not self._is_form(generator):
            factor = self._node(generator.form[0][0]) * self._polynomial(generator.scale)
            if not factor.is_number:
                yield factor

    def _polynomial(self, polynomial: fmpq_mpoly) -> sp.Expr:
        """Return a polynomial in earlier generators as an expression."""
        terms = []
        for exponents, c in polynomial.terms():
            powers = enumerate(reversed(exponents))
            factors = (self._meaning(self._field.generators[i]) ** int(n) for i, n in powers if n)
            terms.append(sp.Mul(rational(c), *factors))
        return sp.Add(*terms)

    def _node(self, node: int) -> sp.Expr:
        if node not in self._nodes:
            self._nodes[node] = self._written(*self._field.nodes.all[node])
        return self._nodes[node]

    def _written(self, name: str, *arguments: object) -> sp.Expr:
        match name, arguments:
            case "symbol", (str(label), _):
                return self._symbols[label]
            case "number", (fmpq() as value,):
                return rational(value)
            case "I", _:
                return sp.I
            case "pi", _:
                return sp.pi
            case "Pow", (int(base), fmpq() as power):
                return sp.Pow(self._node(base), rational(power))
            case "poly", (terms, *places):
                values = [self._node(place) for place in places]  # type: ignore[arg-type]
                products = ((c, zip(values, powers, strict=True)) for c, powers in terms)  # type: ignore[attr-defined]
                return sp.Add(*(rational(c) * sp.Mul(*(v**n for v, n in p)) for c, p in products))
            case "parity", (int(exponent),):
                return sp.S.NegativeOne ** self._node(exponent)
            case (("jet" | "theta"), (*places, (str(label), int(order)))):
                values = [self._node(place) for place in places]  # type: ignore[arg-type]
                return jet_function(label, order)(*values)
        return FUNCTIONS[name](*map(self._node, arguments))  # type: ignore[arg-type]
