"""Functions of which all derivatives are free: arbitrary ones, and theta functions of a nome q.

Of a theta function in z, f_zz = -4 q f_q (the heat equation).
"""

from __future__ import annotations

from flint import acb, acb_series, arb, ctx, fmpq

from ..axioms import FUNCTIONS, Function
from ..derivations import RATES, Slopes
from ..field import Field, rule
from ..node_balls import BALLS
from ..reading import THETA
from ..ring import Element

Jet = tuple[str, int]
"""The name of a function and the order of a derivative."""

FUNCTIONS["jet"] = Function("regular", free=True)
FUNCTIONS["theta"] = Function("regular", letters="zq", free=True, below_one=True, above_zero=True)


def rate(slopes: Slopes, field: Field, node: int, variable: int) -> Element:
    """The derivative along a variable, by the chain rule."""
    name, z, *nome, (label, order) = field.nodes.all[node]
    total = field.zero
    inner = slopes.rate(z, variable)
    if not inner.is_zero:
        total = inner * field.made(name, z, *nome, (label, order + 1))
    for q in nome:
        turn = slopes.rate(q, variable)
        if not turn.is_zero:
            share = turn / (field.ring.number(-4) * field.image(q))
            total = total + share * field.made(name, z, q, (label, order + 2))
    return total


RATES |= {"jet": rate, "theta": rate}


@rule("theta")
def turned(field: Field, node: int) -> Element | None:
    """The first theta function is odd, the others are even, if that of -z is a generator."""
    _, z, q, (label, order) = field.nodes.all[node]
    found = field.known(field.nodes.made("theta", field.nodes.negative(z), q, (label, order)))
    return found if found is None or (label == THETA[0]) == (order % 2 == 1) else -found


def theta_ball(z: acb, q: acb, jet: Jet) -> acb:
    """A derivative of a theta function."""
    label, order = jet
    tau = q.log() / (acb(0, 1) * acb.pi())
    values = (z / acb.pi()).modular_theta(tau, order)
    return values[THETA.index(label)] / acb.pi() ** order


def jet_ball(z: acb, jet: Jet) -> acb:
    """A derivative of one function that is generic: 1/gamma at a shift.

    It satisfies no algebraic differential equation.
    """
    label, order = jet
    place = z + acb(arb(generic_shift(label)))
    terms, ctx.cap = ctx.cap, order + 1  # FLINT's series take the terms beyond for 0
    series = acb_series([place, 1], order + 1).rgamma()
    ctx.cap = terms
    return series[order] * acb(order + 1).gamma()


def generic_shift(label: str) -> fmpq:
    """The number s of a name: what stands for any function f is f(z) = 1/gamma(z + s)."""
    return fmpq(sum(map(ord, label)) % 89, 97)


BALLS |= {"theta": theta_ball, "jet": jet_ball}
