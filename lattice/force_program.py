"""Force laws as short numeric programs, which arrays are evaluated with and kernels compiled from.

A program is a sequence of stack instructions, built from a SymPy expression of known functions; no
text is ever evaluated.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import count
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.polynomial import Polynomial, legendre
from numpy.typing import NDArray

if TYPE_CHECKING:
    from sympy import Expr

Array = NDArray[np.float64]

Instruction = tuple[str, float]
"""Name of an operation, and its operand, which is 0 except for "number" and "power"."""

UNARY: dict[str, Callable[[Array], Array]] = {
    "exp": np.exp, "log": np.log, "sin": np.sin, "cos": np.cos, "tan": np.tan,
    "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh, "atan": np.arctan, "asinh": np.arcsinh,
    "contact": lambda x: np.maximum(x, 0.0), "touching": lambda x: np.heaviside(x, 0.0),
}  # fmt: skip
"""Functions of one argument that a force may contain."""

QUADRATURE_POINTS = 24
"""Number of points of the quadrature rule that integrates a force to its potential."""

SMOOTH_DEGREE = 8
"""Highest degree at which 65 samples of a polynomial's slope give the largest slope to a few
percent."""

SUMMAND_CHANGE = 2.0**-20
"""Relative change applied to a summand to measure how strongly the force depends on it."""

SLOPE_SAMPLES, MAX_OPEN_PANELS, MAX_DIVISIONS, MIN_EXCESS = 65, 2**12, 9, 0.1
"""For enclosing slopes: number of initial edges, largest number of panels divided by 16 at once,
largest number of divisions, and fraction by which a slope must exceed the sampled ones to count."""


@dataclass(frozen=True)
class ForceProgram:
    """A force law: a polynomial's ``coefficients`` of x, x^2, ..., or stack ``instructions``.

    Calling it with stretches gives forces; ``slope`` gives their derivative, ``potential`` their
    integral from 0. At the stretch ``opening`` a contact opens: the slope, or its derivative,
    jumps.

    >>> from sympy import exp
    >>> from longwave.derive.symbols import x
    >>> law = force_program(exp(x) - 1)
    >>> float(law(np.array(0.0))), float(law.slope(np.array(0.0)))
    (0.0, 1.0)
    >>> force_program(2*x + 3*x**3).coefficients
    (2.0, 0.0, 3.0)
    """

    coefficients: tuple[float, ...] = ()
    instructions: tuple[Instruction, ...] = ()
    slope_instructions: tuple[Instruction, ...] = ()
    opening: float | None = None

    @property
    def is_linear(self) -> bool:
        """Whether the force is proportional to the stretch."""
        return not self.instructions and not any(self.coefficients[1:])

    @cached_property
    def _slope(self) -> tuple[float, ...]:
        return tuple(Polynomial([0.0, *self.coefficients]).deriv().coef.tolist())

    @cached_property
    def _integral(self) -> tuple[float, ...]:
        return tuple(Polynomial([0.0, *self.coefficients]).integ().coef.tolist())

    @cached_property
    def _stored_unstretched(self) -> Array:
        """Integral of the force from the contact's opening to zero stretch."""
        return self._from_opening(np.zeros(()))

    def __call__(self, stretch: Array) -> Array:
        """Return the force at these stretches."""
        if self.instructions:
            return _run(self.instructions, stretch)
        return _horner((0.0, *self.coefficients), stretch)

    def slope(self, stretch: Array) -> Array:
        """Return the force's derivative at these stretches."""
        if self.instructions:
            return _run(self.slope_instructions, stretch)
        return _horner(self._slope, stretch)

    def enclosed(self, low: Array, high: Array) -> tuple[Array, Array]:
        """Return bounds of the program's values on the intervals from ``low`` to ``high``.

        >>> from sympy import exp
        >>> from longwave.derive.symbols import x
        >>> low, high = program_of(exp(-(x**2))).enclosed(np.array([-1.0]), np.array([1.0]))
        >>> low.round(2).tolist(), high.round(2).tolist()
        ([0.37], [1.0])
        """
        return _enclosed(self.instructions, low, high)

    def slope_enclosed(self, low: Array, high: Array) -> tuple[Array, Array]:
        """Return bounds of the slope on the intervals from ``low`` to ``high``, maybe infinite.

        >>> low, high = ForceProgram((1.0, 0.0, 1.0)).slope_enclosed(np.zeros(1), np.ones(1))
        >>> low.tolist(), high.tolist()
        ([1.0], [4.0])
        """
        with np.errstate(all="ignore"):
            if self.instructions:
                least, most = _enclosed(self.slope_instructions, low, high)
            else:
                least = most = np.zeros_like(low)
                for factor in self._slope[::-1]:
                    least, most = _hull(least * low, least * high, most * low, most * high)
                    least, most = least + factor, most + factor
        return np.nan_to_num(least, nan=-np.inf, neginf=-np.inf, posinf=np.inf), np.nan_to_num(
            most, nan=np.inf, neginf=-np.inf, posinf=np.inf
        )

    @property
    def is_smooth(self) -> bool:
        """Whether the force is a polynomial whose slope is described by a few samples."""
        return not self.instructions and len(self.coefficients) <= SMOOTH_DEGREE

    def steepest_between(self, low: float, high: float, sampled: float) -> float:
        """Return the largest abs(slope) between two stretches, given the largest sampled one.

        The result is ``sampled`` unless the slope exceeds it by more than the fraction
        `MIN_EXCESS`, and infinite if the slope is unbounded.
        """
        if self.is_smooth or not low < high:
            return sampled
        edges, largest = np.linspace(low, high, SLOPE_SAMPLES), sampled
        lows, highs = edges[:-1], edges[1:]
        for _ in range(MAX_DIVISIONS):
            bounds = np.maximum(*map(np.abs, self.slope_enclosed(lows, highs)))
            [open_panels] = np.nonzero(~(bounds <= (1.0 + MIN_EXCESS) * largest))
            if open_panels.size == 0 or open_panels.size > MAX_OPEN_PANELS:
                break
            parts = np.linspace(lows[open_panels], highs[open_panels], 17)
            lows, highs = parts[:-1].ravel(), parts[1:].ravel()
            with np.errstate(all="ignore"):
                largest = np.fmax(largest, np.nanmax(np.abs(self.slope(parts)), initial=0.0))
        else:
            is_bounded = self.opening is None or not np.all(
                (lows[:, None] <= self.opening) & (self.opening <= highs[:, None])
            )
            bounds = np.maximum(*map(np.abs, self.slope_enclosed(lows, highs)))
            largest = float(bounds.max()) if is_bounded else largest
        return float(largest) if largest > (1.0 + MIN_EXCESS) * sampled else sampled

    def largest_summand(self, stretch: Array) -> float:
        """Return the largest summand whose rounding affects the force.

        A summand is reduced by the factor by which the force depends on it, if that is below 1. The
        result is 0 for a polynomial, whose terms vanish with the stretch.

        >>> ForceProgram((), (("x", 0.0), ("exp", 0.0), ("number", -1.0), ("add", 0.0))
        ... ).largest_summand(np.array([-1e-9, 1e-9]))
        1.000000001
        """
        sizes: list[Array] = []

        def recording_add(a: Array, b: Array) -> Array:
            sizes.append(np.maximum(np.abs(a), np.abs(b)))
            return a + b

        force, largest = _run(self.instructions, stretch, recording_add), 0.0
        for index, size in enumerate(sizes):
            if not float(np.max(size)) <= largest:
                change = SUMMAND_CHANGE * size
                response = np.abs(self._with_sum_changed(index, change, stretch) - force)
                is_damped = response < (1.0 - 1e-3) * change
                effective = np.where(is_damped, response / SUMMAND_CHANGE, size)
                largest = max(largest, float(np.max(effective)))
        return largest

    def _with_sum_changed(self, index: int, change: Array, stretch: Array) -> Array:
        """Return the forces after adding ``change`` to the program's sum number ``index``."""
        indices = count()

        def changing_add(a: Array, b: Array) -> Array:
            return a + b + (change if next(indices) == index else 0.0)

        return _run(self.instructions, stretch, changing_add)

    def potential(self, stretch: Array) -> Array:
        """Return the energy stored at these stretches, 0 at zero stretch."""
        if not self.instructions:
            return _horner(self._integral, stretch)
        if self.opening is not None:
            return np.asarray(self._from_opening(stretch) - self._stored_unstretched)
        nodes, weights = _quadrature()
        parts = (w / 2 * self(stretch * (1 + z) / 2) for z, w in zip(nodes, weights, strict=True))
        return np.asarray(stretch * sum(parts))

    def _from_opening(self, stretch: Array) -> Array:
        """Return the force's integral from the opening, by Gauss's rule in sqrt(distance)."""
        assert self.opening is not None
        nodes, weights = _quadrature()
        distance, roots = stretch - self.opening, (1 + nodes) / 2
        forces = self(self.opening + np.multiply.outer(roots**2, distance))
        return np.asarray(distance * np.tensordot(weights * roots, forces, 1))


