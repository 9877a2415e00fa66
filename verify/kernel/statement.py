"""Statement of a certificate: the texts as they were typed, and their nodes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from .limits import CertificateError
from .nodes import DOMAIN_WORDS, KINDS, Nodes, listed
from .reading import Scope, TextReader, is_reserved, tokens

PARTS = ("variables", "equations", "solutions", "parameters", "domain")


@dataclass(frozen=True)
class Statement:
    """Statement that ``formulas`` for the ``unknowns`` make ``equations`` (left-hand sides) 0.

    ``domain`` has triples (weak, left, right): ``left <= right`` if weak, else ``left < right``.
    """

    nodes: Nodes
    variables: tuple[int, ...]
    unknowns: tuple[str, ...]
    formulas: tuple[int, ...]
    equations: tuple[int, ...]
    domain: tuple[tuple[bool, int, int], ...]


def read_statement(nodes: Nodes, data: object) -> tuple[Statement, Scope]:
    """Parse a certificate's statement and its names; raises CertificateError if it is invalid."""
    if not isinstance(data, Mapping) or set(data) != set(PARTS):
        raise CertificateError(f"the statement must have the parts {', '.join(PARTS)}")
    texts = {name: listed(data[name], 400, name) for name in PARTS}
    scope = _declared(nodes, texts)
    domain = [limit for text in texts["parameters"] for limit in _parameter(scope, text)]
    for text in texts["domain"]:
        domain += _conditions(scope, TextReader(scope, text), "")
    solutions = [_solution(scope, text) for text in texts["solutions"]]
    left_sides = [_equation(scope, text) for text in texts["equations"]]
    for name in scope.known:
        scope.refuse_likeness(name)
    known = tuple(scope.variables), tuple(scope.unknowns), tuple(solutions), tuple(left_sides)
    result = Statement(nodes, *known, tuple(domain))
    _check(result)
    return result, scope


def _declared(nodes: Nodes, texts: Mapping[str, list[Any]]) -> Scope:
    """Return the scope with all declared names: variables, unknowns, and parameters by kind."""
    scope, kinds = Scope(nodes), dict[str, str]()
    for text in texts["parameters"]:
        words = [word for _, word in tokens(text)]
        if len(words) < 3 or words[1] not in (":", "=") or words[0] in scope.pending:
            raise CertificateError(f"expected name: domain or name = formula, got {text[:40]!a}")
        if words[1] == "=":
            scope.pending.add(words[0])
        elif kinds.setdefault(words[0], kind := _kind(words[2:])) != kind:
            raise CertificateError(f"the name {words[0][:40]} has two kinds")
    for text in texts["variables"]:
        name = TextReader(scope, text).name()
        if len(tokens(text)) > 1:
            raise CertificateError("variables must be names")
        kind = kinds.pop(name, "integer" if name == "n" else "real")  # n is a lattice site
        if kind not in ("real", "integer"):
            raise CertificateError("variables must be real or integers")
        scope.variables.append(scope.declare(name, kind))
    if not 0 < len(scope.variables) <= 8:
        raise CertificateError("a statement must have 1 to 8 variables")
    for text in texts["solutions"]:
        name = TextReader(scope, text).name()
        if name in scope.unknowns:
            raise CertificateError(f"the unknown {name[:40]} has two solutions")
        scope.unknowns.append(name)
    for name, kind in kinds.items():
        scope.declare(name, kind)
    for name in scope.unknowns:
        taken = name in (*scope.known, *scope.pending) or is_reserved(name)
        if taken or "_" in name.rstrip("_"):
            raise CertificateError(f"the name {name[:40]} means two things (rename the unknown)")
    return scope


def _kind(words: Sequence[str]) -> str:
    """Return the kind named by an entry between commas, such as ``complex``; without one, real."""
    befores, afters = (",", *words), (*words[1:], ",")
    alone = zip(befores, words, afters, strict=False)
    named = [word for before, word, after in alone if word in KINDS and before == after == ","]
    if len(named) > 1:
        raise CertificateError("a parameter must have one kind")
    return named[0] if named else "real"


def _parameter(scope: Scope, text: str) -> list[tuple[bool, int, int]]:
    """Return the inequalities of ``name: domain``; enter ``name = formula`` into the scope."""
    parser = TextReader(scope, text)
    name = parser.name()
    if parser.take(":"):
        return _conditions(scope, parser, name)
    parser.expect("=")
    node = parser.whole()
    scope.pending.discard(name)
    scope.define(name, node)
    return []


def _conditions(scope: Scope, parser: TextReader, name: str) -> list[tuple[bool, int, int]]:
    """Return the inequalities of entries between commas: chains, or words like ``positive``."""
    limits = []
    while True:
        if name and parser.next in DOMAIN_WORDS:
            word = parser.name()
            if word in ("positive", "negative"):
                zero, own = scope.nodes.rational(0), scope.node(name)
                limits.append((False, zero, own) if word == "positive" else (False, own, zero))
        else:
            limits += _chain(parser)
        if parser.ended:
            return limits
        parser.expect(",")


