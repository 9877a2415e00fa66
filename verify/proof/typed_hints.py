"""A proof of the statement as it was typed, where SymPy has simplified it away.

SymPy reads ``sqrt(pi**2*x**2)`` as ``pi*x`` and ``0*tanh(x)`` as 0, and a proof about that has no
step for the root and no generator for tanh.  So generators are sought for every function, power and
name of the trees, and each root, absolute value and logarithm is said to be what SymPy makes of it,
which the checker shows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import product
from operator import sub
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from longwave.derive.algebra.formula_expression import ExpressionBuilder
from longwave.derive.algebra.formula_text import Vocabulary
from longwave.derive.algebra.formula_tree import (
    MINUS_ONE,
    Call,
    Derivative,
    FormulaTree,
    Name,
    Number,
    Power,
    Product,
    Sum,
    Unknown,
    formula_text,
    mapped,
)
from longwave.verify.kernel.check import check_certificate

from .balls import ball_value
from .certificate import make_certificate
from .certificate_writer import Certificate, Data, NodeTable
from .domain_signs import is_small_polynomial
from .linear_forms import BITS
from .statement_problem import StatementProblem, all_domains, statement_problem
from .text_names import FUNCTIONS, function_named
from .text_writer import Written
from .typed_statement import Statement, StatementTrees

NO_VERDICT = (
    *(ValueError, TypeError, RecursionError, NotImplementedError, OverflowError),
    sp.PolynomialError,
)
"""Errors of a search that finds no proof; exponents past 64 bits overflow in FLINT."""

MOST = 80
"""Functions, powers and names in the trees."""

INVERSE = ("asin", "acos", "atan", "asinh", "acosh", "atanh")
KEPT = (sp.log, sp.atan)
"""Functions that may be generators as they are."""


@dataclass(frozen=True)
class Typed:
    """A part of a tree, without unknowns; what SymPy makes of it, and it as it stands."""

    tree: FormulaTree
    value: sp.Expr
    plain: sp.Expr


def typed_certificate(statement: Statement, number: int) -> Certificate:
    """Return a certificate of an equation as it was typed that the checker accepts.

    Raises one of `NO_VERDICT`, with the reason of the last search, where none is accepted.
    """
    reason: Exception = ValueError("there is no proof")
    for search in (_as_read, _as_typed, partial(_as_typed, kept=KEPT)):
        try:
            found = search(statement, number)
            check_certificate(found)
        except NO_VERDICT as error:
            reason = error
        else:
            return found
    raise reason


def _problem(statement: Statement, number: int, left: sp.Expr) -> StatementProblem:
    """Return the problem of an equation, with the texts that were typed of it."""
    texts = replace(statement.texts, equations=statement.texts.equations[number - 1 : number])
    return replace(statement_problem(statement, left), texts=texts)


def _as_read(statement: Statement, number: int) -> Certificate:
    """Return a certificate with generators for what SymPy makes of the formulas."""
    problem = _problem(statement, number, statement.equations[number - 1])
    found = make_certificate(problem)
    return found.changed(proof=with_conjugates(found["proof"], statement.complexes))


def _as_typed(statement: Statement, number: int, kept: tuple[type, ...] = ()) -> Certificate:
    """Return one with generators of the trees; functions of the types ``kept`` stay as they are."""
    statement = _with_complex_symbols(statement)
    parts = typed_parts(statement, statement.trees.equations[number - 1], kept)
    also = tuple(dict.fromkeys(e for part in parts for e in (part.plain, part.value)))
    left = statement.equations[number - 1]
    if kept or not left.atoms(AppliedUndef):
        left = next(iter(statement.solutions))  # the certificate states what was typed anyway
        also = tuple(dict.fromkeys(part.plain for part in parts))
    domains = all_domains(statement, left, *also, *vocabulary(statement).names.values())
    problem = replace(_problem(statement, number, left), domains=domains, also=also)
    found = _certificate(problem, parts, kept)
    return found.changed(proof=with_conjugates(found["proof"], statement.complexes))


def _with_complex_symbols(statement: Statement) -> Statement:
    """The statement whose complex parameters have no signs, moduli or conjugates in SymPy."""
    if not statement.complexes:
        return statement
    formulas = (*statement.equations, *statement.solutions.values(), *statement.divisors)
    symbols = {s for formula in formulas for s in formula.free_symbols} | {*statement.domains}
    new = {s: sp.Symbol(s.name) for s in symbols if s.name in statement.complexes}
    return replace(
        statement,
        equations=tuple(e.xreplace(new) for e in statement.equations),
        solutions={u: f.xreplace(new) for u, f in statement.solutions.items()},
        domains={new.get(s, s): domain for s, domain in statement.domains.items()},
        divisors=tuple(d.xreplace(new) for d in statement.divisors),
    )


def with_conjugates(proof: Data, complexes: Sequence[str]) -> Data:
    """The proof in which complex parameters, and their conjugates, are the first generators."""
    formulas, first = [*proof["formulas"]], []
    for name in complexes:
        first += [["atom", len(formulas)], ["atom", len(formulas) + 1]]
        formulas += [name, f"conjugate({name})"]
    own = [place for place, text in enumerate(formulas) if text in complexes]
    rest = [e for e in proof["generators"] if e[0] != "atom" or e[1] not in own]
    return {**proof, "formulas": formulas, "generators": [*first, *rest]}


def _certificate(
    problem: StatementProblem, parts: Sequence[Typed], kept: tuple[type, ...]
) -> Certificate:
    """The certificate with what SymPy makes of the parts; raises as `make_certificate` does."""
    equal = _equal_parts(parts, problem) if kept else {}
    found = make_certificate(problem, unsplit=kept, values=equal)
    parts = [part for part in parts if part.plain not in equal]
    return found.changed(proof=_with_values(found["proof"], parts, problem))


def typed_parts(
    statement: Statement, equation: FormulaTree, kept: tuple[type, ...] = ()
) -> list[Typed]:
    """Return `typed_nodes`, if they are few; raises ValueError for many."""
    found = [*typed_nodes(statement, equation, kept)]
    if len(found) > MOST:
        raise ValueError(f"texts must have at most {MOST} functions, got {len(found)}")
    return found


def typed_nodes(
    statement: Statement, equation: FormulaTree, kept: tuple[type, ...] = ()
) -> Iterator[Typed]:
    """The functions, powers and names in an equation with the formulas put in, and in formulas."""
    words = vocabulary(statement, kept)
    builder = ExpressionBuilder(words)

    def expression(formula: FormulaTree) -> sp.Expr:
        found = builder.expression(formula)
        return sp.expand_power_exp(found) if kept and not found.has(*kept) else found

    whole = (put_in(statement.trees, f) for f in (*statement.trees.solutions.values(), equation))
    for node in dict.fromkeys(node for formula in whole for node in formula.nodes()):
        with suppress(ValueError):  # too large for SymPy, or infinite
            plain = _plain(node, expression, words)
            if plain is not None:
                yield Typed(node, builder.expression(node), plain)


def put_in(trees: StatementTrees, formula: FormulaTree) -> FormulaTree:
    """Return the formula with what unknowns and defined names stand for in their places."""

    def image(node: FormulaTree) -> FormulaTree | None:
        if not isinstance(node, Unknown):
            return trees.meaning(node)
        found = put_in(trees, trees.solutions[node.name])
        if node.shift:
            site = Name(node.site)
            moved = Sum((site, Number(Fraction(node.shift))))
            found = mapped(found, lambda inner: moved if inner == site else None)
        return Derivative((found,), node.steps) if node.steps else found

    return mapped(formula, image)


def vocabulary(statement: Statement, kept: tuple[type, ...] = ()) -> Vocabulary:
    """Return the symbols of a statement by their names; those of which nothing is known are real.

    Functions of the types ``kept`` are not evaluated.
    """
    plain = {name: (partial(f, evaluate=False), n) for name, (f, n) in FUNCTIONS.items()}
    functions = {name: plain[name] if f[0] in kept else f for name, f in FUNCTIONS.items()}
    functions |= {name: (function_named(name), 1) for name in statement.functions}
    formulas = (*statement.equations, *statement.solutions.values(), *statement.divisors)
    symbols = {s for formula in formulas for s in formula.free_symbols}
    symbols |= {s for domain in statement.domains.values() for s in domain.symbols}
    known = {s.name: s for s in (*symbols, *statement.domains, *statement.variables)}
    variables = {s.name: s for s in statement.variables}
    real = {n: None if n in statement.complexes else True for n in statement.trees.names}
    names = {n: known.get(n, sp.Symbol(n, real=real[n])) for n in real}
    return Vocabulary(functions, variables, names=names)


def _plain(
    node: FormulaTree, expression: Callable[[FormulaTree], sp.Expr], words: Vocabulary
) -> sp.Expr | None:
    """A name, function or power as SymPy has it before it simplifies; None for anything else."""
    match node:
        case Name():
            return expression(node)
        case Call(name="sqrt", parts=(inner,)):
            return sp.Pow(expression(inner), sp.S.Half, evaluate=False)
        case Call(name=name, parts=parts):
            arguments = [*map(expression, parts)]
            if name in ("cos", "sin", "tan") and (arguments[0] / sp.pi).is_integer:
                # the checker has exponentials of i in it, and reads them as powers of -1
                return sp.I * sp.S.NegativeOne ** (arguments[0] / sp.pi)
            if name not in ("abs", "sign") or arguments != [0]:
                return words.functions[name][0](*arguments, evaluate=False)
        case Power(parts=parts):
            base, exponent = map(expression, parts)
            if not exponent.is_Rational:
                return sp.Pow(base, exponent, evaluate=False)
            if not _is_read_as_number(parts[1]):
                logarithm = sp.log(base, evaluate=False)
                return sp.exp(exponent * logarithm, evaluate=False)
            if not exponent.is_Integer or exponent < 0:
                return sp.Pow(base, exponent, evaluate=False)
    return None


def _is_read_as_number(exponent: FormulaTree) -> bool:
    """Whether the checker works the exponent out; any other power is by the logarithm there."""
    match exponent:
        case Number():
            return True
        case Product(parts=parts):
            return all(map(_is_read_as_number, parts))
        case Power(parts=(base, power)):
            return _is_read_as_number(base) and power == MINUS_ONE
    return False


def _with_values(proof: Data, typed: Sequence[Typed], problem: StatementProblem) -> Data:
    """Return the proof with what SymPy makes of each root, absolute value and logarithm.

    The factors of what is under a root show its sign.
    """
    formulas, hints = [*proof["formulas"]], {k: [*proof[k]] for k in ("values", "signs")}

    def hint(kind: str, text: str, value: str, pack: Callable[[int], Any]) -> None:
        hints[kind].append([len(formulas), pack(len(formulas) + 1)])
        formulas.extend((text, value))

    variables = [str(variable) for variable in problem.variables]
    for part in typed:
        text = formula_text(part.tree)
        match part.tree:
            case Call(name="sqrt", parts=(base,)) | Power(parts=(base, _)):
                plain = part.plain.args[0]
                if is_small_polynomial(plain) and not plain.is_Atom:
                    factors = _written(sp.factor(plain), variables)
                    hint("signs", formula_text(base), factors, lambda place: place)
        if part.value == part.plain:
            continue
        match part.tree:
            case Call(name="log"):
                hints["values"].append([len(formulas), len(formulas)])
                formulas.append(text)
            case Call(name=name) if name in ("sqrt", "abs", "lambert_w", *INVERSE):
                hint("values", text, _written(part.value, variables), lambda place: place)
    return {**proof, "formulas": formulas, **hints}


def _equal_parts(typed: Sequence[Typed], problem: StatementProblem) -> dict[sp.Expr, sp.Expr]:
    """Return values of roots, moduli and inverse functions that are equal at a point."""
    found: dict[sp.Expr, sp.Expr] = {}
    for part in typed:
        match part.plain:
            case sp.Pow(args=(sp.Pow(args=(base, 2)), sp.S.Half)) if not base.is_real:
                for value in (base, -base):
                    if _are_equal(part.plain, value, problem):
                        found[part.plain] = value
    for part, other in product(typed, typed):
        name = part.tree.name if isinstance(part.tree, Call) else ""
        is_same = isinstance(other.tree, Call) and other.tree.name == name
        known = part.plain in (*found, *found.values()) or other.plain in found
        if name not in ("sqrt", "abs", *INVERSE) or is_same or known or other.plain.is_number:
            continue
        if part.tree not in other.tree.nodes() and _are_equal(part.plain, other.plain, problem):
            found[part.plain] = other.plain
    return found


def _are_equal(left: sp.Expr, right: sp.Expr, problem: StatementProblem) -> bool:
    """Return whether two formulas have the same value at a point, as far as balls show."""
    with suppress(ValueError, ZeroDivisionError):
        values = (ball_value(side, problem.points[0], BITS) for side in (left, right))
        return bool(sub(*values).contains(0))
    return False


def _written(value: sp.Expr, variables: Sequence[str]) -> str:
    table = NodeTable()
    place = table.place(value)
    written = Written(table.nodes, [place], (), variables)
    if written.named:
        raise ValueError("values must be short, got one in which a part occurs often")
    return written.text(place)
