"""`prove` for texts and for SymPy objects: the verdict, or the constants for which it holds."""

from __future__ import annotations

from typing import Any

from longwave.verify.verdict import ProofVerdict

from . import prover
from .conditions import solve_statement
from .statement_text import read_statement
from .statement_verdict import Progress, StatementVerdict, decide_statement
from .typed_statement import Statement
from .weak import decide_weak


def prove(
    equation: Any,
    solution: Any,
    *,
    parameters: str = "",
    domain: str = "",
    solve: str = "",
    variables: str = "",
    weak: bool = False,
    **options: Any,
) -> ProofVerdict:
    """Decide whether a formula solves an equation, both in text or both as SymPy objects.

    Texts follow `verify.proof.statement_text`, with ``parameters``, ``domain`` and ``name``.
    ``solve`` names parameters, as in ``c, b``; the answer then has the values for which it holds.
    ``variables`` names the independent variables instead of x, y, z and t, as in ``r, t``.
    With ``weak`` the equation is in conservation form, and conditions at a jump are decided too.
    SymPy objects and their options are those of `verify.proof.prover.prove`.

    Raises FormulaError for a text that cannot be read, and as `verify.proof.prover.prove` does.

    >>> prove("u_t + c*u_x", "u = sin(x - c*t)").outcome
    <Outcome.PROVED: 'PROVED'>
    >>> prove("u_x - 1", "u = sqrt(x**2)").outcome, prove("u_x - 1", "u = x").outcome
    (<Outcome.REFUTED: 'REFUTED'>, <Outcome.PROVED: 'PROVED'>)
    >>> print(prove("u_t + u_x", "u = exp(x - c*t)", solve="c").detail)
    holds if and only if c = 1
    """
    textual = [_is_text(equation), _is_text(solution)]
    if not any(textual):
        if given := parameters or domain or solve or variables or weak:
            words = "parameters, domain, solve, variables and weak must be left out with SymPy"
            raise ValueError(f"{words} objects, got {given!r} (state the equation in text)")
        return prover.prove(equation, solution, **options)
    if not all(textual):
        got = "text and a SymPy object (write both as text)"
        raise TypeError(f"equation and solution must both be text or SymPy objects, got {got}")
    wrong = sorted(options.keys() - {"name"})
    if wrong:
        known = "parameters, domain, solve, variables, weak and name"
        got = f"{wrong[0]} (say it in parameters)"
        raise TypeError(f"options beside texts must be {known}, got {got}")
    texts = equation, solution, parameters, domain
    statement = read_statement(*texts, solve=solve, variables=variables, weak=weak, **options)
    return answer(statement)


def answer(statement: Statement, progress: Progress = lambda _: None) -> StatementVerdict:
    """Decide a statement, or find the values of its ``solve_for`` parameters for which it holds."""
    decide = solve_statement if statement.solve_for else decide_statement
    return (decide_weak if statement.weak else decide)(statement, progress)


def _is_text(given: object) -> bool:
    parts = given if isinstance(given, (list, tuple)) else [given]
    return all(isinstance(part, str) for part in parts)
