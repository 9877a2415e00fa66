"""A closed form with numbers in, in the lattice's slow variables."""

from collections.abc import Mapping
from functools import cached_property, partial
from typing import Any, Literal, NamedTuple

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike, NDArray

from derive.algebra.exact_numbers import exact_number, instance
from derive.normal_form import NormalForm
from solutions.compile.compiler import kept_program
from solutions.points import check_points, evaluate_points
from solutions.record import ClosedForm
from solutions.run.doubledouble import split
from solutions.run.linear_phase import LinearPhase, Variables, long_number
from solutions.run.machine import scale_rows
from solutions.run.program import Evaluator, PointEvaluator
from solutions.run.reference_evaluation import check_digits, evaluate_mp, exact_point

__all__ = ["Side", "Wave", "WaveValues"]

Array = NDArray[np.float64]
Side = Literal["left", "right"]
Part = Literal["wave", "background", "left", "right"]

CERTAIN = 5e-14
"""Largest bound of an error, in units of max(1, |value|), that double-double may leave."""

SETTLED_DIGITS = 40
MOST_UNCERTAIN = 1000
"""Points with larger bounds that mpmath settles, at 5 to 100 ms each; more are refused."""


class WaveValues(NamedTuple):
    """``Y`` and its derivatives with respect to X and T, arrays of one shape."""

    Y: Array
    Y_X: Array
    Y_T: Array