def _chain(parser: TextReader) -> Iterator[tuple[bool, int, int]]:
    """Yield the inequalities of a chain ``a < b <= c``; ``a != 0`` is dropped, being unneeded."""
    left, some = parser.sum(), False
    while sign := parser.take("<", "<=", ">", ">=", "!="):
        right, some = parser.sum(), True
        if sign != "!=":
            ends = (left, right) if sign[0] == "<" else (right, left)
            yield ("=" in sign, *ends)
        left = right
    if not some:
        raise CertificateError(f"expected an inequality, got {parser.next[:40]!a}")


def _solution(scope: Scope, text: str) -> int:
    """Return the node of the formula in ``u = formula`` or ``u[n] = formula``."""
    parser = TextReader(scope, text)
    if parser.atom() != scope.node(tokens(text)[0][1]):
        raise CertificateError("a solution must define the unknown at its own variables")
    parser.expect("=")
    return parser.whole()


def _equation(scope: Scope, text: object) -> int:
    """Return the node of the left-hand side minus the right-hand side, if there is one."""
    parser = TextReader(scope, text)
    left = parser.sum()
    if parser.take("="):
        return scope.nodes.gap(parser.whole(), left)
    parser.end()
    return left


def _check(statement: Statement) -> None:
    """Check that equations have unknowns, formulas none, and no derivative is in an integer."""
    nodes, left_sides = statement.nodes, statement.equations
    if not 0 < len(left_sides) <= 8 or not 0 < len(statement.unknowns) <= 8:
        raise CertificateError("a statement must have 1 to 8 equations and solutions")
    for left in left_sides:
        if all(nodes.all[node][0] != "unknown" for node in nodes.below([left])):
            raise CertificateError("an equation does not contain the unknown")
    ends = [end for _, *both in statement.domain for end in both]
    for node in nodes.below([*statement.formulas, *ends]):
        if nodes.all[node][0] == "unknown":
            raise CertificateError("formulas must be without derivatives of unknowns, and these")
    for node in nodes.below([*left_sides, *statement.formulas, *ends]):
        along = nodes.all[node][2:] if nodes.all[node][0] == "diff" else ()
        if any(nodes.all[v][2] == "integer" for v in along):
            raise CertificateError("derivatives must be in the statement's real variables")


def statement_text(statement: Statement, texts: Mapping[str, Sequence[str]]) -> str:
    """Return the statement as it was typed, with the symbols and conditions of the proof."""
    symbols = [node for node in statement.nodes.all if node[0] == "symbol"]
    named = [(kind, sorted(node[1] for node in symbols if node[2] == kind)) for kind in KINDS]
    kinds = "; ".join(f"{kind} {', '.join(names)}" for kind, names in named if names)
    limits = "; ".join([t for t in texts["parameters"] if ":" in t] + list(texts["domain"]))
    where = "; ".join(text for text in texts["parameters"] if ":" not in text)
    lines = [
        f"equation: {'; '.join(texts['equations'])}",
        f"solution: {'; '.join(texts['solutions'])}",
        f"where {where}" if where else "",
        f"for all {kinds}{' with ' * bool(limits)}{limits}, wherever the formulas are smooth",
    ]
    return "\n".join(" ".join(line.split()) for line in lines if line)


class Substitution:
    """Substitution of ``formulas``, which have no unknowns, for the unknowns in their order.

    It is done on nodes, without simplification; ``diff`` nodes are left to the field.
    """

    def __init__(self, nodes: Nodes, variables: Sequence[int], formulas: Sequence[int]) -> None:
        self._nodes, self._variables, self._formulas = nodes, variables, formulas
        self._images: dict[int, int] = {}
        self._shifted: dict[tuple[tuple[int, ...], int], int] = {}

    def __call__(self, node: int) -> int:
        """Return the node with the formulas substituted for the unknowns."""
        for inner in self._nodes.below([node]):
            match self._nodes.all[inner]:
                case ("unknown", place, shifts):
                    self._images[inner] = self.shifted(self._formulas[place], shifts)
                case _:
                    self._images[inner] = self._nodes.rebuilt(inner, self._images.__getitem__)
        return self._images[node]

    def shifted(self, node: int, shifts: tuple[int, ...]) -> int:
        """Return a formula with ``variable + shift`` for each variable."""
        if not any(shifts):
            return node
        for inner in self._nodes.below([node]):
            if (shifts, inner) not in self._shifted:
                self._shifted[shifts, inner] = self._moved(inner, shifts)
        return self._shifted[shifts, node]

    def _moved(self, node: int, shifts: tuple[int, ...]) -> int:
        if node in self._variables:
            step = shifts[self._variables.index(node)]
            return self._nodes.add("Add", node, self._nodes.rational(step)) if step else node
        return self._nodes.rebuilt(node, lambda inner: self._shifted[shifts, inner])
