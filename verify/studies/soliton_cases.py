"""Parameter values of the solitons and breathers without modulus: ends of domains, and between."""

import sympy as sp

__all__ = ["SOLITON_VALUES"]

_SMALL = sp.Rational(1, 10**8)
_BELOW_ONE = 1 - sp.Rational(1, 10**12)
_HALF = sp.Rational(1, 2)
_THIRD = sp.Rational(1, 3)

_NAMES: dict[str, tuple[str, ...]] = {
    "breather": ("p", "q", "X_0"),
    "double_pole": ("A", "X_0"),
    "two_soliton": ("A_1", "A_2", "X_0"),
    "soliton_background": ("U_0", "kappa"),
    "kink_antikink": ("A", "kappa"),
}

_ROWS: dict[str, tuple[tuple[sp.Expr | int, ...], ...]] = {
    "breather": (
        (_SMALL, 1, _THIRD),
        (_HALF, 2, _THIRD),
        (2, 2, 0),
        (2, _HALF, 0),
        (_HALF, _SMALL, _THIRD),
        (3, 40, 0),
    ),
    "double_pole": ((_SMALL, _THIRD), (1, _THIRD), (2, 0), (40, 0)),
    "two_soliton": (
        (1, _SMALL, _THIRD),
        (2, _HALF, _THIRD),
        (1, 1 - _SMALL, 0),
        (1, _BELOW_ONE, 0),
        (2, _BELOW_ONE, 0),
        (40, 39, 0),
    ),
    "soliton_background": (
        (1, _SMALL),
        (-1, _SMALL),
        (0, 2),
        (-1, 2),
        (1, 2),
        (-_SMALL, 1),
        (-40, 3),
        (3, 40),
    ),
    "kink_antikink": (
        (1, _SMALL),
        (1, 1),
        (2, 3),
        (1, 2 * _BELOW_ONE),
        (2, 4 * (1 - sp.Rational(1, 10**24))),
        (40, 41),
    ),
}

SOLITON_VALUES: dict[str, tuple[tuple[tuple[str, sp.Expr], ...], ...]] = {
    name: tuple(
        tuple(
            (key, sp.sympify(value, strict=True))
            for key, value in zip(_NAMES[name], row, strict=True)
        )
        for row in rows
    )
    for name, rows in _ROWS.items()
}
"""For each wave its cases; a case is names with exact values."""
