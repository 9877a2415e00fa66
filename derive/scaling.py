"""The ansatz as data: amplitude, slow variables, frame speed, mean; the paper's eq. (7)."""

import re
from dataclasses import dataclass
from functools import partial

from sympy import Expr, S, Symbol

from longwave.derive.algebra.exact_numbers import integer, tuple_of
from longwave.derive.algebra.formula_printing import Printed, latex_of, text_of
from longwave.derive.output import notation
from longwave.derive.symbols import c, check_constants, eps, rational_function
from longwave.support.user_files import shown


@dataclass(frozen=True)
class SlowVariable:
    """``name = eps^exponent (direction . cell - speed t)``.

    The direction's entries are numbers or constants, one for each axis of the lattice: (1,) is
    along a chain, (C, S) oblique on a square lattice.
    """

    name: str
    exponent: int
    direction: tuple[Expr, ...]
    speed: Expr

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not re.fullmatch(r"[A-Za-z]", self.name):
            raise ValueError(f"name must be one letter, got {shown(self.name)} (X is usual)")
        hint = "slow variables carry a positive power of eps"
        integer(f"exponent of {self.name}", self.exponent, 1, hint)
        label = f"direction of {self.name}"
        steps = tuple_of(label, self.direction, object, "(1,) is along a chain")
        direction = tuple(rational_function(label, step) for step in steps)
        object.__setattr__(self, "direction", direction)
        if not any(direction):
            raise ValueError(f"{label} must not be all 0, got {direction} ((1,) is along a chain)")
        object.__setattr__(self, "speed", rational_function(f"speed of {self.name}", self.speed))
        for name, value in (("speed", self.speed), *(("direction", step) for step in direction)):
            if value.has(eps):
                raise ValueError(
                    f"{name} of {self.name} must not depend on eps, got {value} (slower drifts are "
                    "terms of the reduced equation)"
                )

    def phase(self, printed: Printed = text_of) -> str:
        """Return ``direction . cell - speed t`` as text or LaTeX.

        >>> SlowVariable("X", 1, (-2,), -c).phase()
        '-2 n + c t'
        """
        parts: list[tuple[int, str]] = []
        for step, axis in (*zip(self.direction, "nml", strict=False), (-self.speed, "t")):
            is_negative = step.could_extract_minus_sign()
            magnitude = -step if is_negative else step
            name = axis if magnitude == 1 else f"{notation.bracketed(magnitude, printed)} {axis}"
            parts += [(-1 if is_negative else 1, name)] if step else []
        return notation.weighted_sum(parts)


