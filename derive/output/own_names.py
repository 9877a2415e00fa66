"""Names in an output that avoid those of a lattice, and joined powers."""

import re
from collections.abc import Collection, Iterable

from sympy import Expr, Pow, powsimp


def unused(name: str, taken: Collection[str]) -> str:
    """Return ``name``, followed by a tilde if it is among the ``taken`` names of the lattice.

    >>> unused("F2", {"K2"}), unused("F2", {"F2"})
    ('F2', 'F2~')
    """
    return f"{name}~" if name in taken else name


def marked(text: str, names: Iterable[str], taken: Collection[str]) -> str:
    """Add a tilde in a text to those ``names`` that are also ``taken`` by the lattice.

    >>> marked("Y(X, T) = h U(a X, b T)", "abh", {"a", "K"})
    'Y(X, T) = h U(a~ X, b T)'
    """
    for name in {*names} & {*taken}:
        text = re.sub(rf"(?<![A-Za-z0-9]){name}(?![A-Za-z0-9~])", f"{name}~", text)
    return text


def joined_powers(value: Expr) -> Expr:
    """Return the expression with powers of one base combined, if exponents are symbolic.

    >>> from sympy import Symbol
    >>> d, p = Symbol("d", positive=True), Symbol("p", positive=True)
    >>> joined_powers(d ** (-1 - p) * d ** (2 + p))
    d
    """
    is_symbolic = any(power.exp.free_symbols for power in value.atoms(Pow))
    return powsimp(value, combine="exp") if is_symbolic else value
