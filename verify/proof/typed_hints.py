"""Prove a statement as typed, including the parts that SymPy simplifies away.

SymPy reads ``sqrt(pi**2*x**2)`` as ``pi*x`` and ``0*tanh(x)`` as 0.  A proof about SymPy's form has
no step for the root and no generator for tanh.  So generators are sought for every function, power
and name of the trees.  SymPy's form of each root, absolute value and logarithm becomes a hint that
the checker must confirm.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import product
from operator import sub

import sympy as sp
from sympy.core.function import AppliedUndef

from longwave.derive.algebra import formula_tree as syntax
from longwave.derive.algebra.formula_expression import ExpressionBuilder
from longwave.derive.algebra.formula_text import Vocabulary
from longwave.derive.algebra.formula_tree import FormulaTree
from longwave.verify.kernel.check import check_certificate

from .balls import ball_value
from .certificate import make_certificate, with_conjugates
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
"""Errors that end a search without a proof; exponents above 64 bits overflow in FLINT."""

MOST_FUNCTIONS = 80
"""Most functions, powers and names in the trees."""

INVERSE = ("asin", "acos", "atan", "asinh", "acosh", "atanh")
OPAQUE = (sp.log, sp.atan)
"""Functions that may be generators without being rewritten."""


UNIT = (3 - 4 * sp.I) / 5
"""Factor that makes values of complex names nonreal where two formulas are compared."""


@dataclass(frozen=True)
class Typed:
    """Part of a tree without unknowns: SymPy's simplified ``value`` and unevaluated ``plain``."""

    tree: FormulaTree
    value: sp.Expr
    plain: sp.Expr


def typed_certificate(statement: Statement, number: int) -> Certificate:
    """Return an accepted certificate of a typed equation; raises a `NO_VERDICT` without one."""
    reason: Exception = ValueError("there is no proof")
    for search in (_as_read, _as_typed, partial(_as_typed, opaque=OPAQUE)):
        try:
            certificate = search(statement, number)
            proof = with_conjugates(certificate["proof"], statement.complexes)
            certificate = certificate.changed(proof=proof)
            check_certificate(certificate)
            return certificate
        except NO_VERDICT as error:
            reason = error
    raise reason


def _problem(statement: Statement, number: int, left: sp.Expr) -> StatementProblem:
    """Return the problem of an equation, with its typed texts."""
    texts = replace(statement.texts, equations=statement.texts.equations[number - 1 : number])
    return replace(statement_problem(statement, left), texts=texts)


def _as_read(statement: Statement, number: int) -> Certificate:
    """Return a certificate with generators for SymPy's form of the formulas."""
    return make_certificate(_problem(statement, number, statement.equations[number - 1]))


def _as_typed(statement: Statement, number: int, opaque: tuple[type, ...] = ()) -> Certificate:
    """Return a certificate with generators of the trees, without rewriting ``opaque`` functions."""
    statement = _with_complex_symbols(statement)
    parts = typed_parts(statement, statement.trees.equations[number - 1], opaque)
    also = tuple(dict.fromkeys(e for part in parts for e in (part.plain, part.value)))
    left = statement.equations[number - 1]
    if opaque or not left.atoms(AppliedUndef):
        left = next(iter(statement.solutions))  # the certificate states the typed texts in any case
        also = tuple(dict.fromkeys(part.plain for part in parts))
    domains = all_domains(statement, left, *also, *vocabulary(statement).names.values())
    problem = replace(_problem(statement, number, left), domains=domains, also=also)
    return _certificate(problem, parts, opaque)


def _with_complex_symbols(statement: Statement) -> Statement:
    """Replace complex parameters by symbols without assumptions, so that SymPy evaluates less."""
    symbols = statement.free_symbols | {*statement.domains}
    new = {s: sp.Symbol(s.name) for s in symbols if s.name in statement.complexes}
    domains = {new.get(s, s): domain for s, domain in statement.domains.items()}
    return replace(statement.with_values(new), domains=domains)


