"""A closed form with numbers in, in the lattice's slow variables."""

from collections.abc import Mapping
from functools import cached_property, partial
from typing import Any, Literal, NamedTuple

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike, NDArray

from derive.normal_form import NormalForm
from solutions.closed_form import ClosedForm
from solutions.evaluator import Evaluator, PointEvaluator
from solutions.exact import exact_number
from solutions.linear_phase import LinearPhase
from solutions.pair_machine import scale_rows
from solutions.points import evaluate_points
from solutions.precision import Precision, check_precision
from solutions.reference_evaluation import evaluate_mp
from solutions.special.doubledouble import split
from solutions.variables import Variables, long_number

__all__ = ["Side", "Wave", "WaveValues"]

Array = NDArray[np.float64]
Side = Literal["left", "right"]
Part = Literal["wave", "background", "left", "right"]


class WaveValues(NamedTuple):
    """``Y`` and its derivatives with respect to X and T, arrays of one shape."""

    Y: Array
    Y_X: Array
    Y_T: Array


class Wave:
    """``Y(X, T) = U(a X, b T)`` for a closed form U, a normal form (a, b, s, c) and parameters.

    Parameters are keyword arguments named as in ``form.parameters``; a float means its decimal
    literal. Phases are in double-double; the rest is in double where that keeps the errors of Y,
    Y_X and Y_T below 1e-13 of max(1, |value|), else in double-double (``form.hard`` says where),
    or as ``precision`` asks: "double" or "double-double". ``mp`` is the reference.

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
        *,
        precision: object = None,
        **parameters: object,
    ) -> None:
        if int(normal_form.s) != form.equation.s:
            needed, got = (">", "<") if form.equation.s > 0 else ("<", ">")
            raise ValueError(
                f"K4 must satisfy K4 {needed} 0 for {form.name}, got K4 {got} 0 "
                f"({form.name} solves the {form.equation.name} equation)"
            )
        self.form = form
        self.normal_form = normal_form
        self.parameters: Mapping[sp.Symbol, sp.Expr] = form.check(parameters)
        self._asked = None if precision is None else check_precision(precision)
        self._rates = {name: long_number(getattr(normal_form, name)) for name in ("a", "b", "c")}
        self._scales = tuple(split(rate) for rate in (1, self._rates["a"], self._rates["b"]))
        self._slow = Variables(self._rates["a"], self._rates["b"])

    @cached_property
    def precision(self) -> Precision:
        """The arithmetic that the wave itself is evaluated in."""
        if self._asked is not None:
            return self._asked
        hard = self.form.hard
        return "double" if hard is None else hard.precision(self.parameters)

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
        check_finite(n, t)
        return WaveValues(*self._pairs("wave", self._lattice(eps), n, t))

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
        """Y, Y_X, Y_T at one point as mpf to ``digits`` digits, from the canonical expression."""
        return evaluate_mp(self.form, self.normal_form, self.parameters, X, T, digits)

    @cached_property
    def wavelength(self) -> float | None:
        """The period of the background in X, None if the background is constant."""
        if self.form.period is None:
            return None
        return float(long_number(self.form.period.xreplace(self.parameters)) / self._rates["a"])

    @cached_property
    def constant_background(self) -> float | None:
        """The constant that the wave tends to on both sides, None if there is none."""
        sides = self.form.far_fields
        if self.form.period is not None or sides.left != sides.right:
            return None
        return float(sides.left.xreplace(self.parameters))

    def _lattice(self, eps: float) -> Variables:
        exact = exact_number("eps", eps)
        if exact not in self._lattices:
            if not exact > 0:
                raise ValueError(f"eps must satisfy eps > 0, got {eps} (0.05 is usual)")
            a, b, c = (self._rates[name] for name in ("a", "b", "c"))
            small = long_number(exact)
            self._lattices[exact] = Variables(a * small, b * small**3, -a * c * small)
        return self._lattices[exact]

    def _phases(self, part: Part, variables: Variables) -> list[LinearPhase]:
        key = (part, variables)
        if key not in self._known_phases:
            self._known_phases[key] = self._evaluator(part).phases(variables)
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
        if part == "background":
            return Evaluator(self.form.background, self.parameters)
        if part != "wave":
            return Evaluator(getattr(self.form.far_fields, part), self.parameters)
        if self.form.evaluator is not None:
            return self.form.evaluator(self.parameters)
        return Evaluator(self.form.stable, self.parameters)

    def _evaluate(self, part: Part, variables: Variables, x: ArrayLike, t: ArrayLike) -> WaveValues:
        check_finite(x, t)
        if (self.precision if part == "wave" else self._asked) == "double-double":
            return WaveValues(*self._pairs(part, variables, x, t)[:, 0])
        evaluator = self._evaluator(part)
        phases = self._phases(part, variables)
        U, U_xi, U_tau = evaluate_points(partial(evaluator.double, phases), x, t)
        with np.errstate(under="ignore"):
            return WaveValues(U, float(self._rates["a"]) * U_xi, float(self._rates["b"]) * U_tau)

    def _pairs(self, part: Part, variables: Variables, x: ArrayLike, t: ArrayLike) -> Array:
        """Value and derivatives, high and low parts: an array (3, 2, ...)."""
        evaluator, phases = self._evaluator(part), self._phases(part, variables)
        return scale_rows(evaluate_points(partial(evaluator.pairs, phases), x, t), self._scales)


def check_finite(position: ArrayLike, time: ArrayLike) -> None:
    """Raise ValueError for NaN or infinity."""
    for name, values in (("position", position), ("time", time)):
        if not np.all(np.isfinite(values)):
            raise ValueError(
                f"every {name} must be finite, got NaN or infinity (leave such points out)"
            )


def check_side(side: Side) -> Side:
    """``side``, or a ValueError if it is none."""
    if side not in ("left", "right"):
        raise ValueError(f"side must be 'left' or 'right', got {side!r} (a far field has two)")
    return side
