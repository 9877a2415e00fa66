"""Find the intended meaning of a refuted statement: the first single change that is proved.

The changes exchange modulus and parameter of elliptic functions, or give another sign, factor,
exponent or shift to a part of a formula, definition or equation.  A change that leaves no residual
at the point of the refutation is decided as a statement of its own.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial

from longwave.derive.algebra import formula_tree as syntax
from longwave.derive.algebra.formula_text import CONSTANTS, FormulaError
from longwave.derive.algebra.formula_tree import FormulaTree
from longwave.verify.verdict import Outcome

from .domain_signs import JUMP
from .domains import Domains
from .seams import left_open
from .statement_problem import typed_domains
from .statement_text import read_statement
from .statement_verdict import StatementVerdict, decide_statement, witness_trees
from .text_names import CONTINUOUS, SITE
from .typed_statement import Statement, StatementTexts, StatementTrees, names_in
from .typed_values import TypedValues

SIGNS, EXPONENTS, HALVES, OTHERS = range(4)
"""Ranks of changes in the order of trial: signs, exponents or shifts, factors 2 or 1/2, others."""

FACTORS = {
    **{Fraction(text): HALVES for text in ("2", "1/2")},
    **{Fraction(text): OTHERS for text in ("4", "1/4", "3", "1/3", "3/2", "2/3", "6", "1/6")},
}

HALF = Fraction(1, 2)

QUICK = (64,)
"""Precisions in bits at which a change is tested before it is decided."""

Change = tuple[int, FormulaTree]
"""Rank of a change in the order of trial (such as `SIGNS`), and the changed formula."""


@dataclass(frozen=True)
class NearMiss:
    """Statement with one ``change``, in words; ``text`` is the changed equation or formula."""

    change: str
    text: str
    texts: StatementTexts
    trees: StatementTrees

    def statement(self, name: str) -> Statement:
        """Parse the changed texts; raises FormulaError if they are not a statement."""
        texts = self.texts
        named = "" if {*texts.variables} <= {*CONTINUOUS, SITE} else ", ".join(texts.variables)
        limits = "; ".join(texts.parameters), "; ".join(texts.domain)
        return read_statement(texts.equations, texts.solutions, *limits, name=name, variables=named)

    def hint(self, verdict: StatementVerdict, proof: StatementVerdict) -> StatementVerdict:
        """Return the refutation ``verdict`` with this change, proved by ``proof``, as hint."""
        only = f", {proof.restriction}" if proof.restriction else ""
        places = f" ({'; '.join(proof.nonsmooth_lines)})" if proof.nonsmooth_lines else ""
        words = f"it holds with {self.change}{only}{places}: {self.text}"
        return replace(verdict, hint=words, hint_verdict=proof)


def with_hint(statement: Statement, verdict: StatementVerdict) -> StatementVerdict:
    """Return the verdict; a refutation gets a hint if a change of the statement is proved.

    >>> from longwave.verify.proof.statement_text import read_statement
    >>> wrong = read_statement("u_t + u_x", "u = exp(x + t)")
    >>> with_hint(wrong, decide_statement(wrong)).hint
    'it holds with -t in the place of t: u = exp(x - t)'
    """
    if verdict.outcome is not Outcome.REFUTED or statement.solve_for:
        return verdict
    witness = _Witness(statement, typed_domains(statement), verdict.witness or {})
    for miss in near_misses(statement):
        if not (witness.leaves_nothing(miss.trees) and _is_as_strong(witness, miss.trees)):
            continue
        with suppress(FormulaError):
            changed = miss.statement(statement.name)
            proof = decide_statement(changed)
            if proof.outcome is Outcome.PROVED and _jumps(changed) <= _jumps(statement):
                return miss.hint(verdict, proof)
    return verdict


def _jumps(statement: Statement) -> int:
    """Return the number of places at which the statement's formulas may jump or have corners."""
    places, lines = left_open(statement)
    return len(places) + sum(line.startswith(JUMP) for line in lines)


@dataclass(frozen=True)
class _Witness:
    """Point of a refutation, and the domains of the statement."""

    statement: Statement
    domains: Domains
    witness: Mapping[str, str]

    def leaves_nothing(self, trees: StatementTrees) -> bool:
        """Return whether all residuals of ``trees`` vanish at the point, to `QUICK` precision."""
        trees, point = witness_trees(self.statement, trees, self.witness)
        return TypedValues(trees, self.domains).fails_at(point, QUICK) is False