def _certificate(
    problem: StatementProblem, parts: Sequence[Typed], opaque: tuple[type, ...]
) -> Certificate:
    """Return the certificate with SymPy's values of the parts; raises as `make_certificate`."""
    equal = _equal_parts(parts, problem) if opaque else {}
    certificate = make_certificate(problem, unsplit=opaque, values=equal)
    parts = [part for part in parts if part.plain not in equal]
    return certificate.changed(proof=_with_values(certificate["proof"], parts, problem))


def typed_parts(
    statement: Statement, equation: FormulaTree, opaque: tuple[type, ...] = ()
) -> list[Typed]:
    """Return `typed_nodes` as a list; raises ValueError for more than `MOST_FUNCTIONS`."""
    nodes = [*typed_nodes(statement, equation, opaque)]
    if len(nodes) > MOST_FUNCTIONS:
        raise ValueError(f"texts must have at most {MOST_FUNCTIONS} functions, got {len(nodes)}")
    return nodes


def typed_nodes(
    statement: Statement, equation: FormulaTree, opaque: tuple[type, ...] = ()
) -> Iterator[Typed]:
    """Yield the functions, powers and names in the formulas and in the substituted equation."""
    words = vocabulary(statement, opaque)
    builder = ExpressionBuilder(words)

    def expression(formula: FormulaTree) -> sp.Expr:
        value = builder.expression(formula)
        return sp.expand_power_exp(value) if opaque and not value.has(*opaque) else value

    whole = (put_in(statement.trees, f) for f in (*statement.trees.solutions.values(), equation))
    for node in dict.fromkeys(node for formula in whole for node in formula.nodes()):
        with suppress(ValueError):  # too large for SymPy, or infinite
            plain = _plain(node, expression, words)
            if plain is not None:
                yield Typed(node, builder.expression(node), plain)


def put_in(trees: StatementTrees, formula: FormulaTree) -> FormulaTree:
    """Replace unknowns and defined names in a formula by their formulas."""

    def image(node: FormulaTree) -> FormulaTree | None:
        if not isinstance(node, syntax.Unknown):
            return trees.meaning(node)
        result = put_in(trees, trees.solutions[node.name])
        if node.shift:
            site = syntax.Name(node.site)
            moved = syntax.Sum((site, syntax.Number(Fraction(node.shift))))
            result = syntax.mapped(result, lambda inner: moved if inner == site else None)
        return syntax.Derivative((result,), node.steps) if node.steps else result

    return syntax.mapped(formula, image)


def vocabulary(statement: Statement, opaque: tuple[type, ...] = ()) -> Vocabulary:
    """Return a statement's symbols, real by default; ``opaque`` functions stay unevaluated."""
    plain = {name: (partial(f, evaluate=False), n) for name, (f, n) in FUNCTIONS.items()}
    functions = {name: plain[name] if f[0] in opaque else f for name, f in FUNCTIONS.items()}
    functions |= {name: (function_named(name), 1) for name in statement.functions}
    symbols = statement.free_symbols | statement.domain_symbols
    known = {s.name: s for s in (*symbols, *statement.domains, *statement.variables)}
    variables = {s.name: s for s in statement.variables}
    real = {n: None if n in statement.complexes else True for n in statement.trees.names}
    names = {n: known.get(n, sp.Symbol(n, real=real[n])) for n in real}
    return Vocabulary(functions, variables, names=names)


