"""Functions of time that drive a chain: formulas and measured values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from longwave.lattice.time_integral import ROUNDING
from longwave.scenes.description.csv_table import number_list
from longwave.scenes.description.scene_checks import finite
from longwave.support.real_arrays import Array
from longwave.support.user_files import shown

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

    from longwave.lattice.force_program import ForceProgram

Smooth: TypeAlias = "ForceProgram | Samples"
"""Callable that maps an array of times to values; its method ``slope`` returns derivatives."""

SPLINE_DEGREE = 5
"""Degree of the spline through measured values. Its first four derivatives are continuous, so a
scheme of order 6 keeps its order; a cubic spline gives order 4, a monotone one order 3."""

OVERSHOOT = 0.5
"""Largest excess of a spline over the range of measured values, as a fraction of that range; for
densely sampled values the excess is a few hundredths."""


@dataclass(frozen=True)
class Samples:
    """Values at increasing times, interpolated by a spline of degree `SPLINE_DEGREE`."""

    times: tuple[float, ...]
    values: tuple[float, ...]

    @classmethod
    def of(cls, label: str, given: Mapping[str, Any]) -> Samples:
        """Return samples from lists ``t`` and ``value``; ValueError for other tables.

        >>> samples = Samples.of("value", {"t": range(7), "value": [0, 1, 4, 9, 16, 25, 36]})
        >>> round(float(samples(np.array(2.5))), 12), round(float(samples.slope(np.array(2.5))), 12)
        (6.25, 5.0)
        """
        if set(given) != {"t", "value"}:
            raise ValueError(
                f"{label} must be a formula in t or a table of t and value, got {shown(given)} "
                "(such as { t = [...], value = [...] })"
            )
        times, values = (number_list(f"{name} of {label}", given[name]) for name in ("t", "value"))
        if times.size != values.size or times.size <= SPLINE_DEGREE:
            raise ValueError(
                f"{label} must have at least {SPLINE_DEGREE + 1} times and as many values, got "
                f"{times.size} and {values.size} (measure more)"
            )
        for row in np.flatnonzero(np.diff(times) <= 0.0)[:1]:
            raise ValueError(
                f"t of {label} must increase, got {times[row]:g} before {times[row + 1]:g} (in "
                f"rows {row + 1} and {row + 2}; sort them)"
            )
        return cls(tuple(times.tolist()), tuple(values.tolist()))

    @cached_property
    def _spline(self) -> BSpline:
        """Spline through the values; ValueError if it leaves their range by over `OVERSHOOT`."""
        from scipy.interpolate import make_interp_spline

        spline: BSpline = make_interp_spline(self.times, self.values, k=SPLINE_DEGREE)
        rows = np.arange(8 * len(self.times)) / 8
        times = np.interp(rows, np.arange(len(self.times)), self.times)
        values = spline(times)
        beyond = np.abs(values - np.clip(values, min(self.values), max(self.values)))
        allowed = OVERSHOOT * np.ptp(self.values) + ROUNDING * max(map(abs, self.values))
        if not beyond.max() <= allowed:
            raise ValueError(
                "measured values must be dense and even, got a spline that leaves their range by "
                f"{beyond.max():.2g} at t = {times[beyond.argmax()]:g} (measure more often there)"
            )
        return spline

    def __call__(self, times: Array, /) -> Array:
        """Return the values at these times; ValueError for times outside the table."""
        first, last = self.times[0], self.times[-1]
        room = 1e-9 * (last - first)
        if not first - room <= np.min(times) <= np.max(times) <= last + room:
            raise ValueError(
                f"times must be within those of a table of measured values, {first:g} to {last:g}, "
                f"got {np.min(times):g} to {np.max(times):g} (end earlier, or measure longer)"
            )
        return np.asarray(self._spline(times))

    def slope(self, times: Array, /) -> Array:
        """Return the time derivatives at these times."""
        return np.asarray(self._spline(times, 1))


def time_function(label: str, given: object) -> Smooth:
    """Return a drive as a function of an array of times.

    A drive is a formula in t, with the functions allowed in forces, or a table of ``t`` and
    ``value``. Raises ValueError for anything else.

    >>> time_function("value", "0.3*cos(0.9*t)")(np.array([0.0]))
    array([0.3])
    """
    if isinstance(given, Mapping):
        return Samples.of(label, given)
    if isinstance(given, int) and not isinstance(given, bool):
        finite(label, given)
    from sympy import Abs, sign

    from longwave.derive.lattice_file import time_formula
    from longwave.lattice.force_program import program_of

    formula = time_formula(label, given)
    if formula.has(Abs, sign):
        raise ValueError(
            f"{label} must have a slope without jumps, got {shown(given)}, which has a corner "
            "(round it: sqrt((t - 5)**2 + 1/10**6))"
        )
    return program_of(formula)