def _is_as_strong(witness: _Witness, trees: StatementTrees) -> bool:
    """Return whether ``trees`` keep every variable of the formulas and no equation always holds."""
    letters = [syntax.Name(name) for name in trees.variables]
    terms = [syntax.Product((syntax.Number(Fraction(1, i + 3)), v)) for i, v in enumerate(letters)]
    terms.append(syntax.Product((*letters, *letters)))
    sums = (syntax.Sum((syntax.Number(Fraction(i, 7)), *terms)) for i in itertools.count())
    others = {name: syntax.Call((next(sums),), "exp") for name in trees.solutions}
    arbitrary = (replace(trees, equations=(e,), solutions=others) for e in trees.equations)
    if any(map(witness.leaves_nothing, arbitrary)):
        return False
    for slope in (_slope(name, v) for name in trees.solutions for v in trees.variables):
        typed = replace(witness.statement.trees, equations=(slope,))
        lost = witness.leaves_nothing(replace(trees, equations=(slope,)))
        if lost and not witness.leaves_nothing(typed):
            return False
    return True


def _slope(unknown: str, variable: str) -> FormulaTree:
    """Return the derivative of an unknown, or its difference from site to site."""
    if variable != SITE:
        return syntax.Unknown(unknown, (variable,))
    here, there = syntax.Unknown(unknown, (), SITE), syntax.Unknown(unknown, (), SITE, 1)
    return syntax.Sum((there, syntax.Product((syntax.MINUS_ONE, here))))


def near_misses(statement: Statement) -> list[NearMiss]:
    """Return all statements with one change, without repeats, in the order of their trial.

    >>> from longwave.verify.proof.statement_text import read_statement
    >>> wrong = read_statement("u_x - 1", "u = jacobi_sn(x, m)")
    >>> near_misses(wrong)[0].change
    'm**2 in the place of m as the parameter of elliptic functions'
    """
    misses: dict[tuple[str, ...], tuple[int, NearMiss]] = {}
    for rank, miss in _near_misses(statement.texts, statement.trees):
        key = (*miss.texts.equations, *miss.texts.solutions, *miss.texts.parameters)
        misses.setdefault(key, (rank, miss))
    return [miss for _, miss in sorted(misses.values(), key=lambda pair: pair[0])]


def _near_misses(texts: StatementTexts, trees: StatementTrees) -> Iterator[tuple[int, NearMiss]]:
    """Yield the rank and changed statement for each change of a formula or an equation."""
    headings = [text.partition("=")[0].strip() for text in texts.solutions]
    for place, (name, formula) in enumerate(trees.solutions.items()):
        for rank, words, new in _changes(formula):
            text = f"{headings[place]} = {syntax.plain_text(new)}"
            changed = replace(texts, solutions=_put(texts.solutions, place, text))
            changed_trees = replace(trees, solutions={**trees.solutions, name: new})
            yield rank, NearMiss(words, text, changed, changed_trees)
    headings = [text.partition("=")[0].strip() for text in texts.parameters]
    for name, formula in trees.definitions.items():
        for rank, words, new in _changes(formula):
            text = f"{name} = {syntax.plain_text(new)}"
            parameters = _put(texts.parameters, headings.index(name), text)
            changed = replace(texts, parameters=parameters)
            changed_trees = replace(trees, definitions={**trees.definitions, name: new})
            yield rank, NearMiss(words, text, changed, changed_trees)
    for place, equation in enumerate(trees.equations):
        for rank, words, new in _changes(equation):
            text = syntax.plain_text(new)
            changed = replace(texts, equations=_put(texts.equations, place, text))
            equations = (*trees.equations[:place], new, *trees.equations[place + 1 :])
            changed_trees = replace(trees, equations=equations)
            yield rank, NearMiss(f"{words} in the equation", f"{text} = 0", changed, changed_trees)


def _put(texts: tuple[str, ...], place: int, text: str) -> tuple[str, ...]:
    return (*texts[:place], text, *texts[place + 1 :])


def _changes(formula: FormulaTree) -> Iterator[tuple[int, str, FormulaTree]]:
    """Yield the rank, the words and the resulting formula of each single change."""
    names = names_in(formula)
    for words, changed in _moduli(formula):
        yield -1, words, changed
    for rank, changed in itertools.chain(_in_one_place(formula), _everywhere(formula)):
        if names_in(changed) == names:
            old, new = _difference(formula, changed)
            yield rank, _instead(new, old), changed


def _instead(new: FormulaTree, old: FormulaTree) -> str:
    return f"{syntax.plain_text(new)} in the place of {syntax.plain_text(old)}"