class Wave:
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
        a, b = normal_form.a, normal_form.b
        self._slow = Variables(a, b, sp.S.Zero)
        self._scales = tuple(split(long_number(rate)) for rate in (sp.S.One, a, b))

    def __repr__(self) -> str:
        given = "".join(f", {name} = {value}" for name, value in self.parameters.items())
        rates = ", ".join(f"{n} = {getattr(self.normal_form, n)}" for n in "ab")
        return f"<Wave {self.form.name}{given}: Y = U(a X, b T) with {rates}>"

    def _repr_latex_(self) -> str:
        """The formula, as notebooks show it."""
        return self.form._repr_latex_()

    def __call__(self, X: ArrayLike, T: ArrayLike) -> WaveValues:
        """Y, Y_X, Y_T at the broadcast points (X, T)."""
        return self._evaluate("wave", self._slow, X, T)

    def at(self, n: ArrayLike, t: ArrayLike, eps: float) -> WaveValues:
        """Y, Y_X, Y_T at site n (any real) and lattice time t.

        The phases are formed in double-double from (n, t, eps); ``X = eps (n - c t)`` and
        ``T = eps**3 t`` are never rounded.
        """
        return self._evaluate("wave", self._lattice(eps), n, t)

    def pairs_at(self, n: ArrayLike, t: ArrayLike, eps: float) -> WaveValues:
        """``at`` in double-double: arrays (2, ...) of high and low parts, about 30 digits."""
        return WaveValues(*self._bounded("wave", self._lattice(eps), n, t)[:, :2])

    def phase_zeros(self, t: float, eps: float) -> list[float]:
        """The sites at which one of the wave's phases vanishes at lattice time t, ascending.

        The crest of a localised wave is near one of them.
        """
        zeros = {phase.zero(t) for phase in self._phases("wave", self._lattice(eps))}
        return sorted(zero for zero in zeros if zero is not None)

    def background(self, X: ArrayLike, T: ArrayLike) -> WaveValues:
        """The bare background wave of the same phase (or the constant) at (X, T)."""
        return self._evaluate("background", self._slow, X, T)

    def background_at(self, n: ArrayLike, t: ArrayLike, eps: float) -> WaveValues:
        """``background`` at site n and lattice time t."""
        return self._evaluate("background", self._lattice(eps), n, t)

    def far_field(self, X: ArrayLike, T: ArrayLike, side: Side) -> WaveValues:
        """What the wave tends to as X goes to -infinity ("left") or +infinity ("right")."""
        return self._evaluate(check_side(side), self._slow, X, T)

    def far_field_at(self, n: ArrayLike, t: ArrayLike, eps: float, side: Side) -> WaveValues:
        """``far_field`` at site n and lattice time t."""
        return self._evaluate(check_side(side), self._lattice(eps), n, t)

    def mp(self, X: object, T: object, digits: int = 50) -> tuple[Any, Any, Any]:
        """Y, Y_X, Y_T at one point as mpf to ``digits`` digits, from the canonical expression.

        Raises ValueError for points that are no finite real numbers and for bad ``digits``.
        """
        point = exact_point("X", X), exact_point("T", T)
        return self._exact("wave", self._slow, point, check_digits(digits))

    def mp_at(self, n: object, t: object, eps: object, digits: int = 50) -> tuple[Any, Any, Any]:
        """``mp`` at site n and lattice time t."""
        point = exact_point("n", n), exact_point("t", t)
        return self._exact("wave", self._lattice(eps), point, check_digits(digits))

    @cached_property
    def wavelength(self) -> float | None:
        """The period of the background in X, None if the background is constant."""
        if self.form.period is None:
            return None
        return float(
            long_number(self.form.period.xreplace(self.parameters))
            / long_number(self.normal_form.a)
        )

    @cached_property
    def constant_background(self) -> float | None:
        """The constant that the wave tends to on both sides, None if there is none."""
        sides = self.form.far_fields
        if self.form.period is not None or sides.left != sides.right:
            return None
        return float(sides.left.xreplace(self.parameters))

    def _lattice(self, eps: object) -> Variables:
        exact = exact_number("eps", eps)
        if exact not in self._lattices:
            if not exact > 0:
                raise ValueError(f"eps must satisfy eps > 0, got {eps} (0.05 is usual)")
            a, b, c = self.normal_form.a, self.normal_form.b, self.normal_form.c
            self._lattices[exact] = Variables(a * exact, b * exact**3, -a * c * exact)
        return self._lattices[exact]

    def _phases(self, part: Part, variables: Variables) -> list[LinearPhase]:
        key = (part, variables)
        if key not in self._known_phases:
            try:
                self._known_phases[key] = self._evaluator(part).phases(variables)
            except OverflowError as error:
                raise ValueError(self._out_of_range(error)) from None
        return self._known_phases[key]

    @cached_property
    def _lattices(self) -> dict[sp.Expr, Variables]:
        return {}

    @cached_property
    def _known_phases(self) -> dict[tuple[Part, Variables], list[LinearPhase]]:
        return {}

    @cached_property
    def _evaluators(self) -> dict[Part, PointEvaluator]:
        return {}

    def _evaluator(self, part: Part) -> PointEvaluator:
        if part not in self._evaluators:
            self._evaluators[part] = self._make_evaluator(part)
        return self._evaluators[part]

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

    def _evaluate(self, part: Part, variables: Variables, x: ArrayLike, t: ArrayLike) -> WaveValues:
        return WaveValues(*self._bounded(part, variables, x, t)[:, 0])

    def _bounded(self, part: Part, variables: Variables, x: ArrayLike, t: ArrayLike) -> Array:
        """Value and derivatives: high parts, low parts, bounds of their errors (3, 3, ...)."""
        x, t = check_points(x, t)
        phases = self._phases(part, variables)
        rows = evaluate_points(partial(self._evaluator(part), phases), x, t)
        rows = scale_rows(rows, self._scales)
        with np.errstate(invalid="ignore"):
            certain = rows[:, 2] <= CERTAIN * np.maximum(1, np.abs(rows[:, 0]))
        uncertain = np.argwhere(~np.all(certain, axis=0))
        if len(uncertain) > MOST_UNCERTAIN:
            first = tuple(uncertain[0])
            raise ValueError(
                f"at most {MOST_UNCERTAIN} points may need more than double-double, got "
                f"{len(uncertain)}, the first at ({x[first]:g}, {t[first]:g}) (use Wave.mp there)"
            )
        for place in map(tuple, uncertain):
            rows[(slice(None), slice(None), *place)] = self._settled(
                part, variables, x[place], t[place]
            )
        return rows

    def _settled(self, part: Part, variables: Variables, x: float, t: float) -> Array:
        """Value and derivatives at one point from mpmath: high parts, low parts, bounds."""
        point = exact_point("position", float(x)), exact_point("time", float(t))
        exact = self._exact(part, variables, point, SETTLED_DIGITS)
        rows = np.array([(*split(value), 0.0) for value in exact])
        if not np.all(np.isfinite(rows)):
            raise ValueError(
                f"Y, Y_X and Y_T must be doubles, got one beyond 1e308 at ({x:g}, {t:g}) "
                "(use Wave.mp)"
            )
        return rows

    def _exact(
        self, part: Part, variables: Variables, point: tuple[sp.Expr, sp.Expr], digits: int
    ) -> tuple[Any, Any, Any]:
        rates = self.normal_form.a, self.normal_form.b
        expression = self._expression(part)
        return evaluate_mp(expression, self.parameters, variables, rates, point, digits)


def check_side(side: Side) -> Side:
    """``side``, or a ValueError if it is none."""
    if side not in ("left", "right"):
        raise ValueError(f"side must be 'left' or 'right', got {side!r} (a far field has two)")
    return side