def _plain(
    node: FormulaTree, expression: Callable[[FormulaTree], sp.Expr], words: Vocabulary
) -> sp.Expr | None:
    """Return a name, function or power unevaluated in SymPy; None for anything else."""
    match node:
        case syntax.Name():
            return expression(node)
        case syntax.Call(name="sqrt", parts=(inner,)):
            return sp.Pow(expression(inner), sp.S.Half, evaluate=False)
        case syntax.Call(name=name, parts=parts):
            arguments = [*map(expression, parts)]
            if name in ("cos", "sin", "tan") and (arguments[0] / sp.pi).is_integer:
                # the checker writes it in exponentials of i, and reads these as powers of -1
                return sp.I * sp.S.NegativeOne ** (arguments[0] / sp.pi)
            if name not in ("abs", "sign") or arguments != [0]:
                return words.functions[name][0](*arguments, evaluate=False)
        case syntax.Power(parts=parts):
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
    """Return whether the checker reads an exponent as a number; others use the logarithm."""
    match exponent:
        case syntax.Number():
            return True
        case syntax.Product(parts=parts):
            return all(map(_is_read_as_number, parts))
        case syntax.Power(parts=(base, power)):
            return _is_read_as_number(base) and power == syntax.MINUS_ONE
    return False


def _with_values(proof: Data, typed: Sequence[Typed], problem: StatementProblem) -> Data:
    """Add SymPy's values of roots, moduli and logarithms, and factored radicands, as hints."""
    formulas, hints = [*proof["formulas"]], {k: [*proof[k]] for k in ("values", "signs")}

    def hint(kind: str, text: str, value: str) -> None:
        hints[kind].append([len(formulas), len(formulas) + 1])
        formulas.extend((text, value))

    variables = [str(variable) for variable in problem.variables]
    for part in typed:
        text = syntax.formula_text(part.tree)
        match part.tree:
            case syntax.Call(name="sqrt", parts=(base,)) | syntax.Power(parts=(base, _)):
                plain = part.plain.args[0]
                if is_small_polynomial(plain) and not plain.is_Atom:
                    factors = _written(sp.factor(plain), variables)
                    hint("signs", syntax.formula_text(base), factors)
        if part.value == part.plain:
            continue
        match part.tree:
            case syntax.Call(name="log"):
                hints["values"].append([len(formulas), len(formulas)])
                formulas.append(text)
            case syntax.Call(name=name) if name in ("sqrt", "abs", "lambert_w", *INVERSE):
                hint("values", text, _written(part.value, variables))
    return {**proof, "formulas": formulas, **hints}


def _equal_parts(typed: Sequence[Typed], problem: StatementProblem) -> dict[sp.Expr, sp.Expr]:
    """Map roots, moduli and inverse functions to other forms with the same value at a point."""
    values: dict[sp.Expr, sp.Expr] = {}
    for part in typed:
        match part.plain:
            case sp.Pow(args=(sp.Pow(args=(base, 2)), sp.S.Half)) if not base.is_real:
                for value in (base, -base):
                    if _are_equal(part.plain, value, problem):
                        values[part.plain] = value
    for part, other in product(typed, typed):
        name = part.tree.name if isinstance(part.tree, syntax.Call) else ""
        is_same = isinstance(other.tree, syntax.Call) and other.tree.name == name
        known = part.plain in (*values, *values.values()) or other.plain in values
        if name not in ("sqrt", "abs", *INVERSE) or is_same or known or other.plain.is_number:
            continue
        if part.tree not in other.tree.nodes() and _are_equal(part.plain, other.plain, problem):
            values[part.plain] = other.plain
    return values


def _are_equal(left: sp.Expr, right: sp.Expr, problem: StatementProblem) -> bool:
    """Return whether the balls of two formulas at a point overlap; complex names are not real."""
    turned = {s: UNIT * s for s in problem.points[0] if not s.is_real}
    with suppress(ValueError, ZeroDivisionError):
        sides = (side.xreplace(turned) for side in (left, right))
        values = (ball_value(side, problem.points[0], BITS) for side in sides)
        return bool(sub(*values).contains(0))
    return False


def _written(value: sp.Expr, variables: Sequence[str]) -> str:
    table = NodeTable()
    place = table.place(value)
    written = Written(table.nodes, [place], (), variables)
    if written.named:
        raise ValueError("values must be short, got one in which a part occurs often")
    return written.text(place)