def _difference(old: FormulaTree, new: FormulaTree) -> tuple[FormulaTree, FormulaTree]:
    """Return the smallest terms or arguments of both formulas that contain all differences."""
    if not old.inner() or len(old.inner()) != len(new.inner()) or old.made_of(new.inner()) != new:
        return old, new
    pairs = [pair for pair in zip(old.inner(), new.inner(), strict=True) if pair[0] != pair[1]]
    if len(pairs) != 1:
        return old, new
    difference = _difference(*pairs[0])
    is_part = isinstance(old, syntax.Sum | syntax.Call | syntax.Derivative)
    return difference if is_part or difference != pairs[0] else (old, new)


def _moduli(formula: FormulaTree) -> Iterator[tuple[str, FormulaTree]]:
    """Yield the formula with an elliptic parameter m as m**2 or sqrt(m), after words for it."""

    def is_elliptic(node: FormulaTree) -> bool:
        return isinstance(node, syntax.Call) and node.name.startswith(("jacobi_", "elliptic_"))

    def image(old: FormulaTree, new: FormulaTree, node: FormulaTree) -> FormulaTree | None:
        if not is_elliptic(node):
            return None
        *others, m = (syntax.mapped(part, partial(image, old, new)) for part in node.inner())
        return node.made_of((*others, new if m == old else m))

    for old in dict.fromkeys(f.inner()[-1] for f in formula.nodes() if is_elliptic(f)):
        squared = isinstance(old, syntax.Power) and syntax.rational(old.parts[1]) == 2
        for new in (_power(old, Fraction(2)), old.inner()[0] if squared else _power(old, HALF)):
            words = f"{_instead(new, old)} as the parameter of elliptic functions"
            if names_in(old):
                yield words, syntax.mapped(formula, partial(image, old, new))


def _everywhere(formula: FormulaTree) -> Iterator[Change]:
    """Yield the formula with one name changed wherever it occurs."""
    for name in map(syntax.Name, sorted(names_in(formula) - CONSTANTS.keys())):
        factors = [(rank, _times(factor, name)) for factor, rank in FACTORS.items()]
        for rank, new in ((SIGNS, _times(Fraction(-1), name)), *_powers(name), *factors):
            yield max(rank, HALVES), _replaced(formula, name, new)


def _replaced(formula: FormulaTree, old: FormulaTree, new: FormulaTree) -> FormulaTree:
    if formula == old:
        return new
    parts = tuple(_replaced(part, old, new) for part in formula.inner())
    return formula if parts == formula.inner() else _made_of(formula, parts)


def _made_of(formula: FormulaTree, parts: tuple[FormulaTree, ...]) -> FormulaTree:
    """Return the formula with other parts; flatten products and collect their numbers."""
    result = formula.made_of(parts)
    changed = (part for part, old in zip(parts, formula.inner(), strict=True) if part != old)
    if isinstance(result, syntax.Product) and any(
        isinstance(part, syntax.Number | syntax.Product) for part in changed
    ):
        return _times(Fraction(1), result)
    return result


def _in_one_place(formula: FormulaTree) -> Iterator[Change]:
    """Yield the formula with one change, of itself or of one of its parts."""
    parameters = sorted(names_in(formula) - {*CONSTANTS, *CONTINUOUS, SITE})
    parameters = [n for n in parameters if syntax.Name(n) in formula.nodes()]
    yield from _of_term(formula, parameters)
    for node, put in _places(formula):
        for rank, new in _of_node(node, parameters):
            yield rank, put(new)


Put = Callable[[FormulaTree], FormulaTree]
"""Function that returns the whole formula with one part replaced."""


def _places(formula: FormulaTree) -> Iterator[tuple[FormulaTree, Put]]:
    """Yield the parts of a formula, outer ones first, each with its replacement function."""
    yield formula, lambda new: new
    parts = formula.inner()
    for place, part in enumerate(parts):
        for node, put in _places(part):

            def outer(new: FormulaTree, place: int = place, put: Put = put) -> FormulaTree:
                return _made_of(formula, (*parts[:place], put(new), *parts[place + 1 :]))

            yield node, outer


