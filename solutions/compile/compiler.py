"""Compilation of a closed form to a program: value and derivatives, of both parts if complex.

The lowered expression (``solutions.compile.lowering``) becomes a tape with derivatives
(``solutions.compile.tape``), and the tape becomes bytecode for the machine. Programs are cached
on disk (``solutions.data_store``) by the name of the closed form, so that its expression need not
be built; forms outside the catalogue are cached by their expression.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import sympy as sp

from longwave.solutions.compile.assembler import Assembler
from longwave.solutions.compile.lowering import Lowering
from longwave.solutions.compile.tape import tape_of
from longwave.solutions.data_store import kept_data
from longwave.solutions.functions.multiprecision import MpmathFormula
from longwave.solutions.record import ClosedForm
from longwave.solutions.run.program import Program

Parameters = tuple[sp.Symbol, ...]


def cached_program(
    form: ClosedForm,
    part: str,
    expressions: Callable[[], Sequence[sp.Expr]],
    parameters: Parameters,
) -> Program:
    """Return the program of a part of a closed form, from the disk cache or compiled.

    ``expressions`` returns the part's real expressions; it is called only to compile the program,
    and to identify a form outside the catalogue.
    """
    if form.module:
        key = f"{form.name} {part} {parameters}"
    else:
        key = f"{sp.srepr(tuple(expressions()))} {sp.srepr(parameters)}"
    is_planar = form.equation.has_across
    return kept_data(__name__, key, lambda: compile_program(expressions(), parameters, is_planar))


def compile_program(
    expressions: Sequence[sp.Expr], parameters: Parameters, has_across: bool = False
) -> Program:
    """Compile real ``expressions`` in xi, tau, zeta and ``parameters``.

    With ``has_across``, for an equation with a transverse variable, it has zeta derivatives too.
    """
    lowering = Lowering()
    lowered = [lowering.lower(expression) for expression in expressions]
    tape, outputs = tape_of(lowering, lowered, has_across)
    phases, calls = tuple(lowering.phases.values()), tuple(lowering.calls.values())
    jacobi = [symbol for call in calls for symbol in call.symbols]
    assembler = Assembler([*(phase.symbol for phase in phases), *jacobi])
    for symbol, right in tape.lines:
        assembler.define(symbol, right)
    bytecode = assembler.assemble([assembler.value(output) for output in outputs])
    to_constants = {symbol: constant for constant, symbol in lowering.constants.items()}
    used = set().union(*(right.free_symbols for _, right in tape.lines))
    fixed = [
        *(entry.xreplace(to_constants) for entry in bytecode.pool),
        *(c for phase in phases for c in phase[1:]),
        *(call.m for call in calls),
    ]
    phase_symbols = [phase.symbol for phase in phases]
    return Program(
        phases=len(phases),
        calls=[phase_symbols.index(call.phase) for call in calls],
        requested=[[s in used for s in call.symbols] for call in calls],
        bytecode=replace(bytecode, pool=()),
        fixed=MpmathFormula.of(parameters, fixed),
    )
