"""Read statements from text: equations, solutions, parameters and domains.

    equation    u_t + 6*u*u_x + u_xxx             "= 0" understood, or left = right
    solution    u = 2*k**2*sech(k*(x - 4*k**2*t))**2
    parameters  k: k>0; b: complex; f: function   a domain or kind,
    parameters  c = (1+m)/2                       or a name for an expression
    domain      t > 0                             of the variables x, y, z, t and the site n

Several equations or solutions are separated by ``;;`` in one text, or given as a list.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import sympy as sp
from sympy.core.function import AppliedUndef

from longwave.derive.algebra.formula_expression import ExpressionBuilder
from longwave.derive.algebra.formula_text import (
    CONSTANTS,
    ROWS,
    FormulaError,
    Parser,
    Token,
    Vocabulary,
)
from longwave.derive.algebra.formula_tree import MINUS_ONE, FormulaTree, Product, Sum, Unknown
from longwave.derive.algebra.typing_mistakes import Spelling, misread
from longwave.solutions.functions.jet_functions import jet_function

from .domains import REAL, Domain, settled_domains
from .mistyped_statements import Parts, corrected_error
from .samples import sample
from .text_names import FUNCTIONS, MISREAD, PARTS, SITE
from .text_parts import (
    RESERVED,
    WORDS,
    TextPart,
    VariableNames,
    condition,
    inhabited,
    symbol_of,
    text_parts,
    variable_names,
)
from .typed_statement import Statement, StatementTexts, StatementTrees

Texts = str | Sequence[str]


def read_statement(
    equation: Texts,
    solution: Texts,
    parameters: str = "",
    domain: str = "",
    *,
    name: str = "statement",
    solve: str = "",
    variables: str = "",
    weak: bool = False,
) -> Statement:
    """Parse the texts of a statement; ``solve`` names parameters to solve for, as in ``c, b``.

    ``variables`` names the independent variables instead of x, y, z and t, as in ``r, t``.
    ``weak`` asks for a weak solution.

    Raises FormulaError, with the position, for a text outside the grammar, a name that is declared
    twice, misread or not used, an unknown without a solution, a solution that contains an unknown,
    and an empty domain.

    >>> statement = read_statement("u_t + c*u_x", "u = exp(x - c*t)", "c: c>0")
    >>> statement.equations
    (c*Derivative(u(x, t), x) + Derivative(u(x, t), t),)
    >>> {str(symbol): domain.text(symbol) for symbol, domain in statement.domains.items()}
    {'c': '0 < c'}
    """
    given = {"equation": _texts(equation, "equation"), "solution": _texts(solution, "solution")}
    given |= {"parameters": [parameters], "domain": [domain], "solve": [solve]}
    read = partial(_read, name=name, variables=variable_names(variables))
    try:
        return replace(read(given), weak=weak)
    except FormulaError as error:
        raise corrected_error(error, given, FUNCTIONS, read) from None


def _read(given: Parts, name: str, variables: Sequence[str]) -> Statement:
    def parts(label: str, *separators: str) -> list[TextPart]:
        return [part for text in given[label] for part in text_parts(text, label, *separators)]

    entries, limits = parts("parameters", ";"), parts("domain", ";", ",")
    targets, formulas = parts("solve", ","), (parts("equation"), parts("solution"))
    known = VariableNames(variables, itertools.chain(*formulas))
    return _Reading(name, known, *formulas, entries, limits, targets).statement()


def _texts(given: Texts, label: str) -> list[str]:
    texts = [given] if isinstance(given, str) else list(given)
    if not texts or len(texts) > PARTS:
        raise FormulaError(label, f"expected 1 to {PARTS} texts, got {len(texts)}", "", 0)
    return texts


@dataclass
class _Reading:
    """State of a statement's parts while they are parsed into expressions."""

    name: str
    known: VariableNames
    equations: list[TextPart]
    solutions: list[TextPart]
    entries: list[TextPart]
    limits: list[TextPart]
    targets: list[TextPart]
    names: dict[str, sp.Expr] = field(default_factory=dict)
    declared: dict[str, TextPart] = field(default_factory=dict)
    variables: dict[str, sp.Symbol] = field(default_factory=dict)
    fields: dict[str, AppliedUndef] = field(default_factory=dict)
    domains: dict[sp.Symbol, Domain] = field(default_factory=dict)
    used: set[str] = field(default_factory=set)
    divisors: dict[sp.Expr, None] = field(default_factory=dict)
    complexes: list[str] = field(default_factory=list)
    functions: list[str] = field(default_factory=list)
    left_sides: list[FormulaTree] = field(default_factory=list)
    formulas: dict[str, FormulaTree] = field(default_factory=dict)
    definitions: dict[str, FormulaTree] = field(default_factory=dict)

    def statement(self) -> Statement:
        listed = (self.equations, self.solutions, self.entries, self.limits)
        for part in itertools.chain(*listed):
            if len(part.words) > 1 and part.words[0].kind == "end":
                raise part.error("expected a formula, got the end")
        for parts in listed:
            if len(parts) > PARTS:
                raise parts[PARTS].error(f"expected at most {PARTS} parts, got {len(parts)}")
        for entry in self._ordered_entries():
            self._declare(entry)
        letters, indexed = self.known.letters(self.names), self.known.indexed()
        for name, entry in self.declared.items():
            if remedy := self._misread(name, declared=True):
                words = f"expected a name of its own, got '{name}' (it reads as {remedy})"
                raise entry.error(words)
        self._make_variables(letters)
        self._make_fields(indexed)
        solutions = dict(self._solution(part) for part in self.solutions)
        equations = tuple(self._equation(part) for part in self.equations)
        self._check_use()
        self._check_domains()
        solve_for = tuple(self._target(part) for part in self.targets)
        for place, symbol in enumerate(solve_for):
            if symbol in solve_for[:place]:
                raise self.targets[place].error(f"expected each parameter once, got {symbol} again")
        divisors = tuple(self.divisors)
        typed = (tuple(part.written for part in parts) for parts in listed)
        texts = StatementTexts(tuple(self.variables), *typed)
        left_sides = tuple(self.left_sides)
        trees = StatementTrees(texts.variables, left_sides, self.formulas, self.definitions)
        known = equations, solutions, self.domains, divisors, solve_for, texts, trees
        return Statement(self.name, *known, tuple(self.complexes), tuple(self.functions))

    def _built(self, parser: Parser, formula: FormulaTree) -> sp.Expr:
        """Return SymPy's form of a formula; record its names and its divisors."""
        builder = ExpressionBuilder.after(parser)
        expression = builder.expression(formula)
        self.used |= parser.used
        self.divisors |= dict.fromkeys(d for d in builder.divisors if d.args)
        return expression

    def _ordered_entries(self) -> list[TextPart]:
        """Return the parameters' entries, those that bound the domains of others first."""
        waiting, ordered = list(self.entries), list[TextPart]()

        def is_free(entry: TextPart) -> bool:
            limited = [e.words[0].text for e in waiting if e.index(":") == 1]
            others = {*limited} - {entry.words[0].text}
            return entry.index(":") != 1 or others.isdisjoint(w.text for w in entry.words[2:])

        while waiting:
            ordered.append(next(filter(is_free, waiting), waiting[0]))
            waiting.remove(ordered[-1])
        return ordered

    def _declare(self, entry: TextPart) -> None:
        word = entry.words[0]
        name = word.text
        if word.kind != "name":
            raise entry.error(f"expected a parameter's name, got {word}")
        if name in self.known.reserved:
            got = f"the independent variable {name} (rename the parameter; a variable's domain"
            raise entry.error(f"expected a parameter, got {got} stands in the part domain)")
        if name in FUNCTIONS or name in CONSTANTS or name in ("diff", *RESERVED):
            raise entry.error(f"expected a name of its own, got {word} (rename the parameter)")
        if "_" in name:
            raise entry.error(f"expected a name without _, got {word} (write k1 for k_1)")
        if name in self.names or name in self.functions:
            raise entry.error(f"expected each parameter once, got {word} again")
        sign = entry.words[1]
        if sign.text == "=":
            parser = entry.parser(Vocabulary(FUNCTIONS, names=self.names), 2)
            self.definitions[name] = parser.whole()
            self.names[name] = self._built(parser, self.definitions[name])
        elif [word.text for word in entry.words[1:-1]] in ([":", "complex"], [":", "function"]):
            kind = entry.words[2].text
            if self.targets:
                raise entry.error(f"expected real parameters beside solve, got a {kind} one", 2)
            if kind == "complex":
                self.names[name] = symbol_of(name, REAL)
            (self.complexes if kind == "complex" else self.functions).append(name)
        elif sign.text == ":":
            domain = self._domain(entry, 2, name, {})
            self.names[name] = symbol_of(name, domain)
            self._keep(self.names[name], domain)
        else:
            raise entry.error(f"expected ': domain' or '= expression' behind {name}, got {sign}", 1)
        self.declared[name] = entry

    def _keep(self, symbol: sp.Symbol, domain: Domain) -> None:
        if domain != REAL:
            self.domains[symbol] = domain

    def _domain(
        self, part: TextPart, skipped: int, name: str, variables: Mapping[str, sp.Symbol]
    ) -> Domain:
        """Parse the domain of ``name`` in a part, after the ``skipped`` first words."""
        names = {**self.names, name: sp.Dummy(name, real=True)}
        undeclared = self._real_parameter if part.label == "domain" else None
        vocabulary = Vocabulary(FUNCTIONS, variables, names=names, unknown_name=undeclared)
        parser = part.parser(vocabulary, skipped)
        domain = REAL
        while True:
            place = part.words.index(parser.next)
            try:
                domain &= condition(part, parser, name)
            except FormulaError:
                raise
            except ValueError as error:
                raise part.error(str(error), place) from None
            if not parser.take_sign(","):
                break
        parser.expect_end()
        self.used |= parser.used - {name}
        return inhabited(part, domain, name, place)

    def _make_variables(self, letters: Sequence[str]) -> None:
        """Create the symbols of the variables, with the domains stated in ``domain``."""
        domains: dict[str, Domain] = {}
        plain = {letter: symbol_of(letter, _whole(letter)) for letter in letters}
        for part in self.limits:
            name, domain = self._limited(part, plain)
            try:
                both = domains.get(name, REAL) & domain
            except ValueError as error:
                raise part.error(str(error)) from None
            domains[name] = inhabited(part, both, name)
        for letter in letters:
            self.variables[letter] = symbol_of(letter, domains.get(letter, REAL) & _whole(letter))
        real = {plain[letter]: self.variables[letter] for letter in letters}
        for letter, domain in domains.items():
            domain &= _whole(letter)
            lower, upper = domain.lower.xreplace(real), domain.upper.xreplace(real)
            self._keep(self.variables[letter], replace(domain, lower=lower, upper=upper))

    def _limited(self, part: TextPart, plain: Mapping[str, sp.Symbol]) -> tuple[str, Domain]:
        """Return the name among ``plain`` that the condition ``part`` restricts, and its domain."""
        first: FormulaError | None = None
        for name in self._subjects(part, [*plain]):
            try:
                return name, self._domain(part, 0, name, {k: plain[k] for k in plain if k != name})
            except FormulaError as error:
                first = first or error
        assert first is not None
        raise first

    def _subjects(self, part: TextPart, letters: Sequence[str]) -> list[str]:
        """Return the variables that a condition may restrict: one that is a side, or else all."""
        sides: list[list[Token]] = [[]]
        for word in part.words[:-1]:
            if word.kind == "sign" and word.text in ("<", "<=", ">", ">=", "!="):
                sides.append([])
            else:
                sides[-1].append(word)
        for side in sides:
            if len(side) == 1 and side[0].text in letters:
                return [side[0].text]
        occurring = [word.text for word in part.words[:-1] if word.text in letters]
        if occurring and len(sides) > 1:
            return [*dict.fromkeys(occurring)]
        known = ", ".join(letters) or "none here"
        words = f"expected an inequality of a variable of the equation ({known}), as in t > 0"
        if any(len(side) == 1 and side[0].text in self.names for side in sides):
            words += " (a parameter's domain stands in the part parameters)"
        raise part.error(words)

    def _make_fields(self, indexed: set[str]) -> None:
        for part in self.solutions:
            word = part.words[0]
            name = word.text
            if word.kind != "name" or part.index("=") is None:
                raise part.error(f"expected 'u = formula', got {word}")
            self._check_unknown(part, name)
            if name in self.fields:
                raise part.error(f"expected one solution of {name}, got another")
            self.fields[name] = sp.Function(name)(*self.variables.values())
        for part, place, word in self.known.words():
            base = word.text.partition("_")[0]
            unknown = self.known.is_derivative(word, self.names)
            unknown |= word.kind == "name" and base in indexed
            if unknown and base not in self.fields:
                raise part.error(f"expected a solution of the unknown {base}, got none", place)
            named = word.kind == "name" and base in self.fields and part.label == "equation"
            if named and base in indexed and part.words[place + 1].text != "[":
                raise part.error(f"expected '[' behind the lattice field {word}", place + 1)
        if SITE in self.variables and not indexed:
            part = self.equations[0]
            raise part.error("expected a lattice field such as u[n], got n without one")

    def _check_unknown(self, part: TextPart, name: str) -> None:
        if name in (*self.known.reserved, *CONSTANTS, *FUNCTIONS, *RESERVED) or "_" in name:
            words = f"expected an unknown such as u, got {part.words[0]}"
            others = [letter for letter in self.known.letters(self.names) if letter != name]
            if name in self.known.continuous:
                named = ",".join(others) or ("t" if name == "x" else "x")
                words += f" ({name} is a variable unless others are named: --variables {named})"
            raise part.error(words)
        if name in self.names or name in self.functions:
            raise part.error(f"expected an unknown, got the parameter {name}")

    def _solution(self, part: TextPart) -> tuple[AppliedUndef, sp.Expr]:
        name = part.words[0].text
        equal = part.index("=")
        assert equal is not None
        heading = [word.text for word in part.words[1:equal]]
        if heading not in ([], ["[", SITE, "]"]):
            rows = ROWS if heading[0] == "[" and "," in heading else ""
            raise part.error(f"expected '=' behind {name}, got {part.words[1]}{rows}", 1)
        for place, word in enumerate(part.words[equal + 1 :], equal + 1):
            if word.kind == "name" and word.text.partition("_")[0] in self.fields:
                raise part.error(f"expected a formula without unknowns, got {word}", place)
        parser = part.parser(self._vocabulary(), equal + 1)
        self.formulas[name] = parser.whole()
        return self.fields[name], self._built(parser, self.formulas[name])

    def _equation(self, part: TextPart) -> sp.Expr:
        parser = part.parser(self._vocabulary())
        sides = [parser.formula()]
        if parser.take_sign("="):
            sides.append(parser.formula())
        parser.expect_end()
        left, *right = (self._built(parser, side) for side in sides)
        residual = left - right[0] if right else left
        minus = (Product((MINUS_ONE, side)) for side in sides[1:])
        self.left_sides.append(Sum((sides[0], *minus)) if right else sides[0])
        if not any(isinstance(node, Unknown) for node in self.left_sides[-1].nodes()):
            known = ", ".join(self.fields)
            raise part.error(f"expected an equation for {known}, got one without")
        return residual

    def _vocabulary(self) -> Vocabulary:
        functions = FUNCTIONS | {name: (jet_function(name), 1) for name in self.functions}
        known = functions, self.variables, self.fields, self.names
        return Vocabulary(*known, self._real_parameter, self.variables.get(SITE))

    def _real_parameter(self, name: str) -> sp.Symbol:
        """Return a real symbol for an undeclared name; ValueError if it may mean another name."""
        known = self.names.get(name)  # an inequality is read with a copy of the names
        if isinstance(known, sp.Symbol):
            return known
        if name in MISREAD:
            raise ValueError(f"expected a declared name, got '{name}' ({MISREAD[name]})")
        similar = [k for k in (*self.fields, *self.names) if k.lower() == name.lower()]
        if similar:
            raise ValueError(f"expected a declared name, got '{name}' (did you mean {similar[0]}?)")
        if any(name == part.words[0].text for part in self.solutions):
            raise ValueError(f"expected a variable or parameter, got the unknown {name}")
        if name in RESERVED:
            raise ValueError(f"expected a name of its own, got '{name}' (rename the parameter)")
        if name in FUNCTIONS:
            raise ValueError(f"expected '(' behind the function {name}")
        if remedy := self._misread(name):
            raise ValueError(f"expected a name of its own, got '{name}' (write {remedy})")
        self.names[name] = sp.Symbol(name, real=True)
        return self.names[name]

    def _misread(self, name: str, *, declared: bool = False) -> str | None:
        """Return what to write for a name that looks like a derivative or product, else None."""
        unknowns = [part.words[0].text for part in self.solutions]
        spelling = Spelling(FUNCTIONS, unknowns, self.known.letters(self.names), self.names)
        return misread(name, spelling, declared=declared)

    def _target(self, part: TextPart) -> sp.Symbol:
        """Return the symbol of a parameter to solve for, named by a part of ``solve``."""
        symbol = self.names.get(part.words[0].text)
        if len(part.words) > 2 or not isinstance(symbol, sp.Symbol):
            known = ", ".join(n for n, value in self.names.items() if value.is_Symbol) or "none"
            raise part.error(f"expected a parameter ({known}), got {part.words[0]}")
        return symbol

    def _check_use(self) -> None:
        words = {word.text for part in (*self.solutions, *self.equations) for word in part.words}
        for name, entry in self.declared.items():
            if name not in self.used and not (name in self.functions and name in words):
                raise entry.error(f"expected a parameter that is used, got {name} (leave it out)")
        for part in self.solutions:
            name = part.words[0].text
            if name not in self.used:
                raise part.error(f"expected an unknown of the equations, got {name}")

    def _check_domains(self) -> None:
        """Raise FormulaError for domains that the prover does not accept or that are empty."""
        if not self.domains:
            return
        try:
            sample(settled_domains(self.domains, self.domains), 1)
        except ValueError as error:
            part = (*self.limits, *self.entries)[0]
            raise part.error(str(error)) from None


def _whole(letter: str) -> Domain:
    return WORDS["integer"] if letter == SITE else REAL
