"""Lattices, their long waves and the rates at which they must come together, as data.

What they must fall with is in no table: it follows from the expansion (`theory_rate`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

from sympy import Expr, Rational

from longwave.derive import LATTICES, Reduction, Scaling, SlowVariable, reduce
from longwave.derive.lattice import Lattice
from longwave.derive.symbols import c, eps
from longwave.scenes.computed_soliton import ComputedSoliton
from longwave.scenes.convergence import ConvergenceStudy, convergence_study
from longwave.scenes.lattice_wave import ORDERS
from longwave.scenes.line_chain import lattice_along
from longwave.scenes.long_wave_data import JetWave, LongWaveData
from longwave.scenes.theory_rate import long_wave_rate
from longwave.solutions import Wave, closed_form

Value: TypeAlias = int | str | Expr


@dataclass(frozen=True)
class RateCase:
    """A lattice with numbers, an ansatz, a wave of its reduced equation, and the rates to expect.

    ``wave`` names a closed form, or "" is the computed soliton of the ``speed`` in ``parameters``.
    ``orders``: those of the data with which its errors are measured.
    ``within``: of X, where the wave does not end.  ``steps``: of `lattice_along`, for waves along a
    line of a lattice of two axes.
    """

    name: str
    lattice: str
    constants: Mapping[str, Value]
    scaling: Scaling
    wave: str
    parameters: Mapping[str, Value]
    orders: tuple[str, ...]
    eps: tuple[float, ...] = (0.2, 0.14, 0.1, 0.07)
    slow_times: tuple[float, float] = (0.0, 2.0)
    within: float | None = None
    interval: tuple[float, float] | None = None
    steps: tuple[int, ...] = ()

    @cached_property
    def numeric(self) -> Lattice:
        """The lattice with its numbers."""
        values = {name: _exact(value) for name, value in self.constants.items()}
        lattice = LATTICES[self.lattice].with_values(values)
        return lattice_along(lattice, self.steps) if self.steps else lattice

    @cached_property
    def reduction(self) -> Reduction:
        """Its reduction, two orders beyond the evolution equation."""
        return reduce(self.numeric, self.scaling)

    @cached_property
    def solution(self) -> JetWave:
        """The wave of the reduced equation."""
        values = {name: _exact(value) for name, value in self.parameters.items()}
        if not self.wave:
            return ComputedSoliton(self.reduction, float(values["speed"]))
        return Wave(closed_form(self.wave), self.reduction.normal_form(), **values)

    def data(self, at: float, order: str) -> LongWaveData:
        """The wave on the lattice at one eps."""
        return LongWaveData(
            self.reduction, {}, self.solution, at, order, self.numeric, self.interval
        )

    def rate(self, order: str) -> int:
        """The power of eps that the strain's error must fall with; ValueError for none."""
        found = long_wave_rate(self.reduction, self.numeric, order)
        if found is None:
            raise ValueError(f"order must be one with a rate, got {order} (slaved has one)")
        return found

    def study(self, order: str, values: tuple[float, ...] = ()) -> ConvergenceStudy:
        """Its errors over eps."""
        chosen = values or self.eps
        return convergence_study(
            lambda at: self.data(at, order),
            chosen,
            self.slow_times,
            self.within,
            causal=order == "corrected",
        )


def _exact(value: Value) -> Expr:
    return value if isinstance(value, Expr) else Rational(value)


HALF = Rational(1, 2)

CUBIC = {"K2": 1, "K3": 0, "K4": 1}
FULL = {"K2": 1, "K3": 1, "K4": 1}
FURTHER = {"L2": "1/10", "L3": 0, "L4": "1/10"}
FURTHER_QUADRATIC = {"L2": "1/10", "L3": "1/10", "L4": 0}
MASSES = {"m1": 1, "m2": 2}
DEGENERATE = {"K2": "4/3", "K4": 0, "L2": "-1/12", "L4": 0}
NEARLY = {"K2": (4 - eps**2) / 3, "L2": (eps**2 - 1) / 12}
"""``K2 + 4 L2 = 1`` and ``K2 + 16 L2 = eps^2``."""

ALL, OF_CELLS, UNCORRECTED, SLAVED = ORDERS, ORDERS[1:], ORDERS[:2], ORDERS[1:2]
"""Data of a cell of two fields hold what follows the wave; a computed wave, whose jets are noisy,
has no next order."""

OBLIQUE = (SlowVariable("X", 1, (Rational(1, 5),), c),)
"""Along (3, 4)/5 of the square lattice, k = 3 n + 4 m."""

KDV, MKDV, GARDNER = "kdv_soliton", "soliton_sech", "gardner_soliton"
LARGER = (0.4, 0.3, 0.25, 0.2)
"""For times of order eps^-5."""

