"""What SymPy simplifies while it reads a text, as hints for a proof of the text as it was typed.

SymPy reads ``sqrt(pi**2*x**2)`` as ``pi*x`` and ``0*tanh(x)`` as 0, and a proof about that has no
step for the root and no generator for tanh.  So generators are sought for all functions in the
texts, and each root and absolute value is said to be what SymPy reads it as, which the checker
shows.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import replace

import sympy as sp

from verify.kernel.limits import digest

from .certificate import make_certificate
from .certificate_writer import Certificate, Data, NodeTable, as_data
from .problem import problem_points
from .statement_problem import all_domains, statement_problem
from .statement_text import read_statement
from .text_names import FUNCTIONS
from .text_writer import Written
from .typed_statement import Statement, StatementTexts

VALUE_OF = {"sqrt": "sqrt", "abs": "abs", "sign": "abs"}
"""The functions that have a value by a hint: sign(f) is f/abs(f)."""

SITE_OF = re.compile(r"\w\[([^\[\],]*)\]")

MOST = 40
"""Functions in the texts."""


def typed_certificate(statement: Statement, number: int) -> Certificate:
    """A certificate of an equation as it was typed, with values for what SymPy simplifies.

    Raises ValueError where there are no such values, or no proof.
    """
    texts = statement.texts
    if texts is None:
        raise ValueError("texts must be those of the statement, got none")
    equation = texts.equations[number - 1]
    one = replace(texts, equations=(equation,))
    calls = list(dict.fromkeys(_calls(one, (*FUNCTIONS, *statement.functions))))
    readings = _readings(one, calls)
    left = statement.equations[number - 1]
    domains = all_domains(statement, left, *readings)
    problem = replace(
        statement_problem(statement, left),
        domains=domains,
        points=problem_points(domains, ()),
        also=readings,
    )
    found = make_certificate(problem)
    proof = _with_values(found["proof"], zip(calls, readings, strict=False), texts)
    body = {**found, "statement": as_data(one), "proof": proof}
    return Certificate(body | {"digest": digest(body)})


def _with_values(
    proof: Data, read: Iterable[tuple[tuple[str, str], sp.Expr]], texts: StatementTexts
) -> Data:
    """The proof with what each root and absolute value is, and logarithms in their own words."""
    formulas, values = [*proof["formulas"]], [*proof["values"]]
    for (name, argument), value in read:
        place = len(formulas)
        if name in VALUE_OF:
            formulas += [f"{VALUE_OF[name]}({argument})", _written(value, texts)]
            values.append([place, place + 1])
        elif name == "log":
            formulas.append(f"log({argument})")
            values.append([place, place])
    return {**proof, "formulas": formulas, "values": values}


def _calls(texts: StatementTexts, functions: Iterable[str]) -> Iterator[tuple[str, str]]:
    """The functions that SymPy may simplify, innermost first, each with its argument's text.

    Those of a lattice's formula stand at each site that occurs.
    """
    call = re.compile(rf"\b({'|'.join(sorted(functions))})\(")
    formulas = dict(text.split(" = ", 1) for text in texts.solutions)
    sites = dict.fromkeys(SITE_OF.findall(" ".join(texts.equations)))
    for text in (*formulas.values(), *texts.equations):
        for found in reversed(list(call.finditer(text))):
            argument = _bracketed(text, found.end())
            for name, formula in formulas.items():
                argument = re.sub(rf"(?<!\w){re.escape(name)}(?![\w\[])", f"({formula})", argument)
            if any(re.search(rf"(?<!\w){name}(?=[_\[])", argument) for name in formulas):
                continue
            yield from ((found[1], re.sub(r"\bn\b", f"({site})", argument)) for site in sites)
            yield found[1], argument


def _bracketed(text: str, start: int) -> str:
    depth, end = 1, start
    while depth:
        depth += (text[end] == "(") - (text[end] == ")")
        end += 1
    return text[start : end - 1]


def _readings(texts: StatementTexts, calls: list[tuple[str, str]]) -> tuple[sp.Expr, ...]:
    """What SymPy makes of each call's value, and then of the arguments of those with one."""
    if not 0 < len(calls) <= MOST:
        raise ValueError(f"texts must have 1 to {MOST} functions, got {len(calls)}")
    heading = texts.solutions[0].split(" = ", 1)[0]
    site = heading[heading.index("[") :] if "[" in heading else ""
    letter = next(c for c in "QWHGPR" if not re.search(rf"\b{c}\d", " ".join(texts.solutions)))
    wanted = [f"{VALUE_OF.get(name, name)}({argument})" for name, argument in calls]
    wanted += [argument for name, argument in calls if FUNCTIONS.get(name, ("", 1))[1] == 1]
    names = [f"{letter}{place}{site}" for place in range(len(wanted))]
    read = read_statement(
        [*texts.equations, *names],
        [*texts.solutions, *(f"{n} = {t}" for n, t in zip(names, wanted, strict=True))],
        "; ".join(texts.parameters),
        "; ".join(texts.domain),
    )
    known = {unknown.func.__name__: formula for unknown, formula in read.solutions.items()}
    return tuple(known[name.removesuffix(site)] for name in names)


def _written(value: sp.Expr, texts: StatementTexts) -> str:
    table = NodeTable()
    place = table.place(value)
    written = Written(table.nodes, [place], (), texts.variables)
    if written.named:
        raise ValueError("values must be short, got one in which a part occurs often")
    return written.text(place)
