"""A closed form with numbers for its parameters, in the lattice's slow variables."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import sympy as sp

from longwave.derive.algebra.exact_numbers import exact_number, instance
from longwave.derive.normal_form import NormalForm
from longwave.solutions.compile.compiler import cached_program
from longwave.solutions.compile.lowering import complex_parts
from longwave.solutions.numeric_wave import Array, NumericWave, Part, Rates, Side, WaveConstants
from longwave.solutions.record import ClosedForm
from longwave.solutions.run.doubledouble import split
from longwave.solutions.run.evaluator import Evaluator, PointEvaluator
from longwave.solutions.run.linear_phase import Variables, long_number
from longwave.solutions.run.reference_evaluation import check_digits, evaluate_mp, exact_point
from longwave.solutions.symbols import s

SETTLED_DIGITS = 40
"""Digits of values from mpmath at points where double-double is not enough."""

SIDES: tuple[Side, Side] = ("left", "right")


class Wave(NumericWave):
    """``Y(X, T) = h U(a X, b T)`` for a closed form U, a normal form and parameters.

    Parameters are keyword arguments named as in ``form.parameters``; a float means its decimal
    literal. Positions and times are exact doubles, any finite number. Y, Y_X and Y_T are within
    1e-13 of max(1, |value|). They are evaluated in double-double with a bound of the error; points
    with too large a bound, next to zeros of huge derivatives or very far away, are evaluated again
    in mpmath. A ValueError is raised for more than ``MOST_UNCERTAIN`` such points, and for a
    coefficient of the formula outside 1e-250 .. 1e250; ``mp`` has no such limits. For NLS values
    are complex, with the same accuracy in real and imaginary part.

    Raises ValueError for bad parameters, and for a normal form of another equation or sign.

    >>> from longwave.derive import mkdv_normal_form
    >>> from longwave.solutions import closed_form
    >>> wave = Wave(closed_form("soliton_dn"), mkdv_normal_form(K2=1, K4=1), k=0.7)
    >>> round(float(wave(0.0, 0.0).Y), 12)  # 2 + sqrt(1 - k**2)
    2.714142842854
    """

    def __init__(self, form: ClosedForm, normal_form: NormalForm, **parameters: object) -> None:
        instance("form", form, ClosedForm, "closed_form('kink') is one")
        instance("normal_form", normal_form, NormalForm, "mkdv_normal_form(K2=1, K4=1) is one")
        _check_equation(form, normal_form)
        self.form = form
        self.normal_form = normal_form
        self.parameters: Mapping[sp.Symbol, sp.Expr] = form.check(parameters)
        for sign in form.equation.free_sign:
            self.parameters = {**self.parameters, sign: normal_form.s}
        super().__init__(self._all_numbers(), self._make_evaluator, self._settled)

    def __reduce__(self) -> tuple[Callable[..., "Wave"], tuple[Any, ...]]:
        arguments = {p.name: self.parameters[p.symbol] for p in self.form.parameters}
        return _wave_of, (self.form, self.normal_form, arguments)

    def _all_numbers(self) -> WaveConstants:
        form, normal_form = self.form, self.normal_form
        rates = Rates(*(long_number(getattr(normal_form, name)) for name in Rates._fields))
        wavelength, constant = None, None
        left, right = (self._with_numbers(getattr(form.far_fields, side)) for side in SIDES)
        if form.period is not None:
            wavelength = float(long_number(self._with_numbers(form.period)) / rates.a)
        elif left == right and left.is_number and left.is_real:
            constant = float(normal_form.h * left)
        return WaveConstants(
            form.name,
            form.equation.normal,
            form.equation.order,
            form.equation.is_complex,
            rates,
            float(normal_form.a),
            float(normal_form.b),
            int(normal_form.s),
            wavelength,
            constant,
            form.period is not None and form.background == 0,
        )

    def _with_numbers(self, expression: sp.Expr) -> sp.Expr:
        return expression.xreplace(dict(self.parameters))

    def __repr__(self) -> str:
        parameters_text = "".join(f", {name} = {value}" for name, value in self.parameters.items())
        scales = {n: value for n, value in self.normal_form.values.items() if n not in "sr"}
        rates = ", ".join(f"{name} = {value}" for name, value in scales.items())
        image = self.normal_form.map_text.partition(" = ")[2]
        return f"<Wave {self.form.name}{parameters_text}: Y = {image} with {rates}>"

    def _repr_latex_(self) -> str | None:
        """The formula, for notebooks."""
        return self.form._repr_latex_()

    def mp(self, X: object, T: object, digits: int = 50, *, Z: object = None) -> tuple[Any, ...]:
        """Return Y, Y_X, Y_T at one point as mpf of ``digits`` digits, by the canonical expression.

        For KP the point is (X, T, Z), and Y_Z is returned too; for NLS the values are mpc. Raises
        ValueError for points that are not finite real numbers and for bad ``digits``.
        """
        return self._exact("wave", None, _exact_coordinates("XTZ", X, T, Z), digits)

    def mp_at(
        self, n: object, t: object, eps: object, digits: int = 50, *, m: object = None
    ) -> tuple[Any, ...]:
        """Return the values of `mp` at site n and lattice time t."""
        point = _exact_coordinates("ntm", n, t, m)
        return self._exact("wave", self._lattice(eps).eps, point, digits)

    def mp_jets(
        self, X: object, T: object, highest: int, digits: int = 50, *, Z: object = None
    ) -> tuple[Any, ...]:
        """Return Y and its X derivatives to the order ``highest`` at one point as mpf."""
        return self._exact("wave", None, _exact_coordinates("XTZ", X, T, Z), digits, highest)

    def _make_evaluator(self, part: Part) -> PointEvaluator:
        special_evaluator = self.form.evaluator if part == "wave" else None
        try:
            if special_evaluator is not None:
                return special_evaluator(self.parameters)
            source: Part = "wave" if part == "formula" else part
            expressions = partial(self._real_parts, source)
            program = cached_program(self.form, source, expressions, tuple(self.parameters))
            return Evaluator(program, tuple(self.parameters.values()))
        except OverflowError as error:
            raise ValueError(self._out_of_range(error)) from None

    def _real_parts(self, part: Part) -> Sequence[sp.Expr]:
        """Return the expression to compile for a part; two, real and imaginary, if complex."""
        expression = self.form.stable if part == "wave" else self._expression(part)
        return complex_parts(expression) if self.form.equation.is_complex else [expression]

    def _expression(self, part: Part) -> sp.Expr:
        """Return the canonical expression of a part."""
        if part in ("wave", "formula"):
            return self.form.expression
        if part == "potential":
            if self.form.potential is None:
                raise ValueError(
                    f"form must be one with a potential, got {self.form.name} (waves of KP have "
                    "one; others have an antiderivative)"
                )
            return self.form.potential
        return self.form.background if part == "background" else getattr(self.form.far_fields, part)

    def _out_of_range(self, error: OverflowError) -> str:
        given = ", ".join(f"{name} = {sp.N(v, 6)}" for name, v in self.parameters.items())
        return (
            f"parameters and eps must keep every coefficient within 1e-250 .. 1e250, got {error} "
            f"for {given or self.form.name} (use Wave.mp, or less extreme ones)"
        )

    def _settled(
        self, part: Part, variables: Variables, *point: float, highest: int | None = None
    ) -> Array:
        """Return value and derivatives at one point from mpmath: high parts, low parts, bounds.

        With ``highest``, return the value and its X derivatives up to that order instead.
        """
        names = ("position", "time", "transverse coordinate")
        named = zip(names, point, strict=False)
        coordinates = [exact_point(name, float(coordinate)) for name, coordinate in named]
        exact = self._exact(part, variables.eps, coordinates, SETTLED_DIGITS, highest)
        if self.numbers.is_complex:
            exact = (*(value.real for value in exact), *(value.imag for value in exact))
        rows = np.array([(*split(value), 0.0) for value in exact])
        if not np.all(np.isfinite(rows)):
            where = ", ".join(f"{coordinate:g}" for coordinate in point)
            raise ValueError(
                f"Y, Y_X and Y_T must be doubles, got one beyond 1e308 at ({where}) (use Wave.mp)"
            )
        return rows

    def _exact(
        self,
        part: Part,
        eps: object,
        point: Sequence[sp.Expr],
        digits: int,
        highest: int | None = None,
    ) -> tuple[Any, ...]:
        form = self.normal_form
        if (len(point) == 3) != self.numbers.is_planar:
            self._points(0.0, 0.0, None if len(point) == 2 else 0.0)
        variables = form.a, form.b, -form.a * form.drift, form.e
        if eps is not None:
            exact = exact_number("eps", eps)
            time_rate = exact**self.numbers.order
            frame_rate = -form.a * form.c * exact - form.a * form.drift * time_rate
            variables = form.a * exact, form.b * time_rate, frame_rate, form.e * exact**2
        rates = [sp.S.One, form.a, form.b, form.e][: len(point) + 1]
        if highest is not None:
            rates = [form.a**order for order in range(highest + 1)]
        scales = [form.h * rate for rate in rates]
        arguments = self._expression(part), self.parameters, variables, scales, point
        return evaluate_mp(*arguments, check_digits(digits), drift=form.drift, highest=highest)


def _wave_of(form: ClosedForm, normal_form: NormalForm, parameters: Mapping[str, Any]) -> Wave:
    """Rebuild a pickled wave."""
    return Wave(form, normal_form, **parameters)


def _check_equation(form: ClosedForm, normal_form: NormalForm) -> None:
    """Raise ValueError for a normal form that is symbolic, or of another equation than the form."""
    equation = form.equation
    if normal_form.equation != equation.normal:
        raise ValueError(
            f"normal_form must be of the {equation.normal} equation for {form.name}, got one of "
            f"the {normal_form.equation} equation (longwave list waves has the waves of each)"
        )
    for name in ("a", "b", "s", "c", "h", "e", "r", "drift"):
        if not (value := getattr(normal_form, name)).is_number:
            raise ValueError(
                f"{name} of normal_form must be a number, got {value} (give K2 and K4 values)"
            )
    solves = f"{form.name} solves the {equation.name} equation"
    if equation.normal == "mKdV" and normal_form.s != equation.s:
        needed, got = (">", "<") if equation.s > 0 else ("<", ">")
        raise ValueError(
            f"K4 must satisfy K4 {needed} 0 for {form.name}, got K4 {got} 0 ({solves})"
        )
    for name in "sr":
        needed, got = getattr(equation, name), getattr(normal_form, name)
        if needed not in (s, got):
            raise ValueError(f"{name} must be {needed} for {form.name}, got {got} ({solves})")


def _exact_coordinates(names: str, x: object, t: object, z: object) -> list[sp.Expr]:
    """Return position, time and any transverse coordinate exactly; errors use the ``names``."""
    coordinates = (x, t) if z is None else (x, t, z)
    return [exact_point(name, value) for name, value in zip(names, coordinates, strict=False)]
