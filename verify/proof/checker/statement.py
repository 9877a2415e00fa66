"""What a certificate states: equations, formulas for their unknowns, and a domain; in words."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from flint import fmpq

from .limits import JETS, NAME, NODES, ORDER, TERMS, CertificateError, within
from .nodes import ARITY, SYMBOL, Nodes, children, integer, listed, number

Jet = tuple[int, tuple[int, ...]]
"""The place of an unknown and its order in each variable."""

Term = tuple[fmpq, tuple[int, ...], tuple[Jet, ...]]
"""A number, known factors (nodes), and jets."""

Equation = tuple[Term, ...] | int
"""A polynomial in jets, or the node of any left-hand side."""

RESERVED = {"I", "pi", "poly", "diff", *ARITY}
"""Names of constants and functions."""

LONG = 40
"""Characters from which a formula that occurs twice gets a name."""


@dataclass(frozen=True)
class Statement:
    """``equations`` (left-hand sides, "= 0") hold if ``formulas`` are put for ``unknowns``.

    ``domain`` are pairs of nodes, ``left < right``, or ``left <= right`` where ``weak``.
    """

    nodes: Nodes
    variables: tuple[int, ...]
    unknowns: tuple[str, ...]
    formulas: tuple[int, ...]
    equations: tuple[Equation, ...]
    domain: tuple[tuple[bool, int, int], ...]

    @property
    def polynomials(self) -> list[tuple[Term, ...]]:
        """The equations that are written as polynomials in jets."""
        return [equation for equation in self.equations if not isinstance(equation, int)]

    @property
    def left_sides(self) -> list[int]:
        """The nodes of the other equations."""
        return [equation for equation in self.equations if isinstance(equation, int)]

    @property
    def roots(self) -> list[int]:
        """The nodes that the statement is made of, but for those of left-hand sides."""
        known = [node for terms in self.polynomials for _, factors, _ in terms for node in factors]
        return [*self.formulas, *known]

    def content(self) -> object:
        """What two statements have in common if and only if they say the same in the same words."""
        terms = [
            equation
            if isinstance(equation, int)
            else sorted((str(c), sorted(known), sorted(jets)) for c, known, jets in equation)
            for equation in self.equations
        ]
        domain = sorted(self.domain)
        return (self.variables, self.unknowns, self.formulas, terms, domain)


def read_statement(nodes: Nodes, data: object) -> Statement:
    """The statement of a certificate; raises CertificateError if it does not state anything."""
    if not isinstance(data, Mapping):
        raise CertificateError("the statement must be an object")
    variables = [nodes.place(v) for v in listed(data["variables"], 8, "variables")]
    if not variables or any(nodes.all[v][0] != "symbol" for v in variables):
        raise CertificateError("variables must be symbols")
    if len(set(variables)) != len(variables):
        raise CertificateError("variables must differ")
    names, formulas = [], []
    for unknown in listed(data["unknowns"], 8, "unknowns"):
        name, place = listed(unknown, 2, "an unknown", 2)
        if not isinstance(name, str) or len(name) > NAME or not SYMBOL.fullmatch(name):
            raise CertificateError(f"names must be letters and digits, got {ascii(name)[:60]}")
        names.append(name)
        formulas.append(nodes.place(place))
    symbols = [node[1] for node in nodes.all if node[0] == "symbol"]
    if len({*names, *symbols}) != len(names) + len(symbols):
        raise CertificateError("unknowns must differ in name from each other and from symbols")
    equations = tuple(
        _equation(nodes, entry, len(variables), len(names))
        for entry in listed(data["equations"], 8, "equations")
    )
    domain = tuple(_inequality(nodes, entry) for entry in listed(data["domain"], 100, "domain"))
    found = Statement(nodes, tuple(variables), tuple(names), tuple(formulas), equations, domain)
    _check_unknowns(found)
    _check_derivatives(found)
    _check_names(found.polynomials, names, symbols, [nodes.all[v][1] for v in variables])
    return found


def _equation(nodes: Nodes, data: object, variables: int, unknowns: int) -> Equation:
    if isinstance(data, int):
        return nodes.place(data)
    found = []
    for entry in listed(data, TERMS, "the terms of an equation"):
        text, known, jets = listed(entry, 3, "a term of an equation", 3)
        orders: list[Jet] = []
        for jet in listed(jets, JETS, "the derivatives in a term"):
            unknown, order = listed(jet, 2, "a derivative", 2)
            counts = [
                integer(n, 0, ORDER, "the order of a derivative")
                for n in listed(order, 8, "the orders of a derivative", variables)
            ]
            within("the order of a derivative", sum(counts), ORDER)
            place = integer(unknown, 0, unknowns - 1, "the place of an unknown")
            orders.append((place, tuple(counts)))
        factors = [nodes.place(place) for place in listed(known, NODES, "known factors")]
        found.append((number(text), tuple(factors), tuple(orders)))
    return tuple(found)


def _check_unknowns(statement: Statement) -> None:
    """Every equation must contain an unknown, every unknown must be in an equation."""
    if not statement.equations:
        raise CertificateError("the statement has no equation")
    seen: set[int] = set()
    for equation in statement.equations:
        if isinstance(equation, int):
            found = _unknowns_in(statement, equation)
        else:
            found = _unknowns_in_terms(equation)
        if not found:
            raise CertificateError("an equation does not contain the unknown")
        seen |= found
    if len(seen) != len(statement.unknowns):
        raise CertificateError("an unknown is in none of the equations")


def _unknowns_in_terms(terms: Sequence[Term]) -> set[int]:
    products = {(tuple(sorted(known)), tuple(sorted(jets))) for _, known, jets in terms}
    if len(products) < len(terms) or any(value == 0 for value, _, _ in terms):
        raise CertificateError("the terms of an equation must differ and not be 0")
    return {jet[0] for _, _, jets in terms for jet in jets}


def _unknowns_in(statement: Statement, equation: int) -> set[int]:
    """The unknowns in a left-hand side, each at as many shifts as there are variables."""
    found: set[int] = set()
    for node in statement.nodes.below([equation]):
        match statement.nodes.all[node]:
            case ("unknown", place, shifts):
                if place >= len(statement.unknowns) or len(shifts) != len(statement.variables):
                    raise CertificateError("an unknown must be one of the statement's")
                found.add(place)
    return found


def _check_derivatives(statement: Statement) -> None:
    """Only equations have derivatives and unknowns; derivatives are along real variables."""
    nodes, ends = statement.nodes, [end for _, *both in statement.domain for end in both]
    for node in nodes.below([*statement.roots, *ends]):
        if nodes.all[node][0] in ("diff", "unknown"):
            raise CertificateError("formulas must be without derivatives and unknowns")
    whole = {v for v in statement.variables if nodes.all[v][2] == "integer"}
    along = {v for node in nodes.all if node[0] == "diff" for v in node[2:]}
    for terms in statement.polynomials:
        for _, _, jets in terms:
            for _, orders in jets:
                along |= {v for v, n in zip(statement.variables, orders, strict=True) if n}
    if along & whole or not along <= {*statement.variables}:
        raise CertificateError("derivatives must be in the statement's real variables")


def _check_names(
    equations: Sequence[Sequence[Term]],
    unknowns: Sequence[str],
    symbols: Sequence[str],
    variables: Sequence[str],
) -> None:
    """What differs must be printed differently: functions, constants, symbols, derivatives."""
    jets = {jet for terms in equations for _, _, jets in terms for jet in jets}
    derivatives = [
        _jet_text(unknowns[place], orders, variables) for place, orders in jets if any(orders)
    ]
    names = [*unknowns, *symbols]
    for name in variables:
        others = "|".join(re.escape(other) for other in variables if other != name)
        if others and re.fullmatch(f"(?:{others})+", name):
            raise CertificateError(f"the name {name!a} is made of other variables (rename it)")
    for name in (*names, *derivatives):
        if name in RESERVED or [*names, *derivatives].count(name) > 1:
            raise CertificateError(f"the name {name!a} means two things (rename the symbol)")


def _inequality(nodes: Nodes, data: object) -> tuple[bool, int, int]:
    relation, left, right = listed(data, 3, "an inequality", 3)
    if relation not in ("<", "<="):
        raise CertificateError("inequalities must be < or <=")
    return relation == "<=", nodes.place(left), nodes.place(right)


def statement_text(statement: Statement) -> str:
    """The statement in words, formulas in full; what occurs twice is named once."""
    ends = [node for _, *both in statement.domain for node in both]
    roots = [*statement.roots, *statement.left_sides, *ends]
    writer = _Writer(statement, roots)
    variables = [writer.text(v) for v in statement.variables]
    equations = [
        writer.text(left)
        if isinstance(left, int)
        else " + ".join(_term_text(term, statement, variables, writer) for term in left)
        for left in statement.equations
    ]
    formulas = [
        f"{name}({', '.join(variables)}) = {writer.text(formula)}"
        for name, formula in zip(statement.unknowns, statement.formulas, strict=True)
    ]
    domain = [
        f"{writer.text(left)} {'<=' if weak else '<'} {writer.text(right)}"
        for weak, left, right in statement.domain
    ]
    kinds = {
        kind: sorted(
            node[1] for node in statement.nodes.all if node[0] == "symbol" and node[2] == kind
        )
        for kind in ("real", "integer", "complex")
    }
    symbols = [f"{kind} {', '.join(names)}" for kind, names in kinds.items() if names]
    where = [f"{name} = {text}" for name, text in writer.named.items()]
    lines = [
        f"equation: {'; '.join(f'{left} = 0' for left in equations)}",
        f"solution: {'; '.join(formulas)}",
        *([f"where {'; '.join(where)}"] if where else []),
        f"for all {'; '.join(symbols)}"
        + (f" with {', '.join(domain)}" if domain else "")
        + ", wherever the formulas are smooth",
    ]
    return "\n".join(lines)


def _term_text(term: Term, statement: Statement, variables: Sequence[str], writer: _Writer) -> str:
    value, known, jets = term
    parts = [f"({value})" if value < 0 or value.q != 1 else f"{value}"] if value != 1 else []
    parts += [f"({writer.text(node)})" for node in known]
    for (unknown, orders), power in Counter(jets).items():
        name = _jet_text(statement.unknowns[unknown], orders, variables)
        parts.append(name if power == 1 else f"{name}^{power}")
    return "*".join(parts) or "1"


def _jet_text(unknown: str, orders: Sequence[int], variables: Sequence[str]) -> str:
    steps = "".join(v * n for v, n in zip(variables, orders, strict=True))
    return unknown + (f"_{steps}" if steps else "")


class _Writer:
    """Formulas as text of a length that grows with the number of nodes only."""

    def __init__(self, statement: Statement, roots: Sequence[int]) -> None:
        self._nodes = nodes = statement.nodes
        self._statement = statement
        self.named: dict[str, str] = {}
        self._texts: dict[int, str] = {}
        taken = {*statement.unknowns, *(node[1] for node in nodes.all if node[0] == "symbol")}
        uses = Counter(c for node in nodes.below(roots) for c in set(children(nodes.all[node])))
        uses.update(roots)
        for node in nodes.below(roots):
            if nodes.all[node][0] == "poly":
                uses.update(dict.fromkeys(nodes.all[node][2:], LONG))
        for node in nodes.below(roots):
            text = self._text(node)
            often = uses[node] > 1 and len(text) > 8 and uses[node] * len(text) > 2 * LONG
            if often or len(text) > 100 * LONG:
                name = f"f{len(self.named) + 1}"
                while name in taken:
                    name += "_"
                self.named[name], text = text, name
            self._texts[node] = text

    def text(self, node: int) -> str:
        """The text of a node, or its name."""
        if node not in self._texts:
            for inner in self._nodes.below([node]):
                if inner not in self._texts:
                    self._texts[inner] = self._text(inner)
        return self._texts[node]

    def _text(self, node: int) -> str:
        match self._nodes.all[node]:
            case ("number", value):
                return f"({value})" if value < 0 or value.q != 1 else str(value)
            case ("symbol", name, _):
                return str(name)
            case ("Add", *parts):
                return "(" + " + ".join(self._texts[part] for part in parts) + ")"
            case ("Mul", *parts):
                return "*".join(self._texts[part] for part in parts)
            case ("Pow", base, exponent):
                power = str(exponent) if exponent.q == 1 and exponent > 0 else f"({exponent})"
                inner = self._texts[base]
                return f"{inner if _is_atomic(self._nodes.all[base]) else f'({inner})'}^{power}"
            case ("poly", terms, *parts):
                texts = [self._texts[part] for part in parts]
                return "(" + " + ".join(_monomial(c, e, texts) for c, e in terms) + ")"
            case ("unknown", place, shifts):
                return self._unknown(place, shifts)
            case ("diff", inner, *variables):
                steps = ", ".join(self._nodes.all[v][1] for v in variables)
                return f"diff({self._texts[inner]}, {steps})"
            case ("power", base, exponent):
                return f"({self._texts[base]})^({self._texts[exponent]})"
            case ("parity", inner):
                return f"(-1)^({self._texts[inner]})"
            case (name, *parts) if parts:
                return f"{name}({', '.join(self._texts[part] for part in parts)})"
            case (name,):
                return str(name)
        return "?"

    def _unknown(self, place: int, shifts: Sequence[int]) -> str:
        name = self._statement.unknowns[place]
        if not any(shifts):
            return name
        names = (self._nodes.all[v][1] for v in self._statement.variables)
        moved = (f"{v}{n:+}" if n else v for v, n in zip(names, shifts, strict=True))
        return f"{name}[{', '.join(moved)}]"


def _is_atomic(node: tuple[Any, ...]) -> bool:
    return node[0] not in ("Mul", "Pow", "power", "parity")


def _monomial(coefficient: fmpq, exponents: Sequence[int], texts: Sequence[str]) -> str:
    powers = zip(texts, exponents, strict=True)
    return "*".join([f"({coefficient})", *(_power(text, n) for text, n in powers if n)])


def _power(text: str, exponent: int) -> str:
    if exponent == 1:
        return text
    return f"{text if SYMBOL.fullmatch(text) else f'({text})'}^{exponent}"
