"""Exact proof that a rational closed form solves its equation, in the lab variables.

The residual's numerator is formed as a polynomial in X, T and the generators of K2 and K4
(`verify.lab`); it is the zero polynomial or it is not.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import sympy as sp
from flint import fmpq, fmpq_mpoly

from solutions.closed_form import ClosedForm
from verify.fraction import Jet, NotRationalError, Ring, differentiate
from verify.lab import LabEquation, lab_frame
from verify.terms import field_derivatives, residual_terms
from verify.tree import distinct_nodes
from verify.verdict import Outcome, Verdict

METHOD = "exact polynomial"


@dataclass(frozen=True)
class ExactResidual:
    """The residual ``numerator / denominator**power`` in the ring's generators."""

    ring: Ring
    numerator: fmpq_mpoly
    denominator: fmpq_mpoly
    power: int

    def value(self, point: Iterable[fmpq]) -> fmpq | None:
        """The residual at a rational point, None where the denominator vanishes."""
        coordinates = tuple(point)
        bottom = self.denominator(*coordinates)
        return None if bottom == 0 else self.numerator(*coordinates) / bottom**self.power


def is_rational(form: ClosedForm) -> bool:
    """Whether ``form`` is a rational function with rational coefficients of all its symbols.

    Such a form is proved here; every other one is checked by `verify.residual`.
    """
    return all(_keeps_rationality(node) for node in distinct_nodes(form.expression))


def _keeps_rationality(node: sp.Expr) -> bool:
    integer_power = node.is_Pow and node.exp.is_Integer
    return bool(node.is_Add or node.is_Mul or node.is_Symbol or node.is_Rational or integer_power)


def exact_residual(form: ClosedForm) -> ExactResidual:
    """The residual of ``form`` in X, T and the generators of K2 and K4, put together exactly.

    Raises NotRationalError if the form is not rational or its denominator vanishes identically.
    """
    frame = lab_frame(form.equation.s)
    equation = LabEquation(frame)
    free = sorted((parameter.symbol for parameter in form.parameters), key=str)
    ring = Ring([equation.xi, equation.tau, *frame.generators, *free])
    lab = form.expression.xreplace({form.equation.xi: frame.xi, form.equation.tau: frame.tau})
    numerator, denominator = ring.fraction(lab)
    terms, field = residual_terms(equation)
    jets = {
        derivative: _jet(derivative, numerator, denominator)
        for derivative in field_derivatives(terms, field)
    }
    products = [_term(term, jets, ring) for term in terms]
    power = max(product.power for product in products)
    total = ring.constant(0)
    for product in products:
        total = total + product.numerator * denominator ** (power - product.power)
    return ExactResidual(ring, total, denominator, power)


def _jet(derivative: sp.Expr, numerator: fmpq_mpoly, denominator: fmpq_mpoly) -> Jet:
    jet = Jet(numerator, 1)
    for variable in getattr(derivative, "variables", ()):
        jet = differentiate(jet, denominator, str(variable))
    return jet


def _term(term: sp.Expr, jets: dict[sp.Expr, Jet], ring: Ring) -> Jet:
    """The product of a coefficient and powers of jets."""
    coefficient, factors = term.as_independent(*jets, as_Add=False)
    numerator, power = ring.polynomial(coefficient), 0
    for base, exponent in factors.as_powers_dict().items():
        jet = jets[base]
        numerator = numerator * jet.numerator ** int(exponent)
        power += jet.power * int(exponent)
    return Jet(numerator, power)


def check_rational(form: ClosedForm) -> Verdict:
    """PROVED if the residual's numerator is the zero polynomial, else REFUTED at a rational point.

    UNDECIDED, with the reason, for a form that is not rational.
    """
    start = time.perf_counter()
    try:
        findings = _judge(exact_residual(form), _generators_in_words(form))
    except NotRationalError as error:
        findings = {"outcome": Outcome.UNDECIDED, "detail": str(error)}
    seconds = time.perf_counter() - start
    return Verdict(form.name, form.equation.name, METHOD, **findings, seconds=seconds)


def _generators_in_words(form: ClosedForm) -> str:
    constants = lab_frame(form.equation.s).constants().items()
    relations = ", ".join(f"{name} = {value}" for name, value in constants)
    free = "".join(f", {parameter.name}" for parameter in form.parameters)
    return f"X, T, c, a{free} ({relations})"


def _judge(residual: ExactResidual, generators: str) -> dict[str, Any]:
    size = len(residual.numerator)
    if size == 0:
        shape = f"denominator: power {residual.power} of {len(residual.denominator)} terms, not 0"
        detail = f"zero polynomial in {generators}; {shape}"
        return {"outcome": Outcome.PROVED, "detail": detail, "residual": 0.0}
    point, value = _witness(residual)
    witness = {
        str(symbol): str(coordinate)
        for symbol, coordinate in zip(residual.ring.generators, point, strict=True)
    }
    return {
        "outcome": Outcome.REFUTED,
        "detail": f"polynomial of {size} terms in {generators}, not 0",
        "residual": abs(float(Fraction(int(value.p), int(value.q)))),
        "witness": witness,
    }


def _witness(residual: ExactResidual) -> tuple[tuple[fmpq, ...], fmpq]:
    """A rational point with positive coordinates and the residual there, which is not 0.

    A polynomial of degree d in each generator cannot vanish on a grid of more than d points a
    side, so the search ends.
    """
    side = 1 + max(residual.numerator.degrees()) + max(residual.denominator.degrees())
    values = [fmpq(n, 2) for n in range(1, side + 2)]
    for point in itertools.product(values, repeat=len(residual.ring.generators)):
        value = residual.value(point)
        if value:
            return point, value
    raise AssertionError("a polynomial that is not zero vanished on a grid wider than its degree")
