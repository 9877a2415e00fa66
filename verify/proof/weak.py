"""Decide weak solutions: the conditions that a formula with one travelling jump must satisfy.

An equation in conservation form is a sum of terms c D(F).  D is a derivative, F a formula in the
unknowns and their first derivatives, and c is free of variables.  The formulas on both sides of a
surface x = l, with l a polynomial in the other variables, are smooth up to it and beyond.  With
p = x - l, H = 1 for p > 0, H = 0 for p < 0, and delta = H'(p), for smooth G and for g without x:

    D_v (H G)               = H G_v + p_v delta G(x = l),
    D_v (delta^(j) g)       = p_v delta^(j+1) g + delta^(j) g_v.

So the sum of all terms is its value on each side plus a sum of delta^(j) g_j.  It vanishes as a
distribution if and only if the equation holds on each side and every g_j is 0.
`docs/trust.md` has the proof.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from longwave.derive.algebra.formula_expression import ExpressionBuilder
from longwave.derive.algebra.formula_printing import formula_as_text
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
    rational,
)
from longwave.verify.verdict import Outcome, ProofVerdict, timed

from . import prover
from .conditions import ConditionalVerdict, solve_statement
from .constant_cases import ConstantCase
from .domain_signs import DomainSigns, singularities
from .domains import Domains
from .seams import SAFE, seams
from .statement_problem import all_domains
from .statement_scope import SMOOTH
from .statement_text import read_statement
from .statement_verdict import Progress, StatementVerdict, decide_statement, undecided, united
from .typed_hints import put_in, vocabulary
from .typed_statement import Statement, declared_name

Jumps = dict[int, sp.Expr]
"""Factors g_j of the derivatives of delta, by j."""

SHAPE = "with weak an equation must be a sum of derivatives, as u_t + diff(u**2/2, x)"


@timed
def decide_weak(statement: Statement, progress: Progress = lambda _: None) -> StatementVerdict:
    """Decide a weak solution: each side must be proved, and every condition at the jump."""
    try:
        return _decided(statement, progress)
    except ValueError as error:
        return undecided(statement, " ".join(str(error).split()))


def _decided(statement: Statement, progress: Progress) -> StatementVerdict:
    plane = travelling_plane(statement)
    limited = bool(statement.texts.domain)  # the plane may be outside of the domain
    if limited and statement.solve_for:
        raise ValueError("with weak and solve the domain must be left out")
    conditions = list(jump_conditions(statement, plane))
    whole = replace(statement, solve_for=(), weak=False)
    sides = decide_statement(whole, progress)
    if sides.outcome is Outcome.REFUTED and not statement.solve_for:
        return sides
    if sides.outcome is not Outcome.PROVED:
        raise ValueError(f"the sides are not shown to solve the equation ({sides.detail})")
    progress("the conditions at the jump")
    words = f"as a weak solution across {plane.words}"
    if statement.solve_for:
        return _solved(statement, conditions, sides, words)
    verdicts = [_vanishes(statement, condition) for condition in conditions]
    for condition, verdict in zip(conditions, verdicts, strict=True):
        failing = f"no weak solution across {plane.words}: a condition there is {condition} = 0"
        if verdict.outcome is Outcome.REFUTED and not limited:
            open_verdict = undecided(statement, failing)
            return replace(open_verdict, outcome=verdict.outcome, witness=verdict.witness)
        if verdict.outcome is not Outcome.PROVED:
            raise ValueError(f"it is not decided whether {condition} = 0 ({verdict.detail})")
    certificates = (*sides.certificates, *(v.certificate for v in verdicts if v.certificate))
    scope = sides.assumptions[0].replace(SMOOTH, "in the sense of distributions")
    return replace(
        sides, sides=words, detail=f"{sides.detail}; so are the conditions at the jump",
        certificates=certificates, assumptions=(scope, *sides.assumptions[1:]), singularities=(),
    )  # fmt: skip


def _solved(
    statement: Statement, conditions: Sequence[sp.Expr], sides: StatementVerdict, words: str
) -> ConditionalVerdict:
    """Return the values of the ``solve_for`` parameters for which the jump conditions hold.

    ``sides`` is the verdict on both sides of the jump, and ``words`` says where it is."""
    if not conditions:
        raise ValueError("every value holds, since the jump gives no condition")
    targets = [str(symbol) for symbol in statement.solve_for]
    known = {str(symbol) for condition in conditions for symbol in condition.free_symbols}
    missing = [name for name in targets if name not in known]
    if missing:
        raise ValueError(f"no condition at the jump contains {', '.join(missing)}")
    names = [f"jump{'abcdefgh'[place]}" for place in range(len(conditions))]
    formulas = map(formula_as_text, conditions)
    texts = statement.texts.parameters
    parameters = "; ".join(t for t in texts if t.partition(":")[0].strip() in known)
    solutions = [f"{name} = {text}" for name, text in zip(names, formulas, strict=True)]
    system = read_statement(
        names, solutions, parameters, name=statement.name, solve=", ".join(targets),
        variables=", ".join(statement.texts.variables),
    )  # fmt: skip
    answer = solve_statement(system)
    cases = tuple(_as_weak(statement, case) for case in answer.cases)
    if not all(case.proved for case in cases) and answer.outcome is Outcome.PROVED:
        raise ValueError("the statement is not proved for one case of the conditions at the jump")
    certificates = [c for case in cases if case.verdict for c in case.verdict.certificates]
    answer = replace(answer, cases=cases)
    return replace(
        answer, equation=sides.equation, statement=sides.statement, sides=words,
        detail=f"{words}: {answer.words()}" if answer.is_solved else answer.detail,
        assumptions=united([sides.assumptions, answer.assumptions]), singularities=(),
        certificate=certificates[0] if certificates else None, certificates=tuple(certificates),
    )  # fmt: skip


def _as_weak(statement: Statement, case: ConstantCase) -> ConstantCase:
    """Decide the statement with the values of one case of the jump conditions."""
    texts = statement.texts
    if case.implicit or case.restrictions:
        return replace(case, verdict=None)
    names = {symbol.name for value in case.values.values() for symbol in value.free_symbols}
    declared = {*map(declared_name, texts.parameters)}
    values = {symbol.name: formula_as_text(value) for symbol, value in case.values.items()}
    others = [t for t in texts.parameters if t.partition(":")[0].strip() not in values]
    parameters = [
        *(f"{name}: real" for name in sorted(names - declared)),
        *others,
        *(f"{name} = {text}" for name, text in values.items()),
    ]
    whole = read_statement(
        texts.equations, texts.solutions, "; ".join(parameters), name=statement.name,
        variables=", ".join(texts.variables), weak=True,
    )  # fmt: skip
    moving = (formula.free_symbols for formula in whole.solutions.values())
    trivial = not any(symbols & set(whole.variables) for symbols in moving)
    return replace(case, statement=whole, verdict=decide_weak(whole), trivial=trivial)


def _vanishes(statement: Statement, condition: sp.Expr) -> ProofVerdict:
    domains = {s: d for s, d in statement.domains.items() if s in condition.free_symbols}
    names = {"name": "jump", "equation_name": "a condition at a jump"}
    return prover.prove_equal(condition, sp.S.Zero, statement.variables, domains=domains, **names)


@dataclass(frozen=True)
class Plane:
    """The plane ``variable = end``; ``sides``: the trees of the formulas above and below it."""

    variable: sp.Symbol
    end: sp.Expr
    words: str
    sides: tuple[Mapping[str, FormulaTree], Mapping[str, FormulaTree]]


def travelling_plane(statement: Statement) -> Plane:
    """Return the plane at which the formulas jump; raises ValueError unless there is just one."""
    if statement.complexes or statement.functions:
        rule = "with weak a statement must be real and without functions"
        raise ValueError(f"{rule} (declare real parameters)")
    places = seams(statement)
    by_name = {str(v): v for v in statement.variables}
    name = places[0].place.partition(" = ")[0] if len(places) == 1 else ""
    if name not in by_name or places[0].at_sites:
        listed = ", ".join(seam.place for seam in places) or "none"
        rule = "with weak the formulas must jump at one plane"
        raise ValueError(f"{rule}, got {listed} (write the jump by sign or abs)")
    trees, words = statement.trees, vocabulary(statement)
    build = ExpressionBuilder(words).expression
    whole = {name: put_in(trees, tree) for name, tree in trees.solutions.items()}
    nodes = (node for tree in whole.values() for node in tree.nodes() if isinstance(node, Call))
    kinks = [node.parts[0] for node in nodes if node.name in ("abs", "sign")]
    domains = all_domains(statement, *statement.equations)
    signs = DomainSigns(domains)
    variable = by_name[name]
    ends, slopes = set[sp.Expr](), dict[FormulaTree, int]()
    for kink in kinks:
        value = sp.expand(build(kink))
        if not value.has(*statement.variables):
            continue  # the modulus of a constant
        slope = value.coeff(variable, 1)
        ends.add(sp.expand(-(value - slope * variable) / slope))
        slopes[kink] = 1 if signs.is_positive(slope) else -1
        if not (signs.is_positive(slope) or signs.is_positive(-slope)):
            raise ValueError(f"the sign of {slope} must be known (state it, as in c: c>0)")
    if len(ends) != 1 or any(end.has(variable) for end in ends):
        raise ValueError("with weak the formulas must jump at one plane by abs and sign alone")
    (end,) = ends

    def side(tree: FormulaTree, above: int) -> FormulaTree:
        def image(node: FormulaTree) -> FormulaTree | None:
            if not (isinstance(node, Call) and node.name in ("abs", "sign")):
                return None
            if node.parts[0] not in slopes:
                return None
            turned = above * slopes[node.parts[0]] < 0
            if node.name == "sign":
                return MINUS_ONE if turned else Product((MINUS_ONE, MINUS_ONE))
            return Product((MINUS_ONE, node.parts[0])) if turned else node.parts[0]

        return mapped(tree, image)

    both = tuple({n: side(tree, above) for n, tree in whole.items()} for above in (1, -1))
    for tree in (tree for formulas in both for tree in formulas.values()):
        _check_smooth(tree, build(tree), domains)
    return Plane(variable, end, places[0].place, (both[0], both[1]))


def _check_smooth(tree: FormulaTree, value: sp.Expr, domains: Domains) -> None:
    """Raise ValueError unless a formula has only functions in `SAFE` and is smooth everywhere."""
    for node in tree.nodes():
        power = rational(node.parts[1]) if isinstance(node, Power) else None
        whole = power is not None and power.denominator == 1
        plain = isinstance(node, Sum | Product | Number | Name) or whole
        if not (plain or (isinstance(node, Call) and node.name in SAFE)):
            known, got = ", ".join(SAFE), formula_text(node)
            raise ValueError(f"with weak a side must consist of {known}, got {got}")
    if singularities([value], domains):
        raise ValueError("with weak both sides must be shown to be smooth beyond the jump")


def jump_conditions(statement: Statement, plane: Plane) -> Iterator[sp.Expr]:
    """Yield the conditions at the plane: for each equation the factors of delta, delta', ..."""
    for equation in statement.trees.equations:
        total: Jumps = {}
        for coefficient, steps, inner in _terms(statement, equation):
            yield from _continuity(statement, plane, inner)
            for order, factor in _jumps(statement, plane, steps, inner).items():
                total[order] = total.get(order, sp.S.Zero) + coefficient * factor
        factors = (sp.expand(total[order]) for order in sorted(total))
        yield from (factor for factor in factors if factor != 0)