def _horner(coefficients: Sequence[float], x: Array) -> Array:
    """Return a polynomial's values by Horner's rule, bit for bit those of `Polynomial`."""
    total = coefficients[-1] + 0.0 * x
    for coefficient in coefficients[-2::-1]:
        total = coefficient + total * x
    return np.asarray(total)


def _enclosed(program: tuple[Instruction, ...], low: Array, high: Array) -> tuple[Array, Array]:
    """Return bounds of a program's values by interval arithmetic."""
    stack: list[tuple[Array, Array]] = []
    for word, number in program:
        if word in ("x", "number"):
            stack.append((low, high) if word == "x" else (np.full_like(low, number),) * 2)
            continue
        a, b = stack.pop()
        if word == "add":
            c, d = stack.pop()
            stack.append((a + c, b + d))
        elif word == "multiply":
            c, d = stack.pop()
            stack.append(_hull(a * c, a * d, b * c, b * d))
        else:
            stack.append(_power(a, b, number) if word == "power" else _unary(word, a, b))
    return stack.pop()


def _hull(*values: Array) -> tuple[Array, Array]:
    """Return the least and the largest of several arrays, element by element."""
    return np.minimum.reduce(values), np.maximum.reduce(values)


def _power(a: Array, b: Array, power: float) -> tuple[Array, Array]:
    """Return bounds of x**power for x from ``a`` to ``b``."""
    whole, even = power.is_integer(), power % 2.0 == 0.0
    a = a if whole else np.maximum(a, 0.0)
    low, high = _hull(a**power, b**power)
    inside = (a <= 0.0) & (b >= 0.0)
    if power < 0.0:
        least = -np.inf if whole and not even else low
        return np.where(inside, least, low), np.where(inside, np.inf, high)
    return (np.where(inside & even, 0.0, low), high)


