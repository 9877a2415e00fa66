"""A reduction as plain text for the terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from sympy import Expr

from derive.lattice import Bond, Lattice, Stencil
from derive.output.notation import text_of
from derive.scaling import SlowVariable

if TYPE_CHECKING:
    from derive.reduction import Reduction


def text_report(reduction: Reduction) -> str:
    """Ansatz, orders, conditions, reduced equation, corrections, one a line."""
    return "\n".join(_lines(reduction))


def _lines(reduction: Reduction) -> Iterator[str]:
    yield reduction.lattice.title
    yield from (f"  {line}" for line in equations_of_motion(reduction.lattice))
    yield f"ansatz: {ansatz(reduction)}"
    yield ""
    yield "orders of the lattice equation:"
    for order in range(min(reduction.orders), reduction.highest_order + 1):
        equation = reduction.orders.get(order)
        yield f"  eps^{order}: {equation.text() if equation else '0 = 0'}"
    yield ""
    sound = reduction.sound_condition
    yield f"sound condition: {text_of(sound.lhs)} = {text_of(sound.rhs)}"
    yield from (f"condition: {condition.text()}" for condition in reduction.conditions)
    yield f"reduced equation (order eps^{reduction.scaling.leading_order}):"
    yield f"  {reduction.pde.text()}"
    yield from _beyond(reduction)


def _beyond(reduction: Reduction) -> Iterator[str]:
    notation = reduction.notation
    for order, part in reduction.remainders.items():
        yield f"left in the lattice equation at eps^{order} by an exact solution of it:"
        yield f"  R{order} = {notation.text(part)}"
    for power, part in reduction.corrections.items():
        yield f"correction of the reduced equation, Y_T = ... + eps^{power} F{power}:"
        yield f"  F{power} = {notation.text(part)}"
    if reduction.obstruction:
        power, part = reduction.obstruction
        yield f"no local correction at eps^{power}: this is not an X-derivative:"
        yield f"  {notation.text(part)}"


def equations_of_motion(lattice: Lattice) -> Iterator[str]:
    """The lattice's equations in plain text, from its bonds.

    >>> from derive.models.lattices import FPUT_STRAIN
    >>> next(equations_of_motion(FPUT_STRAIN))
    "y_n'' = F(y_{n+1}) - 2 F(y_n) + F(y_{n-1})"
    """
    many = len(lattice.bonds) > 1
    labels = [f"F{number if many else ''}" for number, _ in enumerate(lattice.bonds, 1)]
    for index, name in enumerate(lattice.fields):
        mass = "" if lattice.masses[index] == 1 else f"{text_of(lattice.masses[index])} "
        forces = [
            (entry.weight, f"{label}({_stretch(lattice, bond, entry)})")
            for label, bond in zip(labels, lattice.bonds, strict=True)
            for entry in bond.action
            if entry.field == index
        ]
        yield f"{mass}{name}_n'' = {_weighted(forces)}"
    for label, bond in zip(labels, lattice.bonds, strict=True):
        yield f"{label}(x) = {_force(bond)}"


def _force(bond: Bond) -> str:
    """The force by rising powers of x."""
    powers = [
        f"{_wrapped(value)} x{f'^{power}' if power > 1 else ''}" if power else text_of(value)
        for power, value in enumerate(reversed(bond.coefficients()))
        if value != 0
    ]
    return " + ".join(powers)


def _wrapped(value: Expr) -> str:
    return f"({text_of(value)})" if value.is_Add else text_of(value)


def _stretch(lattice: Lattice, bond: Bond, at: Stencil) -> str:
    parts = []
    for entry in bond.stretch:
        cell = [i + j for i, j in zip(entry.shift, at.shift, strict=True)]
        parts.append((entry.weight, f"{lattice.fields[entry.field]}_{_cell(cell)}"))
    return _weighted(parts)


def _cell(shift: Sequence[int]) -> str:
    """``n`` or ``{n+1}``; further axes follow as ``{n+1,m}``."""
    names = [f"{axis}{step:+d}" if step else axis for axis, step in zip("nml", shift, strict=False)]
    joined = ",".join(names)
    return joined if len(joined) == 1 else f"{{{joined}}}"


def _weighted(parts: Iterable[tuple[int, str]]) -> str:
    result = ""
    for weight, body in parts:
        size = body if abs(weight) == 1 else f"{abs(weight)} {body}"
        sign = "-" if weight < 0 else "+"
        result += f" {sign} {size}" if result else (f"-{size}" if weight < 0 else size)
    return result


def ansatz(reduction: Reduction) -> str:
    """The ansatz in plain text, from the scaling."""
    scaling = reduction.scaling
    name = reduction.lattice.fields[0]
    mean = "".join(f"{_power(p)}{_wrapped(value)} + " for p, value in scaling.background)
    slow = ", ".join(f"{v.name} = {_power(v.exponent)}({phase(v)})" for v in scaling.space)
    arguments = ", ".join(scaling.axes)
    return (
        f"{name} = {mean}{_power(scaling.amplitude)}Y({arguments}), {slow}, "
        f"T = {_power(scaling.time)}t"
    )


def phase(variable: SlowVariable) -> str:
    """What a slow variable is, apart from its power of eps.

    >>> from derive.symbols import c
    >>> phase(SlowVariable("X", 1, (-2,), -c))
    '-2 n + c t'
    """
    parts = [(step, axis) for step, axis in zip(variable.direction, "nml", strict=False) if step]
    if variable.speed != 0:
        backwards = variable.speed.could_extract_minus_sign()
        size = -variable.speed if backwards else variable.speed
        parts.append((1 if backwards else -1, f"{_wrapped(size)} t"))
    return _weighted(parts)


def _power(exponent: int) -> str:
    return "" if exponent == 0 else "eps " if exponent == 1 else f"eps^{exponent} "