def _terms(
    statement: Statement, equation: FormulaTree
) -> Iterator[tuple[sp.Expr, tuple[str, ...], FormulaTree]]:
    """Yield the coefficient, derivative and formula of each term."""
    build = ExpressionBuilder(vocabulary(statement)).expression
    for term in _summands(equation):
        if rational(term) == 0:
            continue
        factors = term.parts if isinstance(term, Product) else (term,)
        moving = [f for f in factors if any(isinstance(n, Unknown) for n in f.nodes())]
        fixed = (mapped(f, statement.trees.meaning) for f in factors if f not in moving)
        constant = sp.Mul(*map(build, fixed))
        if len(moving) != 1 or constant.has(*statement.variables):
            raise ValueError(f"{SHAPE}, got {formula_text(term)}")
        match moving[0]:
            case Unknown(name=name, steps=steps, site=""):
                yield constant, steps, Unknown(name)
            case Derivative(parts=(inner,), steps=steps):
                yield constant, steps, inner
            case _:
                raise ValueError(f"{SHAPE}, got {formula_text(term)}")


def _summands(tree: FormulaTree) -> Iterator[FormulaTree]:
    """Yield the terms of a sum, also of nested and of negative sums."""
    match tree:
        case Sum(parts=parts):
            for part in parts:
                yield from _summands(part)
        case Product(parts=(first, Sum() as inner)) if first == MINUS_ONE:
            for part in _summands(inner):
                yield Product((MINUS_ONE, *(part.parts if isinstance(part, Product) else (part,))))
        case Product(parts=(first, Product(parts=parts))):
            yield from _summands(Product((first, *parts)))
        case _:
            yield tree


