"""Numeric coefficients of differential polynomials, at values of the constants."""

from collections import Counter
from collections.abc import Mapping
from typing import Any

import mpmath
from sympy import Expr, Symbol

from longwave.derive.algebra.jets import DifferentialPolynomial, EpsSeries
from longwave.derive.algebra.rational_functions import RationalFunction
from longwave.scenes.starts.jet_polynomial import JetPolynomial

DECIMAL_DIGITS = 40
"""Decimal digits used for the constants; many, because terms of a coefficient may cancel."""

_EXACT = mpmath.MPContext()
_EXACT.dps = DECIMAL_DIGITS


def with_numbers(
    series: EpsSeries | DifferentialPolynomial, values: Mapping[Symbol, Expr], eps: float = 1.0
) -> JetPolynomial:
    """Return a differential polynomial, or the sum of a series at ``eps``, with float coefficients.

    ``values`` are those of the constants. Raises ValueError for derivatives other than by X, and
    for a constant without a value.
    """
    parts = {0: series} if isinstance(series, DifferentialPolynomial) else series.parts
    numbers = {s: _EXACT.mpf(str(value.evalf(DECIMAL_DIGITS))) for s, value in values.items()}
    total: dict[tuple[tuple[int, int], ...], Any] = {}
    for order, part in parts.items():
        for monomial, value in part.terms.items():
            if any(any(jet[1:]) for jet in monomial):
                raise ValueError(
                    f"jets must have derivatives by X only, got {monomial} (eliminate those by T "
                    "with the reduced equation)"
                )
            key = tuple(sorted(Counter(jet[0] for jet in monomial).items()))
            above, below = (_sum(value, line, numbers) for line in (False, True))
            term = above / below * _EXACT.mpf(eps) ** order
            total[key] = total[key] + term if key in total else term
    return JetPolynomial(tuple((float(value), key) for key, value in sorted(total.items())))


def _sum(element: RationalFunction, below: bool, numbers: Mapping[Symbol, Any]) -> Any:
    """Return the value of a rational function's numerator, or of its denominator if ``below``."""
    total = _EXACT.mpf(0)
    for exponents, coefficient in element.terms(below=below):
        product = _EXACT.mpf(coefficient)
        for symbol, power in zip(element.field.symbols, exponents, strict=True):
            if not power:
                continue
            if symbol not in numbers:
                raise ValueError(f"constant {symbol} must have a value, got none (give it)")
            product *= numbers[symbol] ** power
        total += product
    return total
