"""Cost tables and figures: the cheapest run, fitted exponents, what is scaled, what is left out."""

import pytest

from reports.figures.costs import CostAxes, CostPanel, cost_figure
from reports.sections.costs import (
    hard_case_table,
    laws,
    precision_table,
    rk4_table,
    scaling_table,
)
from verify.study.cost_precision import CostPoint
from verify.study.cost_scaling import ScalingPoint
from verify.study.hard_case import HardCase

EPSILONS = (0.1, 0.05, 0.025, 0.0125)


def test_the_cheapest_run_within_the_error_is_shown() -> None:
    """Catches the most accurate run taken for the cheapest, and a run that is not good enough."""
    runs = [(1e-1, 0.001), (1e-3, 0.002), (1e-5, 0.003), (1e-5, 0.9)]
    text = precision_table([CostPoint("crest", "rk4", error, s) for error, s in runs])
    assert r"crest & \texttt{rk4} & 2.0 ms & 3.0 ms & -- \\" in text


def test_laws_are_fitted_at_small_eps() -> None:
    """Catches a fit to the large eps, where the law does not hold yet."""
    cost = [ScalingPoint("window", 1 / e, e**-4 if e < 0.1 else 1.0, True) for e in EPSILONS]
    error = [ScalingPoint("error of the reduction", e, e**2 if e < 0.1 else 9.0) for e in EPSILONS]
    found = {law.series: law.exponent for law in laws([*cost, *error])}
    assert found["window"] == pytest.approx(4)
    assert found["error of the reduction"] == pytest.approx(2)
    text = scaling_table([*cost, *error])
    assert r"$(1/\epsilon)^{4.00}$" in text
    assert r"$(\epsilon)^{2.00}$" in text
    assert text.count("(1.0 s)") == 1


def test_the_share_of_the_step() -> None:
    text = rk4_table([ScalingPoint("", 0.25, 0.125), ScalingPoint("", 0.0, 0.1)])
    assert r"$0.25$ & 0.12500 & 20.0\,\%" in text
    assert r"exact flow & 0.10000 & 0.0\,\%" in text


def test_a_hard_case_that_fails_is_seen() -> None:
    cases = [
        HardCase("a", "what a", 0.1, 1.0, True, 0.1, ""),
        HardCase("b", "b", 2, 1, False, 0, ""),
    ]
    text = hard_case_table(cases)
    assert "holds" in text
    assert "FAILS" in text


def test_panels_share_their_axes_and_one_look_a_label() -> None:
    """Catches points that are not positive, which logarithmic axes cannot show."""
    panels = [
        CostPanel("one", {"double": [(1e-8, 15.0), (1e-8, float("inf"))], "balls": [(1e-3, 40.0)]}),
        CostPanel("two", {"balls": [(1e-3, 40.0), (2e-3, 0.0)]}),
    ]
    first, second = cost_figure(panels, CostAxes("seconds", "digits")).axes[:2]
    assert first.get_xlim() == second.get_xlim()
    assert [line.get_xdata().size for line in first.lines] == [1, 1]
    assert second.lines[0].get_color() == first.lines[1].get_color()
    assert first.get_xscale() == first.get_yscale() == "log"


def test_digits_are_linear_and_given_ticks_are_the_only_ones() -> None:
    """Catches the labels 2x10^1 and 6x10^1 that a logarithm gives within a decade."""
    panels = [CostPanel(name, {"balls": [(20.0, 15.0), (50.0, 60.0)]}) for name in "ab"]
    axes = CostAxes("x", "digits", x_ticks=(10, 20, 40, 80), digits=(0, 30, 60))
    for ax in cost_figure(panels, axes).axes[:2]:
        assert (ax.get_xscale(), ax.get_yscale()) == ("log", "linear")
        assert ax.get_ylim() == (0, 60)
        assert [label.get_text() for label in ax.get_xticklabels()] == ["10", "20", "40", "80"]
        assert list(ax.get_xticks(minor=True)) == []
        assert ax.get_xlim()[1] < 80