def _unary(word: str, a: Array, b: Array) -> tuple[Array, Array]:
    """Return bounds of the function named ``word`` for arguments from ``a`` to ``b``."""
    low, high = _hull(UNARY[word](a), UNARY[word](b))
    if word == "cosh":
        low = np.where((a < 0.0) & (b > 0.0), 1.0, low)
    elif word in ("sin", "cos"):
        crest = 0.25 if word == "sin" else 0.0
        for turn, end in ((crest, 1.0), (crest + 0.5, -1.0)):
            met = np.floor(b / (2.0 * np.pi) - turn) > np.floor(a / (2.0 * np.pi) - turn)
            low, high = (
                np.where(met, end, bound) if end * s > 0 else bound
                for s, bound in ((-1.0, low), (1.0, high))
            )
    elif word == "tan":
        met = np.floor(b / np.pi - 0.5) > np.floor(a / np.pi - 0.5)
        low, high = np.where(met, -np.inf, low), np.where(met, np.inf, high)
    return low, high


@cache
def _quadrature() -> tuple[Array, Array]:
    """Return nodes and weights of Gauss's rule on -1 .. 1."""
    return legendre.leggauss(QUADRATURE_POINTS)


def force_program(force: Expr) -> ForceProgram:
    """Compile a force in ``derive.symbols.x`` whose constants are numbers.

    Raises ValueError for a function that is not in `UNARY`, for constants without a value, and for
    a polynomial that does not vanish at 0.
    """
    from sympy import Poly

    from longwave.derive.symbols import x

    unknown = sorted(map(str, force.free_symbols - {x}))
    if unknown:
        raise ValueError(f"force must have numbers as constants, got {unknown[0]} (give its value)")
    if force.is_polynomial(x):
        coefficients = [float(value) for value in reversed(Poly(force, x).all_coeffs())]
        if coefficients[0] != 0.0:
            raise ValueError(
                f"force must vanish without stretch, got {coefficients[0]:g} (move the zero of x)"
            )
        return ForceProgram(tuple(coefficients[1:]))
    slope = tuple(_instructions(force.diff(x)))
    return ForceProgram((), tuple(_instructions(force)), slope, _opening(force))


