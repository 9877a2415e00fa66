"""A closed form with numbers in, in the lattice's slow variables."""

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import sympy as sp

from derive.algebra.exact_numbers import exact_number, instance
from derive.normal_form import NormalForm
from solutions.compile.compiler import kept_program
from solutions.numeric_wave import Array, NumericWave, Part, Side, WaveNumbers, WaveValues
from solutions.record import ClosedForm
from solutions.run.doubledouble import split
from solutions.run.linear_phase import Variables, long_number
from solutions.run.program import Evaluator, PointEvaluator
from solutions.run.reference_evaluation import check_digits, evaluate_mp, exact_point

__all__ = ["Side", "Wave", "WaveValues"]

SETTLED_DIGITS = 40


class Wave(NumericWave):
    """``Y(X, T) = U(a X, b T)`` for a closed form U, a normal form (a, b, s, c) and parameters.

    Parameters are keyword arguments named as in ``form.parameters``; a float means its decimal
    literal. Positions and times are the doubles that they are: anything finite. Y, Y_X and Y_T are
    within 1e-13 of max(1, |value|), by construction: everything is evaluated in double-double with
    a bound of its error, and the points where that bound is too large, next to zeros of huge
    derivatives or very far away, are evaluated again in mpmath. Where those are more than
    ``MOST_UNCERTAIN``, or a coefficient of the formula leaves 1e-250 .. 1e250, a ValueError says
    so. ``mp`` has no such limits.

    Raises ValueError for bad parameters and if the normal form has the wrong sign s.

    >>> from derive import mkdv_normal_form
    >>> from solutions import closed_form
    >>> wave = Wave(closed_form("soliton_dn"), mkdv_normal_form(K2=1, K4=1), k=0.7)
    >>> round(float(wave(0.0, 0.0).Y), 12)  # 2 + sqrt(1 - k**2)
    2.714142842854
    """

    def __init__(
        self,
        form: ClosedForm,
        normal_form: NormalForm,
        **parameters: object,
    ) -> None:
        instance("form", form, ClosedForm, "closed_form('kink') is one")
        instance("normal_form", normal_form, NormalForm, "mkdv_normal_form(K2=1, K4=1) is one")
        for name in ("a", "b", "s"):
            if not (value := getattr(normal_form, name)).is_number:
                raise ValueError(
                    f"{name} of normal_form must be a number, got {value} (give K2 and K4 values)"
                )
        if normal_form.s != form.equation.s:
            needed, got = (">", "<") if form.equation.s > 0 else ("<", ">")
            raise ValueError(
                f"K4 must satisfy K4 {needed} 0 for {form.name}, got K4 {got} 0 "
                f"({form.name} solves the {form.equation.name} equation)"
            )
        self.form = form
        self.normal_form = normal_form
        self.parameters: Mapping[sp.Symbol, sp.Expr] = form.check(parameters)
        super().__init__(self._all_numbers(), self._make_evaluator, self._settled)

    def _all_numbers(self) -> WaveNumbers:
        form, normal_form = self.form, self.normal_form
        rates = normal_form.a, normal_form.b, normal_form.c
        a, b, c = map(long_number, rates)
        wavelength, constant = None, None
        if form.period is not None:
            wavelength = float(long_number(form.period.xreplace(dict(self.parameters))) / a)
        elif form.far_fields.left == form.far_fields.right:
            constant = float(form.far_fields.left.xreplace(dict(self.parameters)))
        return WaveNumbers(
            form.name,
            (a, b, c),
            float(normal_form.a),
            float(normal_form.b),
            int(normal_form.s),
            wavelength,
            constant,
            form.period is not None and form.background == 0,
        )

    def __repr__(self) -> str:
        given = "".join(f", {name} = {value}" for name, value in self.parameters.items())
        rates = ", ".join(f"{n} = {getattr(self.normal_form, n)}" for n in "ab")
        return f"<Wave {self.form.name}{given}: Y = U(a X, b T) with {rates}>"

    def _repr_latex_(self) -> str:
        """The formula, as notebooks show it."""
        return self.form._repr_latex_()

    def mp(self, X: object, T: object, digits: int = 50) -> tuple[Any, Any, Any]:
        """Y, Y_X, Y_T at one point as mpf to ``digits`` digits, from the canonical expression.

        Raises ValueError for points that are no finite real numbers and for bad ``digits``.
        """
        point = exact_point("X", X), exact_point("T", T)
        return self._exact("wave", None, point, check_digits(digits))

    def mp_at(self, n: object, t: object, eps: object, digits: int = 50) -> tuple[Any, Any, Any]:
        """``mp`` at site n and lattice time t."""
        point = exact_point("n", n), exact_point("t", t)
        return self._exact("wave", self._lattice(eps).eps, point, check_digits(digits))

    def _make_evaluator(self, part: Part) -> PointEvaluator:
        own = self.form.evaluator if part == "wave" else None
        try:
            if own is not None:
                return own(self.parameters)
            make = partial(getattr, self.form, "stable")
            if part != "wave":
                make = partial(self._expression, part)
            program = kept_program(self.form, part, make, tuple(self.parameters))
            return Evaluator(program, tuple(self.parameters.values()))
        except OverflowError as error:
            raise ValueError(self._out_of_range(error)) from None

    def _expression(self, part: Part) -> sp.Expr:
        """The canonical expression of a part."""
        if part == "wave":
            return self.form.expression
        return self.form.background if part == "background" else getattr(self.form.far_fields, part)

    def _out_of_range(self, error: OverflowError) -> str:
        given = ", ".join(f"{name} = {sp.N(v, 6)}" for name, v in self.parameters.items())
        return (
            f"parameters and eps must keep every coefficient within 1e-250 .. 1e250, got {error} "
            f"for {given or self.form.name} (use Wave.mp, or less extreme ones)"
        )

    def _settled(self, part: Part, variables: Variables, x: float, t: float) -> Array:
        """Value and derivatives at one point from mpmath: high parts, low parts, bounds."""
        point = exact_point("position", float(x)), exact_point("time", float(t))
        exact = self._exact(part, variables.eps, point, SETTLED_DIGITS)
        rows = np.array([(*split(value), 0.0) for value in exact])
        if not np.all(np.isfinite(rows)):
            raise ValueError(
                f"Y, Y_X and Y_T must be doubles, got one beyond 1e308 at ({x:g}, {t:g}) "
                "(use Wave.mp)"
            )
        return rows

    def _exact(
        self, part: Part, eps: object, point: tuple[sp.Expr, sp.Expr], digits: int
    ) -> tuple[Any, Any, Any]:
        a, b, c = self.normal_form.a, self.normal_form.b, self.normal_form.c
        variables = a, b, sp.S.Zero
        if eps is not None:
            exact = exact_number("eps", eps)
            variables = a * exact, b * exact**3, -a * c * exact
        expression = self._expression(part)
        return evaluate_mp(expression, self.parameters, variables, (a, b), point, digits)
