"""The evaluation of a closed form as a program: value and derivatives, of both parts if complex.

The lowered expression (``solutions.compile.lowering``) becomes a tape with derivatives
(``solutions.compile.tape``), and the tape bytecode for the machine. A program is kept on disk
(``solutions.data_store``) under the name of the closed form, whose expression need not be made
then; for others than the catalogue's, the expression is the key.
"""

from __future__ import annotations

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


def kept_program(
    form: ClosedForm,
    part: str,
    expressions: Callable[[], Sequence[sp.Expr]],
    parameters: Parameters,
) -> Program:
    """The program of a part of a closed form: from disk, or compiled and kept there.

    ``expressions`` makes the part's real expressions; it is not called if the program is there.
    """
    if form.module:
        key = f"{form.name} {part} {parameters}"
    else:
        key = f"{sp.srepr(tuple(expressions()))} {sp.srepr(parameters)}"
    across = form.equation.has_across
    return kept_data(__name__, key, lambda: compile_program(expressions(), parameters, across))


def compile_program(
    expressions: Sequence[sp.Expr], parameters: Parameters, has_across: bool = False
) -> Program:
    """Compile real ``expressions`` in xi, tau, zeta and ``parameters``.

    Without zeta there is no derivative in it, either: ``has_across`` is the equation's.
    """
    lowering = Lowering()
    tape, outputs = tape_of(
        lowering, [lowering.lower(expression) for expression in expressions], has_across
    )
    phases, calls = tuple(lowering.phases.values()), tuple(lowering.calls.values())
    jacobi = [symbol for call in calls for symbol in call.symbols]
    assembler = Assembler([*(phase.symbol for phase in phases), *jacobi])
    for symbol, right in tape.lines:
        assembler.define(symbol, right)
    bytecode = assembler.assemble([assembler.value(output) for output in outputs])
    back = {symbol: constant for constant, symbol in lowering.constants.items()}
    used = set().union(*(right.free_symbols for _, right in tape.lines))
    fixed = [
        *(entry.xreplace(back) for entry in bytecode.pool),
        *(c for phase in phases for c in phase[1:]),
        *(call.m for call in calls),
    ]
    places = [phase.symbol for phase in phases]
    return Program(
        phases=len(phases),
        calls=[places.index(call.phase) for call in calls],
        wanted=[[s in used for s in call.symbols] for call in calls],
        bytecode=replace(bytecode, pool=()),
        fixed=MpmathFormula.of(parameters, fixed),
    )
