"""The waves and parameter values on which evaluation is measured: the whole stated domain.

k from 1e-8 to 1 - 1e-12, alpha near 0 and near K, rational solutions up to order 8 with and
without free shifts.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import sympy as sp

from derive import NormalForm, mkdv_normal_form
from solutions import CATALOGUE, ClosedForm, Wave, closed_form, rational
from verify.study.soliton_cases import SOLITON_VALUES

__all__ = ["MODULI", "Case", "all_cases", "wave_names"]

MODULI: tuple[sp.Rational, ...] = (
    sp.Rational(1, 10**8),
    sp.Rational(1, 100),
    sp.Rational(1, 2),
    sp.Rational(9, 10),
    sp.Rational(99, 100),
    1 - sp.Rational(1, 10**4),
    1 - sp.Rational(1, 10**8),
    1 - sp.Rational(1, 10**12),
)
"""0.9 and 0.99 are the last values at which the cn and dn forms are evaluated in double."""

ALPHA_OVER_K: tuple[sp.Rational, ...] = (
    sp.Rational(1, 10**8),
    sp.Rational(1, 2),
    1 - sp.Rational(1, 10**8),
)
AMPLITUDES: tuple[sp.Rational, ...] = (sp.Rational(1, 10), sp.Rational(1), sp.Rational(3, 2))
LARGEST_ORDER = 8
SHIFTS: tuple[sp.Rational, ...] = (sp.Rational(-7, 3), sp.Rational(11, 2))


@dataclass(frozen=True)
class Case:
    """A wave by its name (``rational_j`` for any j) with exact parameter values."""

    name: str
    parameters: tuple[tuple[str, sp.Expr], ...] = ()

    @property
    def form(self) -> ClosedForm:
        """The closed form; rational solutions keep the shifts that have values as parameters."""
        if self.name in {form.name for form in CATALOGUE}:
            return closed_form(self.name)
        order = int(self.name.removeprefix("rational_"))
        return rational(order, [int(name.removeprefix("tau_")) for name, _ in self.parameters])

    @property
    def normal_form(self) -> NormalForm:
        """K2 = 4 and K4 = 1 for the focusing waves, K2 = 1 and K4 = -1 for the others."""
        if self.form.equation.s > 0:
            return mkdv_normal_form(K2=4, K4=1)
        return mkdv_normal_form(K2=1, K4=-1)

    def wave(self, precision: str | None = None) -> Wave:
        """The wave itself."""
        return Wave(self.form, self.normal_form, precision=precision, **dict(self.parameters))

    def __str__(self) -> str:
        return ", ".join(f"{name} = {_short(value)}" for name, value in self.parameters)


def wave_names() -> list[str]:
    """The catalogue's names and the rational solutions of higher order."""
    higher = range(4, LARGEST_ORDER + 1)
    return [form.name for form in CATALOGUE] + [f"rational_{order}" for order in higher]


def all_cases(name: str) -> Iterator[Case]:
    """The cases of one wave.

    >>> [str(case) for case in all_cases("kink")]
    ['A = 0.1', 'A = 1', 'A = 1.5']

    Raises ValueError for a name that is no wave of the study.
    """
    if name not in wave_names():
        raise ValueError(f"name must be a wave, got {name!r} (one of {', '.join(wave_names())})")
    parameters = [parameter.name for parameter in Case(name).form.parameters]
    if name in SOLITON_VALUES:
        yield from (Case(name, values) for values in SOLITON_VALUES[name])
    elif not parameters:
        yield Case(name)
    elif "A" in parameters:
        yield from (Case(name, (("A", value),)) for value in AMPLITUDES)
    else:
        yield from _with_modulus(name, "alpha" in parameters)
    if name.startswith("rational_") and (order := int(name.removeprefix("rational_"))) > 3:
        yield Case(name, _shifts(order))


def _with_modulus(name: str, with_alpha: bool) -> Iterator[Case]:
    for modulus in MODULI:
        if not with_alpha:
            yield Case(name, (("k", modulus),))
            continue
        for part in ALPHA_OVER_K:
            alpha = part * sp.elliptic_k(modulus**2)
            yield Case(name, (("k", modulus), ("alpha", alpha), ("X_0", sp.Rational(1, 3))))


def _shifts(order: int) -> tuple[tuple[str, sp.Expr], ...]:
    free: Mapping[int, sp.Expr] = {5: SHIFTS[0], 2 * order - 1: SHIFTS[1]}
    return tuple((f"tau_{index}", value) for index, value in free.items())


def _short(value: sp.Expr) -> str:
    """A few digits; values near 1 by their distance from it."""
    near = 1 - value
    if value != 1 and abs(near) < sp.Rational(1, 1000):
        return f"1 - {float(near):.3g}"
    return f"{float(value):.4g}"