def _values(statement: Statement, plane: Plane, inner: FormulaTree) -> tuple[sp.Expr, sp.Expr]:
    """Return the values above and below the plane of ``inner``, a formula in the unknowns."""
    build = ExpressionBuilder(vocabulary(statement)).expression
    domains = all_domains(statement, *statement.equations)
    values = []
    for formulas in plane.sides:
        tree = put_in(replace(statement.trees, solutions=formulas), inner)
        plain = mapped(tree, lambda n: n.parts[0] if isinstance(n, Derivative) else None)
        _check_smooth(plain, build(tree), domains)
        values.append(build(tree))
    return values[0], values[1]


def _continuity(statement: Statement, plane: Plane, inner: FormulaTree) -> Iterator[sp.Expr]:
    """Yield the jumps of those unknowns whose first derivatives occur in ``inner``."""
    for node in inner.nodes():
        if isinstance(node, Derivative) or (isinstance(node, Unknown) and len(node.steps) > 1):
            got = formula_text(inner)
            raise ValueError(f"within a derivative unknowns must have first ones alone, got {got}")
        if isinstance(node, Unknown) and node.steps:
            above, below = _values(statement, plane, Unknown(node.name))
            jump = sp.expand((above - below).xreplace({plane.variable: plane.end}))
            if jump != 0:
                yield jump


def _jumps(statement: Statement, plane: Plane, steps: Sequence[str], inner: FormulaTree) -> Jumps:
    """Return the factors of delta, delta', ... in the derivative of ``inner`` along ``steps``."""
    above, below = _values(statement, plane, inner)
    gap, factors = above - below, dict[int, sp.Expr]()
    by_name = {str(v): v for v in statement.variables}
    for v in map(by_name.__getitem__, steps):
        slope = sp.diff(plane.variable - plane.end, v)
        derived: Jumps = {0: slope * gap.xreplace({plane.variable: plane.end})}
        for order, factor in factors.items():
            derived[order + 1] = derived.get(order + 1, sp.S.Zero) + slope * factor
            derived[order] = derived.get(order, sp.S.Zero) + sp.diff(factor, v)
        gap, factors = sp.diff(gap, v), derived
    return factors