def _of_node(node: FormulaTree, parameters: Iterable[str]) -> Iterator[Change]:
    """Yield a node with one change of a term, factor, exponent, argument or shift."""
    match node:
        case syntax.Sum(parts=parts):
            for place, part in reversed([*enumerate(parts)]):  # the first term is rarely wrong
                for rank, new in (*_of_term(part, parameters), *_shifted(part)):
                    yield rank, syntax.Sum((*parts[:place], new, *parts[place + 1 :]))
        case syntax.Product(parts=parts):
            for place, part in enumerate(parts):
                for rank, new in _of_factor(part):
                    yield rank, syntax.Product((*parts[:place], new, *parts[place + 1 :]))
        case syntax.Power(parts=(base, exponent)):
            if (old := syntax.rational(exponent)) is not None:
                values = (-old, old + 1, old - 1, 2 * old, old / 2, -2 * old, -old / 2)
                yield from ((EXPONENTS, _power(base, v)) for v in dict.fromkeys(values) if v)
        case syntax.Call(parts=(first, *rest), name=name):
            for rank, new in _of_term(first, parameters):
                yield rank, syntax.Call((new, *rest), name)
            if name == "sqrt":
                yield from ((EXPONENTS, _power(first, value)) for value in (Fraction(1), -HALF))
        case syntax.Unknown(site=site, shift=shift) if site:
            for moved in dict.fromkeys((-shift, shift + 1, shift - 1)):
                yield EXPONENTS, replace(node, shift=moved)
        case syntax.Name(name=name) if name not in CONSTANTS:
            yield from _powers(node)
            yield from _shifted(node) if name == SITE else ()


def _of_factor(factor: FormulaTree) -> Iterator[Change]:
    """Yield a factor with an exponent, or another number."""
    if isinstance(factor, syntax.Number):
        values = (factor.value + step for step in (1, -1))
        yield from ((OTHERS, syntax.Number(value)) for value in values if value)
    elif not isinstance(factor, syntax.Product | syntax.Power) and factor not in [
        *map(syntax.Name, CONSTANTS)
    ]:
        for rank, new in _powers(factor):
            yield rank if isinstance(factor, syntax.Name) else OTHERS, new


def _of_term(term: FormulaTree, parameters: Iterable[str]) -> Iterator[Change]:
    """Yield a term with another sign or factor."""
    yield SIGNS, _times(Fraction(-1), term)
    for factor, rank in FACTORS.items():
        yield rank, _times(factor, term)
    for name in parameters:
        for exponent in map(Fraction, (1, -1, 2, -2)):
            yield OTHERS, syntax.Product((*_factors(term), _power(syntax.Name(name), exponent)))


def _powers(base: FormulaTree) -> Iterator[Change]:
    for exponent in map(Fraction, ("2", "-1", "1/2")):
        yield EXPONENTS, _power(base, exponent)


def _shifted(term: FormulaTree) -> Iterator[Change]:
    """Yield a site or a number shifted by 1 or -1."""
    value = syntax.rational(term)
    for step in (1, -1):
        if value is not None:
            yield EXPONENTS, syntax.Number(value + step)
        elif term == syntax.Name(SITE):
            yield EXPONENTS, syntax.Sum((term, syntax.Number(Fraction(step))))


def _power(base: FormulaTree, exponent: Fraction) -> FormulaTree:
    if exponent == HALF:
        return syntax.Call((base,), "sqrt")
    return base if exponent == 1 else syntax.Power((base, syntax.Number(exponent)))


def _times(factor: Fraction, term: FormulaTree) -> FormulaTree:
    """Return a multiple of a term; its numbers are collected in numerator and denominator."""
    above, below = list[FormulaTree](), list[FormulaTree]()
    for part in _factors(term):
        value = syntax.rational(part)
        if value is not None:
            factor *= value
        elif isinstance(part, syntax.Power) and part.parts[1] == syntax.MINUS_ONE:
            below.append(part.parts[0])
        else:
            above.append(part)
    number, divisor = abs(factor.numerator), factor.denominator
    above[:0] = [syntax.Number(Fraction(number))] * (number != 1 or not above)
    below[:0] = [syntax.Number(Fraction(divisor))] * (divisor != 1)
    line = [syntax.Power((_product(below), syntax.MINUS_ONE))] if below else []
    return _product([*[syntax.MINUS_ONE] * (factor < 0), *above, *line])


def _product(parts: Sequence[FormulaTree]) -> FormulaTree:
    return parts[0] if len(parts) == 1 else syntax.Product(tuple(parts))


def _factors(term: FormulaTree) -> list[FormulaTree]:
    match term:
        case syntax.Product(parts=parts):
            return [factor for part in parts for factor in _factors(part)]
        case syntax.Power(parts=(syntax.Product(parts=parts), exponent)) if (
            exponent == syntax.MINUS_ONE
        ):
            return [syntax.Power((factor, exponent)) for part in parts for factor in _factors(part)]
    return [term]
