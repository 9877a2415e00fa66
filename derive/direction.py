"""Direction of a wave on a lattice with two axes, from text to slow variables."""

from sympy import Expr, Integer, Symbol, atan, cos, sin, sqrt

from longwave.derive.algebra.exact_numbers import exact
from longwave.derive.algebra.formula_expression import read_formula
from longwave.derive.algebra.formula_text import Vocabulary
from longwave.derive.lattice import Lattice
from longwave.derive.scaling import SlowVariable
from longwave.derive.symbols import c
from longwave.support.user_files import shown

C, S = Symbol("C", real=True), Symbol("S", real=True)
"""Cosine and sine of the direction's angle with the first axis."""

DRIFT = Symbol("drift", real=True)
"""Drift speed of the transverse variable on an anisotropic lattice; the reduction finds it."""

WORDS = Vocabulary({"sqrt": (sqrt, 1), "atan": (atan, 1)})


def read_direction(text: str) -> tuple[Expr, Expr]:
    """Return cosine and sine of a direction: an angle in radians, or a vector ``a,b``.

    Raises ValueError for any other text, and for a vector of length 0.

    >>> read_direction("pi/4"), read_direction("3,4"), read_direction("0,-1")
    ((sqrt(2)/2, sqrt(2)/2), (3/5, 4/5), (0, -1))
    """
    numbers = [exact("direction", read_formula(t, WORDS, "direction")) for t in text.split(",")]
    if len(numbers) == 1:
        return cos(numbers[0]), sin(numbers[0])
    if len(numbers) != 2 or not any(numbers):
        raise ValueError(
            f"direction must be an angle or two numbers, not both 0, got {shown(text)} (such as "
            "pi/4, or 3/5,4/5)"
        )
    length = sqrt(numbers[0] ** 2 + numbers[1] ** 2)
    return numbers[0] / length, numbers[1] / length


def slow_variables(
    lattice: Lattice, direction: tuple[Expr, Expr]
) -> tuple[tuple[SlowVariable, ...], dict[str, Expr]]:
    """Return X along a direction and Z across it, and values for the symbols in them.

    Oblique directions use the symbols C and S, and a drift of Z.  Raises ValueError for a lattice
    without two axes, and for one with constants of these names.
    """
    if lattice.dimension != 2:
        raise ValueError(
            f"direction must be given for a lattice with two axes only, got {lattice.name} with "
            f"{lattice.dimension} (leave it out; square has two)"
        )
    taken = {str(symbol) for symbol in (C, S, DRIFT)} & {*map(str, lattice.constants)}
    if taken:
        raise ValueError(
            f"constants must have names other than C, S and drift, got {min(taken)} (these "
            "are used for the direction)"
        )
    if all(part.is_Integer for part in direction):
        parallel, transverse = direction
        normal = (-transverse, parallel)
        return (SlowVariable("X", 1, direction, c), SlowVariable("Z", 2, normal, Integer(0))), {}
    oblique = SlowVariable("X", 1, (C, S), c), SlowVariable("Z", 2, (-S, C), DRIFT)
    return oblique, dict(zip("CS", direction, strict=True))
