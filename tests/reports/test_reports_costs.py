"""Cost tables and figures: the cheapest run, fitted exponents, what is scaled, what is left out."""

import pytest

from longwave.lattice.schemes import SCHEMES
from longwave.reports.latex import PRINTED, escape
from longwave.reports.pictures.drawing import cost_figure
from longwave.reports.sections.costs import (
    extrapolated_table,
    hard_case_table,
    message_table,
    precision_table,
    rk4_table,
    scaling_table,
)
from longwave.reports.studies.hard_cases import HardCase
from longwave.reports.studies.lattice_cost import (
    REDUCTION,
    SPECTRAL,
    TRUE_ERROR,
    CostPoint,
    ScalingPoint,
    scaling_laws,
)

EPSILONS = (0.1, 0.05, 0.025, 0.0125)


def test_the_cheapest_run_within_the_error_is_shown() -> None:
    """Catches the most accurate run taken for the cheapest, and a run that is not good enough."""
    runs = [(1e-1, 0.001), (1e-3, 0.002), (1e-5, 0.003), (1e-5, 0.9)]
    text = precision_table([CostPoint("crest", "rk4", error, s) for error, s in runs])
    assert r"\strut crest\strut" in text
    assert r"RK4 & $0.0020$ & $0.0030$ & -- \\" in text


def test_the_rings_data_count_in_a_row_of_their_own() -> None:
    text = precision_table([CostPoint("periodic", "spectral", 1e-3, 0.002, 0.5)])
    assert r"spectral ring & $0.0020$ & -- & -- \\" in text
    assert r"spectral ring, with its data & $0.50$ & -- & -- \\" in text


def test_every_method_has_a_printed_name() -> None:
    assert set(PRINTED) == {scheme.name for scheme in SCHEMES} | {SPECTRAL}


def test_laws_are_fitted_at_small_eps() -> None:
    """Catches a fit to the large eps, where the law does not hold yet."""
    cost = [ScalingPoint("window", 1 / e, e**-4 if e < 0.1 else 1.0, True) for e in EPSILONS]
    error = [ScalingPoint("error of the reduction", e, e**2 if e < 0.1 else 9.0) for e in EPSILONS]
    found = scaling_laws([*cost, *error])
    assert found["window"] == pytest.approx(4)
    assert found["error of the reduction"] == pytest.approx(2)
    judged = [ScalingPoint(TRUE_ERROR, e, 3e-4) for e in EPSILONS]
    text = scaling_table([*cost, *error, *judged])
    scaled = extrapolated_table([*cost, *error, *judged])
    assert (
        r"error of the spectral run & " + " & ".join([r"$3.0\times 10^{-4}$"] * 4) + " & --" in text
    )
    assert r"$(1/\epsilon)^{4.00}$" in scaled
    assert r"$(\epsilon)^{2.00}$" in text


def test_extrapolated_and_measured_values_have_separate_tables() -> None:
    """Catches a time that was scaled from a part of a run in the table of measured ones."""
    points = [ScalingPoint("RK4, window", 1 / e, 123.0, scaled=True) for e in EPSILONS]
    points += [ScalingPoint("spectral", 1 / e, 45.0) for e in EPSILONS]
    points += [ScalingPoint(REDUCTION, e, e**2, own=3e-5) for e in EPSILONS]
    measured, scaled = scaling_table(points), extrapolated_table(points)
    assert "Measured" in measured
    assert "RK4" not in measured
    assert "spectral (s) & " + " & ".join(["$45$"] * 4) in measured
    assert "its own error & " + " & ".join([r"$3.0\times 10^{-5}$"] * 4) in measured
    assert "Extrapolated" in scaled
    assert "RK4, window (s) & " + " & ".join(["$123$"] * 4) in scaled
    assert "spectral" not in scaled


def test_the_share_of_the_step() -> None:
    text = rk4_table([ScalingPoint("", 0.25, 0.125), ScalingPoint("", 0.0, 0.1)])
    assert r"$0.25$ & 0.12500 & $0.025$ & 20.0" in text
    assert r"exact flow & 0.10000 & -- & 0.0" in text


def test_a_failed_hard_case_is_reported() -> None:
    """Catches a message cut short, and one of a case that says nothing."""
    words = "step must satisfy step <= 0.5, got 0.6 " + 20 * "(take a smaller step) "
    cases = [
        HardCase("a step $10^{-6}$ too long", "ratio", 1.0, 0.1, words),
        HardCase("what b", "of $y/eps$", 1, 2),
    ]
    *_, first, second = (line for line in hard_case_table(cases).splitlines() if " & " in line)
    assert r"a step $10^{-6}$ too long & ratio & $0.10$ & $1.0$ & holds" in first
    assert r"of $y/\epsilon$ & $2.0$ & $1.0$ & \textbf{FAILS}" in second
    messages = message_table(cases)
    assert escape(words) in messages
    assert "what b" not in messages


def test_panels_share_their_axes_and_one_look_a_label() -> None:
    """Catches points that are not positive, which logarithmic axes cannot show."""
    panels = {
        "one": {"double": [(1e-8, 15.0), (1e-8, float("inf"))], "balls": [(1e-3, 40.0)]},
        "two": {"balls": [(1e-3, 40.0), (2e-3, 0.0)]},
    }
    first, second = cost_figure(panels, "seconds", "digits").axes[:2]
    assert first.get_xlim() == second.get_xlim()
    assert [line.get_xdata().size for line in first.lines] == [1, 1]
    assert second.lines[0].get_color() == first.lines[1].get_color()
    assert first.get_xscale() == first.get_yscale() == "log"


def test_the_lowest_panel_of_each_column_is_labelled() -> None:
    """Catches a column that ends above an empty place, whose labels matplotlib hides."""
    panels = {name: {"one": [(1.0, 2.0)]} for name in "abc"}
    figure = cost_figure(panels, "seconds", "digits", across=2)
    assert [ax.get_xlabel() for ax in figure.axes] == ["", "seconds", "seconds", ""]
    assert figure.axes[1].xaxis.get_tick_params()["labelbottom"]


def test_digits_are_linear_and_given_ticks_are_the_only_ones() -> None:
    """Catches the labels 2x10^1 and 6x10^1 that a logarithm gives within a decade."""
    panels = {name: {"balls": [(20.0, 15.0), (50.0, 60.0)]} for name in "ab"}
    figure = cost_figure(panels, "x", "digits", x_ticks=(10, 20, 40, 80), digits=(0, 30, 60))
    for ax in figure.axes[:2]:
        assert (ax.get_xscale(), ax.get_yscale()) == ("log", "linear")
        assert ax.get_ylim() == (0, 60)
        assert [label.get_text() for label in ax.get_xticklabels()] == ["10", "20", "40", "80"]
        assert list(ax.get_xticks(minor=True)) == []
        assert ax.get_xlim()[1] < 80


@pytest.mark.parametrize(("most", "between"), [(7e-2, False), (8e-3, True)])
def test_labels_between_powers_of_ten_stand_where_there_is_none(most: float, between: bool) -> None:
    """Side by side they overlap."""
    figure = cost_figure({"one": {"RK4": [(2e-3, 1e-2), (most, 1e-4)]}}, "seconds", "error")
    figure.draw_without_rendering()
    labels = [label.get_text() for label in figure.axes[0].get_xticklabels(minor=True)]
    assert any(labels) is between