def _opening(force: Expr) -> float | None:
    """Return the stretch at which the contacts of a force open; None if it has no contacts."""
    from sympy import Poly

    from longwave.derive.algebra.contact import contact
    from longwave.derive.symbols import x

    gaps = [part.args[0] for part in force.atoms(contact)]
    if not gaps:
        return None
    linear = all(gap.is_polynomial(x) and Poly(gap, x).degree() == 1 for gap in gaps)
    openings = {float(-gap.subs(x, 0) / gap.diff(x)) for gap in gaps} if linear else set()
    if len(openings) != 1:
        raise ValueError(
            f"contacts of a force must all open at one stretch, got {force} (use one bond for each "
            "contact, and gaps that are linear in x)"
        )
    return openings.pop()


def program_of(expression: Expr) -> ForceProgram:
    """Compile any formula in ``derive.symbols.x``; it need not vanish at 0."""
    from longwave.derive.symbols import x

    slope = tuple(_instructions(expression.diff(x)))
    return ForceProgram((), tuple(_instructions(expression)), slope)


def _instructions(expression: Any) -> list[Instruction]:
    """Return the expression's instructions in postfix order."""
    from sympy import Add, Mul, Pow, exp, log

    if expression.is_Symbol:
        return [("x", 0.0)]
    if expression.is_number:
        if not expression.is_real:
            raise ValueError(f"numbers in a formula must be real, got {expression} (change it)")
        return [("number", float(expression))]
    if isinstance(expression, Add | Mul):
        word = "add" if isinstance(expression, Add) else "multiply"
        first, *others = expression.args
        instructions = _instructions(first)
        for other in others:
            instructions += [*_instructions(other), (word, 0.0)]
        return instructions
    if isinstance(expression, Pow) and expression.exp.is_number:
        return [*_instructions(expression.base), ("power", float(expression.exp))]
    if isinstance(expression, Pow):
        return _instructions(exp(expression.exp * log(expression.base)))
    name = type(expression).__name__
    if name not in UNARY or len(expression.args) != 1:
        raise ValueError(
            f"force must be built from {', '.join(UNARY)} and powers, got {name} (rewrite it)"
        )
    return [*_instructions(expression.args[0]), (name, 0.0)]


def _run(
    instructions: tuple[Instruction, ...], x: Array, add: Callable[[Any, Any], Any] = operator.add
) -> Array:
    """Run a program on the stretches ``x``; ``add`` computes its sums."""
    stack: list[Any] = [] if instructions else [x]
    for word, number in instructions:
        if word == "x":
            stack.append(x)
        elif word == "number":
            stack.append(np.float64(number))
        elif word == "add":
            other = stack.pop()
            stack[-1] = add(stack[-1], other)
        elif word == "multiply":
            other = stack.pop()
            stack[-1] = stack[-1] * other
        elif word == "power":
            stack[-1] = stack[-1] ** number
        else:
            stack[-1] = UNARY[word](stack[-1])
    return np.broadcast_to(np.asarray(stack.pop(), dtype=np.float64), np.shape(x))
