"""The ansatz as data: amplitude, slow variables, frame speed, mean; the paper's eq. (7)."""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, Symbol

from derive.symbols import c


@dataclass(frozen=True)
class SlowVariable:
    """``name = eps^exponent (direction . cell - speed t)``."""

    name: str
    exponent: int
    direction: tuple[int, ...]
    speed: Expr


@dataclass(frozen=True)
class Scaling:
    """``field = background + eps^amplitude Y(space, T)`` with ``T = eps^time t``.

    ``background`` lists (exponent, value) pairs, each adding ``eps^exponent value``.  The default
    is the paper's ansatz ``y = eps Y``, ``X = eps (n - c t)``, ``T = eps^3 t`` (eq. "multi-scale
    variables").

    >>> Scaling().leading_order
    5
    """

    amplitude: int = 1
    space: tuple[SlowVariable, ...] = (SlowVariable("X", 1, (1,), c),)
    time: int = 3
    background: tuple[tuple[int, Expr], ...] = ()

    def __post_init__(self) -> None:
        positive = {"time": self.time, **{v.name: v.exponent for v in self.space}}
        for name, exponent in positive.items():
            if exponent < 1:
                raise ValueError(
                    f"the exponent of {name} must satisfy exponent >= 1, got {exponent} "
                    "(slow variables carry a positive power of eps)"
                )
        if self.amplitude < 0:
            raise ValueError(
                f"amplitude must satisfy amplitude >= 0, got {self.amplitude} "
                "(0 is a wave of order one)"
            )

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the slow variables, time last."""
        return (*(variable.name for variable in self.space), "T")

    @property
    def leading_order(self) -> int:
        """The power of eps at which the mixed derivative Y_XT enters the lattice equation."""
        return self.amplitude + self.space[0].exponent + self.time

    @property
    def speed(self) -> Expr:
        """The frame speed along the first slow variable."""
        return self.space[0].speed

    @property
    def constants(self) -> tuple[Symbol, ...]:
        """The symbols in speeds and background, by name."""
        found: set[Symbol] = set()
        for expression in (*(v.speed for v in self.space), *(b for _, b in self.background)):
            found |= expression.free_symbols
        return tuple(sorted(found, key=str))