RATE_CASES = {
    case.name: case
    for case in (
        RateCase("1", "fput_strain", CUBIC, Scaling(), MKDV, {"A": HALF}, ALL),
        RateCase("2", "fput_strain", FULL, Scaling(2), KDV, {"kappa": 1}, ALL),
        RateCase(
            "3", "fput_strain", {**CUBIC, "K3": eps / 2}, Scaling(), GARDNER, {"kappa": 2}, ALL
        ),
        RateCase(
            "4a",
            "fput_strain",
            FULL,
            Scaling(2, background=((0, Rational(1, 5)),)),
            KDV,
            {"kappa": 1},
            ALL,
        ),
        RateCase(
            "4b",
            "fput_strain",
            FULL,
            Scaling(background=((0, -Rational(1, 3)),)),
            MKDV,
            {"A": HALF},
            ALL,
        ),
        RateCase(
            "4c",
            "fput_strain",
            CUBIC,
            Scaling(background=((1, HALF),)),
            GARDNER,
            {"kappa": 1},
            ALL,
        ),
        RateCase(
            "5a",
            "next_nearest",
            {**FULL, "K4": 0, **FURTHER_QUADRATIC},
            Scaling(2),
            KDV,
            {"kappa": 1},
            ALL,
        ),
        RateCase("5b", "next_nearest", {**CUBIC, **FURTHER}, Scaling(), MKDV, {"A": HALF}, ALL),
        RateCase(
            "5c",
            "next_nearest",
            {**DEGENERATE, "K3": 1, "L3": 0},
            Scaling(4, time=5),
            "",
            {"speed": 1},
            UNCORRECTED,
            LARGER,
        ),
        RateCase(
            "5d",
            "next_nearest",
            {**DEGENERATE, "K3": 0, "K4": 1, "L3": 0},
            Scaling(2, time=5),
            "",
            {"speed": 1},
            UNCORRECTED,
            LARGER,
        ),
        RateCase(
            "5e",
            "next_nearest",
            {**NEARLY, "K3": 1, "K4": 0, "L3": 0, "L4": 0},
            Scaling(4, time=5),
            "kawahara_soliton",
            {},
            ALL,
            LARGER,
        ),
        RateCase(
            "5f",
            "next_nearest",
            {**NEARLY, "K3": 0, "K4": 1, "L3": 0, "L4": 0},
            Scaling(2, time=5),
            "modified_kawahara_soliton",
            {},
            ALL,
            LARGER,
        ),
        RateCase("6a", "mass_dimer", {**CUBIC, **MASSES}, Scaling(0), MKDV, {"A": HALF}, OF_CELLS),
        RateCase(
            "6b",
            "mass_dimer",
            {**FULL, "K4": 0, **MASSES},
            Scaling(1),
            KDV,
            {"kappa": 1},
            OF_CELLS,
        ),
        RateCase(
            "6c",
            "dimer",
            {**CUBIC, "H2": 2, "H3": 0, "H4": 1, **MASSES},
            Scaling(0),
            MKDV,
            {"A": HALF},
            SLAVED,
        ),
        RateCase(
            "6d",
            "dimer",
            {**FULL, "K4": 0, "H2": 2, "H3": 1, "H4": 0, **MASSES},
            Scaling(1),
            KDV,
            {"kappa": 1},
            SLAVED,
        ),
        RateCase(
            "6e",
            "dimer",
            {"K2": 1, "K3": 1, "K4": "5/2", "H2": 2, "H3": -8, "H4": 60, **MASSES},
            Scaling(0),
            MKDV,
            {"A": HALF},
            OF_CELLS,
            (0.06, 0.045, 0.035, 0.025),
            (0.0, 1.0),
        ),
        RateCase(
            "7e",
            "square",
            {**FULL, "K4": 0, "H2": 1, "H3": 1, "H4": 0},
            Scaling(1, OBLIQUE),
            KDV,
            {"kappa": 1},
            ALL,
            steps=(3, 4),
        ),
        RateCase(
            "7f",
            "square",
            {**CUBIC, "H2": 1, "H3": 0, "H4": 1},
            Scaling(0, OBLIQUE),
            MKDV,
            {"A": HALF},
            ALL,
            steps=(3, 4),
        ),
        RateCase(
            "7h",
            "square",
            {**FULL, "K4": 0, "H2": 2, "H3": 1, "H4": 0},
            Scaling(1, OBLIQUE),
            KDV,
            {"kappa": 1},
            ALL,
            steps=(3, 4),
        ),
        RateCase(
            "4b, second rogue wave",
            "fput_strain",
            FULL,
            Scaling(background=((0, -Rational(1, 3)),)),
            "rational_2",
            {},
            SLAVED,
            (0.03, 0.026, 0.022, 0.018),
            (-0.08, 0.08),
            2.0,
        ),
        RateCase(
            "4b, rogue wave on cn",
            "fput_strain",
            FULL,
            Scaling(background=((0, -Rational(1, 3)),)),
            "rogue_cn",
            {"k": HALF},
            SLAVED,
            (0.1, 0.07, 0.05, 0.035),
            (-0.3, 0.3),
            3.0,
        ),
        RateCase(
            "6a, second rogue wave",
            "mass_dimer",
            {**CUBIC, **MASSES},
            Scaling(0),
            "rational_2",
            {},
            SLAVED,
            (0.07, 0.05, 0.04, 0.03),
            (-0.6, 0.6),
            2.0,
        ),
        RateCase(
            "6a, rogue wave on cn",
            "mass_dimer",
            {**CUBIC, **MASSES},
            Scaling(0),
            "rogue_cn",
            {"k": HALF},
            SLAVED,
            (0.14, 0.1, 0.08, 0.06),
            (-3.0, 3.0),
            3.0,
        ),
    )
}
"""The cases by name: the row of the equation, as in the tests of the reductions."""