@dataclass(frozen=True, repr=False)
class Scaling(notation.Displayed):
    """``field = background + eps^amplitude Y(space, T)`` with ``T = eps^time t``.

    ``background`` lists (exponent, value) pairs, each adding ``eps^exponent value``.  The frame
    speed, that of the first slow variable, is a positive symbol, or its negative for waves to the
    left; speeds of further variables are numbers, or symbols for drifts that the reduction finds.
    For displacements ``eps^amplitude W`` is the displacement, and Y = W_X the strain of a cell.
    Raises ValueError for an invalid ansatz.  The default is the paper's: ``y = eps Y``,
    ``X = eps (n - c t)``, ``T = eps^3 t`` (the paper's eq. (7)).

    >>> Scaling().leading_order
    5
    """

    amplitude: int = 1
    space: tuple[SlowVariable, ...] = (SlowVariable("X", 1, (1,), c),)
    time: int = 3
    background: tuple[tuple[int, Expr], ...] = ()

    def __post_init__(self) -> None:
        integer("time", self.time, 1, "T carries a positive power of eps")
        integer("amplitude", self.amplitude, 0, "0 is a wave of order one")
        usual = 'SlowVariable("X", 1, (1,), c) is the default'
        object.__setattr__(self, "space", tuple_of("space", self.space, SlowVariable, usual))
        names = [variable.name for variable in self.space]
        if len({*names, "T", "Y"}) != len(names) + 2:
            raise ValueError(
                f"space must hold variables with different names, other than T and Y, got "
                f"{names} (X is usual)"
            )
        if self.frame_symbol is None:
            raise ValueError(
                f"speed of {names[0]} must be a positive symbol or minus one, got {self.speed} "
                "(take longwave.derive.symbols.c: the reduction finds its value; -c is the other "
                "direction)"
            )
        example = "((0, ybar),) is a uniform strain"
        pairs = self.background and tuple_of("background", self.background, tuple, example)
        for pair in pairs:
            if len(pair) != 2:
                raise ValueError(
                    f"background must hold pairs (exponent, value), got {shown(pair)} ({example})"
                )
        mean = tuple((power, rational_function("background", value)) for power, value in pairs)
        object.__setattr__(self, "background", mean)
        for exponent, value in self.background:
            integer("exponent of background", exponent, 0, "0 is a mean of order one")
            if value.has(self.frame_symbol):
                raise ValueError(
                    f"background must not depend on the speed {self.frame_symbol}, got {value} "
                    "(write it in the lattice's constants)"
                )
        check_constants(self.constants)

    @property
    def frame_symbol(self) -> Symbol | None:
        """The positive symbol c of a frame speed c or -c; None for any other speed."""
        symbol = -self.speed if self.speed.could_extract_minus_sign() else self.speed
        return symbol if isinstance(symbol, Symbol) and symbol.is_positive else None

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the slow variables, time last."""
        return (*(variable.name for variable in self.space), "T")

    @property
    def drifts(self) -> tuple[Symbol, ...]:
        """Symbols that are the speeds of further slow variables."""
        speeds = (variable.speed for variable in self.space[1:])
        return tuple(speed for speed in speeds if isinstance(speed, Symbol))

    @property
    def mean(self) -> Expr:
        """The background in one expression, with its powers of eps."""
        return sum((eps**power * value for power, value in self.background), S.Zero)

    @property
    def leading_order(self) -> int:
        """Power of eps at which the wave's mixed derivative in X and T enters."""
        return self.amplitude + self.space[0].exponent + self.time

    @property
    def speed(self) -> Expr:
        """The frame speed along the first slow variable."""
        return self.space[0].speed

    @property
    def constants(self) -> tuple[Symbol, ...]:
        """Symbols in speeds and background, sorted by name; eps does not count as a constant."""
        space_parts = (part for v in self.space for part in (v.speed, *v.direction))
        expressions = (*space_parts, *(value for _, value in self.background))
        symbols = {symbol for expression in expressions for symbol in expression.free_symbols}
        return tuple(sorted(symbols - {eps}, key=str))

    def text(self, field: str = "y", wave: str = "Y") -> str:
        """Return the ansatz for a lattice's ``field`` in plain text.

        >>> Scaling().text()
        'y = eps Y(X, T), X = eps (n - c t), T = eps^3 t'
        """
        return ", ".join(self._parts(field, wave, text_of))

    def latex(self, field: str = "y", wave: str = "Y") -> str:
        """Return the ansatz in LaTeX, without delimiters."""
        return r",\; ".join(self._parts(field, wave, latex_of))

    def _parts(self, field: str, wave: str, printed: Printed) -> list[str]:
        small = partial(notation.power_of, eps, printed=printed)
        terms = ((p, notation.bracketed(value, printed)) for p, value in self.background)
        mean = "".join(f"{small(power)}{text} + " for power, text in terms)
        wave_text = f"{small(self.amplitude)}{wave}({', '.join(self.axes)})"
        phases = [v.phase(printed) for v in self.space]
        factors = (f"({phase})" if " " in phase else phase for phase in phases)
        pairs = zip(self.space, factors, strict=True)
        slow = (f"{v.name} = {small(v.exponent)}{factor}" for v, factor in pairs)
        return [f"{field} = {mean}{wave_text}", *slow, f"T = {small(self.time)}t"]
