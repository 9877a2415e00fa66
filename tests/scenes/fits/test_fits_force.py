"""Force laws from points: the constants, their intervals, the order, and what is no force law."""

import math
import pickle
import re
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import optimize, stats
from sympy import Symbol

from longwave import fit_force
from longwave.derive import LATTICES
from longwave.derive.intervals import HALF_WIDTH
from longwave.lattice.numeric_lattice import numeric_lattice
from longwave.scenes.fits.force_data import ForceData, read_force
from longwave.scenes.fits.force_fit import MIN_POINTS_TO_CHOOSE, ForceFit, fit_points
from longwave.scenes.fits.force_law import stated_law
from longwave.scenes.fits.residual_tests import ResidualTests

Points = NDArray[np.float64]

STRETCH = np.linspace(-0.5, 0.5, 21)
NOISE = 0.01


def cubic(stretch: Points) -> Points:
    return stretch + 0.5 * stretch**3


def noisy(law: Callable[[Points], Points], seed: int, stretch: Points = STRETCH) -> Points:
    return law(stretch) + NOISE * np.random.default_rng(seed).normal(size=stretch.size)


def covered(fits: list[ForceFit], truth: list[float]) -> Points:
    """The share of fits whose 95 % intervals hold each constant."""
    return np.mean([abs(f.values - truth) < HALF_WIDTH * f.deviations for f in fits], axis=0)


@pytest.mark.parametrize(
    ("points", "known"), [(21, True), pytest.param(21, False, marks=pytest.mark.slow), (6, False)]
)
def test_intervals_cover_in_95_of_100(points: int, known: bool) -> None:
    """Catches: sums for means, deviations for variances, a normal for Student's distribution, which
    would cover in 86 of 100 at 6 points."""
    law, stretch = stated_law("K2*x + K4*x**3"), np.linspace(-0.5, 0.5, points)
    deviation = np.full(points, NOISE) if known else None
    fits = [
        fit_points(ForceData.of(stretch, noisy(cubic, seed, stretch), deviation), law)
        for seed in range(400)
    ]
    assert (abs(covered(fits, [1.0, 0.5]) - 0.95) <= 0.02).all()
    assert sum(bool(fit.doubts) for fit in fits) <= 0.05 * 400 + 9
    assert points < 10 or abs(np.mean([fit.smooth_p_value for fit in fits]) - 0.5) < 0.06


def test_intervals_of_a_law_that_is_not_linear_cover() -> None:
    law = stated_law("a*(exp(b*x) - 1)")
    data = (noisy(lambda x: 2 * (np.exp(0.7 * x) - 1), seed) for seed in range(40))
    fits = [fit_points(ForceData.of(STRETCH, force), law) for force in data]
    assert (covered(fits, [2.0, 0.7]) >= 0.85).all()


def test_a_fit_is_that_of_scipy() -> None:
    deviation = np.linspace(0.005, 0.02, STRETCH.size)
    force = noisy(lambda x: np.tanh(2 * x), 0)
    found = fit_force(STRETCH, force, deviation, "a*tanh(b*x)")
    values, covariance = optimize.curve_fit(
        lambda x, a, b: a * np.tanh(b * x), STRETCH, force, (1, 1), deviation, absolute_sigma=True
    )
    assert found.values == pytest.approx(values, rel=1e-5)
    assert found.covariance == pytest.approx(covariance, rel=1e-4)
    left = (force - values[0] * np.tanh(values[1] * STRETCH)) / deviation
    assert found.chi_squared == pytest.approx(left @ left, rel=1e-6)
    assert found.p_value == pytest.approx(stats.chi2.sf(left @ left, 19), rel=1e-6)


@pytest.mark.parametrize("known", [True, False])
def test_a_wrong_law_is_noticed(known: bool) -> None:
    """A hidden cubic, of a twelfth of the force at the ends."""
    deviation = np.full(41, NOISE) if known else None
    stretch = np.linspace(-0.5, 0.5, 41)
    doubted = [
        fit_force(stretch, noisy(cubic, seed, stretch), deviation, "K2*x").doubts
        for seed in range(60)
    ]
    assert sum(map(bool, doubted)) >= 57
    assert any("the residuals follow a smooth curve along the stretch" in d for d in doubted[0])
    assert any("chi^2 is" in doubt for doubts in doubted for doubt in doubts) == known


def test_deviations_that_are_too_large_are_told() -> None:
    found = fit_force(STRETCH, noisy(cubic, 1), np.full(21, 0.1), "K2*x + K4*x**3")
    assert len(found.doubts) == 1
    assert "the points scatter less than their deviations: chi^2 is 0.0" in found.doubts[0]


@pytest.mark.parametrize(
    ("law", "constants"),
    [
        (lambda x: 2 * x, "K2"),
        (cubic, "K2 K4"),
        (lambda x: x + 0.5 * x**2, "K2 K3"),
        (lambda x: x + 0.5 * x**2 + x**3, "K2 K3 K4"),
    ],
)
def test_the_order_is_chosen_by_evidence(law: Callable[[Points], Points], constants: str) -> None:
    stretch = np.linspace(-0.5, 0.5, 81)
    fits = [fit_force(stretch, noisy(law, seed, stretch)) for seed in range(5)]
    names = [" ".join(map(str, fit.law.free)) for fit in fits]
    assert names.count(constants) >= 4
    tried = dict(fits[0].evidence)
    assert tried[names[0]] <= min(tried.values()) + 2
    assert len(tried) == 8


@pytest.mark.parametrize("known", [True, False])
def test_evidence_is_aicc_and_the_fewest_constants_within_2_are_taken(known: bool) -> None:
    """Catches: AIC without its correction, a noise that is not counted, the least AICc taken."""
    deviation = np.full(21, NOISE) if known else None
    simpler = 0
    for seed in range(5, 9):
        force = noisy(cubic, seed)
        found = fit_force(STRETCH, force, deviation)
        for names, value in found.evidence:
            powers = [int(name[1:]) - 1 for name in names.split()]
            matrix = np.column_stack([STRETCH**power for power in powers])
            left = force - matrix @ np.linalg.lstsq(matrix, force)[0]
            k = len(powers) if known else len(powers) + 1
            lost = left @ left / NOISE**2 if known else 21 * math.log(left @ left / 21)
            assert value == pytest.approx(lost + 2 * k + 2 * k * (k + 1) / (20 - k), rel=1e-8)
        tried, taken = dict(found.evidence), " ".join(map(str, found.law.free))
        good = [names for names, value in tried.items() if value <= min(tried.values()) + 2]
        assert taken in good
        assert len(taken.split()) == min(len(names.split()) for names in good)
        simpler += tried[taken] > min(tried.values())
    assert simpler


def with_fifth_power(stretch: Points, seed: int, deviations: float = 3.0) -> Points:
    """A cubic force and a fifth power, so many times its standard deviation beside the cubic."""
    columns = np.column_stack([stretch, stretch**3, stretch**5])
    fifth = np.sqrt(np.linalg.inv(columns.T @ columns)[2, 2]) * columns[:, 2]
    return noisy(lambda x: cubic(x) + deviations * NOISE * fifth, seed, stretch)


@pytest.mark.parametrize(
    ("law", "known"),
    [
        ("K2*x + K4*x**3", True),
        pytest.param("K2*x + K4*x**3", False, marks=pytest.mark.slow),
        pytest.param("K2*x + K3*x**2 + K4*x**3", True, marks=pytest.mark.slow),
        pytest.param("K2*x + K3*x**2 + K4*x**3", False, marks=pytest.mark.slow),
    ],
)
def test_a_missing_fifth_power_is_told_in_80_of_100(law: str, known: bool) -> None:
    """Catches: its share of the alarms divided among curves, which tell it in 3 of 100."""
    points, count = 21 if known else 41, 300
    stretch, stated = np.linspace(-0.5, 0.5, points), stated_law(law)
    deviation = np.full(points, NOISE) if known else None

    def doubted(force: Callable[[int], Points], seeds: range) -> float:
        data = (ForceData.of(stretch, force(seed), deviation) for seed in seeds)
        return float(np.mean([bool(fit_points(points, stated).doubts) for points in data]))

    assert doubted(lambda s: with_fifth_power(stretch, s), range(count)) >= 0.8
    right = doubted(lambda s: noisy(cubic, s, stretch), range(count, 2 * count))
    assert right <= 0.05 + 3 * math.sqrt(0.05 * 0.95 / count)


def test_residuals_alike_along_the_stretch_or_in_the_order_of_measurement_are_told() -> None:
    """Catches: the order lost by sorting, with which a drift of the instrument goes."""
    up = np.linspace(-0.5, 0.5, 41)
    both = np.concatenate([up, up[-2::-1] + 0.003])
    law, alarms = stated_law("K2*x + K4*x**3"), {"along the stretch": 0, "in the order": 0}
    for seed in range(40):
        noise = np.random.default_rng(seed).normal(size=both.size)
        for row in range(1, both.size):
            noise[row] = 0.5 * noise[row - 1] + np.sqrt(0.75) * noise[row]
        for name, stretch in (("along the stretch", up), ("in the order", both)):
            force = cubic(stretch) + NOISE * noise[: stretch.size]
            doubts = fit_points(ForceData.of(stretch, force), law).doubts
            alarms[name] += any("correlated, as for a wrong law" in d and name in d for d in doubts)
    assert alarms["along the stretch"] >= 16
    assert alarms["in the order"] >= 28


def test_neighbours_are_judged_by_the_exact_moments_of_their_correlation() -> None:
    """Catches: residuals taken for independent, whose correlation is below 0 where constants are
    fitted."""
    stretch, random = np.sort(np.random.default_rng(0).uniform(-1, 1, 12)), np.random.default_rng(1)
    slopes, rows = np.column_stack([stretch, stretch**3]), np.arange(12)
    basis = np.linalg.qr(slopes)[0]
    found = []
    for _ in range(1000):
        left = random.normal(size=12)
        left -= basis @ (basis.T @ left)
        tests = ResidualTests(stretch, left, slopes, np.ones(12), rows, known=True).all
        found.append([test.p_value for test in tests])
    shares = np.mean(np.array(found) < 0.05, axis=0)
    assert len(shares) == 4
    assert (abs(shares - 0.05) < 0.02).all()


@pytest.mark.parametrize(
    ("truth", "stretch", "points"),
    [
        ([1, 0, 0.5], np.linspace(-0.5, 0.5, 50), (5, 7, 12)),
        pytest.param(
            [1, 0, 0.5], np.linspace(-0.5, 0.5, 50), (6, 9, 14, 50), marks=pytest.mark.slow
        ),
        pytest.param(
            [1, 0.3, 0.2], np.linspace(0, 0.5, 51)[1:], (5, 7, 12, 25), marks=pytest.mark.slow
        ),
        pytest.param(
            [1, 0, 1.2, 0, 3.2], np.linspace(-0.5, 0.5, 50), (6, 8, 12, 50), marks=pytest.mark.slow
        ),
    ],
)
def test_intervals_of_a_chosen_law_hold_or_are_doubted(
    truth: list[float], stretch: Points, points: tuple[int, ...]
) -> None:
    """Catches: intervals of the chosen law alone, which hold in 1 to 60 of 100."""
    for count in points:
        at = np.linspace(stretch[0], stretch[-1], count)
        wrong = 0
        for seed in range(40):
            force = noisy(lambda x: sum(k * x**p for p, k in enumerate(truth, 1)), seed, at)
            fit = fit_force(at, force)
            place = fit.names.index("K2")
            wrong += (
                abs(fit.values[place] - 1) > HALF_WIDTH * fit.deviations[place] and not fit.doubts
            )
            assert count >= MIN_POINTS_TO_CHOOSE or "few to choose a law by" in " ".join(fit.doubts)
        assert wrong <= 5


def test_the_covariance_of_a_chosen_law_is_that_over_all_laws() -> None:
    """Catches: weights that do not add up to 1, constants that a law lacks left out."""
    force = noisy(lambda x: x + 2 * x**3, 3)
    found = fit_force(STRETCH, force)
    tried = dict(found.evidence)
    weights = {names: math.exp((min(tried.values()) - tried[names]) / 2) for names in tried}
    expected = np.zeros((2, 2))
    assert found.names == ["K2", "K4"]
    for names, weight in weights.items():
        powers = [int(name[1:]) - 1 for name in names.split()]
        matrix = np.column_stack([STRETCH**power for power in powers])
        values = np.linalg.lstsq(matrix, force)[0]
        left, degrees = force - matrix @ values, 21 - len(powers)
        covariance = np.linalg.inv(matrix.T @ matrix) * (left @ left) / (degrees - 2)
        for i, one in enumerate((1, 3)):
            for j, two in enumerate((1, 3)):
                offsets = [
                    (values[powers.index(p)] if p in powers else 0) - found.values[k]
                    for k, p in ((i, one), (j, two))
                ]
                own = 0.0
                if one in powers and two in powers:
                    own = covariance[powers.index(one), powers.index(two)]
                expected[i, j] += weight * (own + offsets[0] * offsets[1]) / sum(weights.values())
    assert found.covariance == pytest.approx(expected, rel=1e-6)
    assert found.widening == pytest.approx(
        found.deviations / fit_force(STRETCH, force, law="K2*x + K4*x**3").deviations
    )
    assert any("times as wide: state the law" in doubt for doubt in found.doubts)


def test_few_points_allow_low_orders_alone() -> None:
    found = fit_force([-0.4, -0.1, 0.2, 0.5, 0.6], [-0.41, -0.1, 0.2, 0.51, 0.61])
    assert [names for names, _ in found.evidence] == ["K2", "K2 K3", "K2 K4"]
    found = fit_force([0.1, 0.2, 0.3, 0.4, 0.5, 0.6], [0.1, 0.21, 0.3, 0.41, 0.5, 0.62])
    assert [names for names, _ in found.evidence] == ["K2", "K2 K3", "K2 K3 K4"]


def test_hertz_is_the_law_of_the_catalogue() -> None:
    stretch = np.linspace(-0.5, 0.08, 41)
    force = noisy(lambda x: -10 * (0.1 - x) ** 1.5, 0, stretch)
    found = fit_force(stretch, force, law="hertz")
    assert found.law.force == LATTICES["granular"].bonds[0].force
    assert found.lattice.bonds == LATTICES["granular"].bonds
    assert (abs(found.values - [10, 0.1]) < 3 * found.deviations).all()
    assert (found.deviations < [0.03, 1e-3]).all()
    fixed = fit_force(stretch, force, law="hertz", fixed={"d": "1/10"})
    assert fixed.deviations[0] < 0.5 * found.deviations[0]
    measured = fixed.lattice.measured
    assert measured is not None
    assert (float(dict(measured.values)["d"]), measured.deviations["d"]) == (0.1, 0.0)


def test_contacts_that_open_are_fitted() -> None:
    """Half of the points are beyond the opening, where the law has no slope."""
    stretch = np.linspace(-0.2, 0.4, 61)
    force = noisy(lambda x: -10 * np.maximum(0.1 - x, 0) ** 1.5, 0, stretch)
    found = fit_force(stretch, force, law="hertz")
    assert (abs(found.values - [10, 0.1]) < 3 * found.deviations).all()
    assert not found.doubts
    free = fit_force(stretch - 0.1, force, law="hertz", fixed={"d": 0})
    assert abs(free.values[0] - 10) < 3 * free.deviations[0]


def test_constants_that_hertz_needs_to_be_positive_are_so_declared() -> None:
    stretch = np.linspace(-0.5, 0.08, 41)
    noise = np.random.default_rng(0).normal(size=41)
    found = fit_force(stretch, -10 * (0.1 - stretch) ** 1.5 + noise, law="hertz")
    assert (found.values < 5 * found.deviations).any()
    assert found.lattice.bonds == LATTICES["granular"].bonds


def test_the_lattice_has_the_constants_with_their_covariance() -> None:
    found = fit_force(STRETCH, noisy(lambda x: x + 2 * x**3, 3), law="K2*x + K4*x**3")
    lattice = found.lattice
    assert lattice.text().endswith("F(x) = K2 x + K4 x^3")
    assert [symbol.is_positive for symbol in lattice.constants] == [True, True]
    measured = lattice.measured
    assert measured is not None
    assert [float(value) for _, value in measured.values] == found.values.tolist()
    assert np.array_equal(measured.covariance, found.covariance)
    uncertain = fit_force(STRETCH, noisy(np.sin, 3), law="K2*x + K4*x**3").lattice
    assert [symbol.is_positive for symbol in uncertain.constants] == [True, None]


def test_a_fit_pickles_with_what_it_has_computed() -> None:
    found = fit_force(STRETCH, noisy(cubic, 3), law="K2*x + K4*x**3", fixed={"K4": "1/2"})
    again = pickle.loads(pickle.dumps(found))
    assert np.array_equal(again.residuals, found.residuals)
    assert again.lattice == found.lattice


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e4])
def test_units_of_any_size_make_no_difference(scale: float) -> None:
    """Catches: normal equations of constants that differ by 20 orders of magnitude."""
    found = fit_force(scale * STRETCH, noisy(cubic, 3), law="K2*x + K3*x**2 + K4*x**3")
    usual = fit_force(STRETCH, noisy(cubic, 3), law="K2*x + K3*x**2 + K4*x**3")
    powers = scale ** np.arange(1, 4)
    assert found.values * powers == pytest.approx(usual.values, rel=1e-8)
    assert found.deviations * powers == pytest.approx(usual.deviations, rel=1e-8)


MAGNETS = np.linspace(-0.4, 0.8, 25)


def test_a_narrow_valley_is_followed_to_its_end() -> None:
    """Catches: all constants searched for at once, of which some then still move after 300 steps.

    The right values are SciPy's, from a start beside them.
    """
    exact = -2 / (1 + MAGNETS) ** 3.5
    deviation = 0.01 * abs(exact)
    for scale in (1.0, 1e-3, 40.0):
        force = exact + deviation * np.random.default_rng(4).normal(size=25)
        found = fit_force(scale * MAGNETS, force, deviation, "-A/(d + x)**p")
        values, covariance = optimize.curve_fit(
            lambda x, A, d, p: -A / (d + x) ** p,
            MAGNETS,
            force,
            (2, 1, 3.3),
            deviation,
            absolute_sigma=True,
            xtol=1e-12,
        )
        powers = np.array([scale ** values[2], scale, 1.0])
        assert found.values / powers == pytest.approx(values, rel=1e-5)
        sizes = np.sqrt(np.diag(covariance))[1:]
        assert found.deviations[1:] / powers[1:] == pytest.approx(sizes, rel=1e-3)


@pytest.mark.parametrize(
    ("law", "force"),
    [
        ("-A/(d + x)**p", lambda x: -2 * np.exp(-3 * x)),
        ("-A/(d + x)**p", lambda x: x),
    ],
)
@pytest.mark.parametrize("deviation", [None, np.full(25, 0.02)])
def test_constants_without_a_minimum_are_no_fit(
    law: str, force: Callable[[Points], Points], deviation: Points | None
) -> None:
    """Catches: the end of a search at infinity, or where the law ends, taken for a minimum."""
    noise = 0.02 * np.random.default_rng(0).normal(size=25)
    with pytest.raises(ValueError, match=r"constants must be determined|whose constants have not"):
        fit_force(MAGNETS, force(MAGNETS) + noise, deviation, law)


def test_a_constant_that_the_points_hardly_know_is_doubted() -> None:
    """Catches: an interval by derivatives believed where the law is far from linear."""
    force = -2 * np.exp(-3 * MAGNETS)
    found = fit_force(MAGNETS, force, np.full(25, 0.02), "-A*exp(-p*x)/(d + x)")
    assert "d is not determined: its deviation exceeds its value" in found.doubts


@pytest.mark.parametrize("size", [1e-310, 1e-200, 1e-30, 1e30])
@pytest.mark.parametrize("place", [0, 1, 2])
def test_numbers_near_the_ends_of_doubles_are_told(size: float, place: int) -> None:
    """Catches: powers of a stretch of 1e-310, which overflow."""
    given = [STRETCH, noisy(cubic, 0), np.full(21, NOISE)]
    given[place] = size * given[place]
    with pytest.raises(ValueError, match=r"must be of a size from 1e-20 to 1e\+20, got"):
        fit_force(*given)


def test_a_number_near_zero_among_others_is_a_point() -> None:
    stretch = STRETCH.copy()
    stretch[10] = 1e-310
    force = noisy(cubic, 3)
    assert fit_force(stretch, force).values == pytest.approx(fit_force(STRETCH, force).values)


def test_laws_that_the_points_do_not_tell_apart_are_not_chosen() -> None:
    """Catches: an error with the advice to fix a constant of a law that nobody stated."""
    stretch = 1 + 1e-9 * np.arange(12)
    found = fit_force(stretch, 1 + noisy(np.sin, 0, np.arange(12.0)))
    assert found.names == ["K2"]


def advice(law: str, points: tuple[Points, Points]) -> str:
    """The formula or value that the error of this law proposes."""
    with pytest.raises(ValueError, match=r"\(.*\)$") as error:
        fit_force(*points, law=law)
    match = re.search(
        r"(?:such as|into x:) (.+?)(?: with d positive|, or state another law)?\)$",
        str(error.value),
    )
    assert match is not None, str(error.value)
    return match[1]


@pytest.mark.parametrize("law", ["-A*contact(-x)**p", "K*sqrt(x)", "x", "K2*y", "a*b*x"])
def test_advice_of_an_error_is_accepted(law: str) -> None:
    """Catches: advice in another language than that of the formulas."""
    points = STRETCH, -((2 - STRETCH) ** 1.5) + noisy(cubic, 0)
    proposal = advice(law, points)
    name, equals, value = proposal.partition("=")
    found = fit_force(*points, law=law, fixed={name: value}) if equals else None
    assert (found or fit_force(*points, law=proposal)).values.size


def test_points_without_noise_are_no_wrong_law() -> None:
    found = fit_force(STRETCH, 2 * STRETCH)
    assert found.law.text == "K2*x"
    assert found.values == pytest.approx([2])
    assert not found.doubts
    assert math.isnan(found.smooth_p_value)


@pytest.mark.parametrize(
    ("law", "message"),
    [
        ("K2*x + ", "law: expected a number, a name or '\\(', got the end"),
        ("__import__('os')", "law: expected a formula, got '_'"),
        ("x", "a formula in the stretch x and constants, one of them not fixed, got 'x'"),
        ("K2*y", "a formula in the stretch x and constants"),
        ("K2*x*eps", "a formula in the stretch x and constants"),
        ("T*x", "constants must have names other than"),
        ("K*sqrt(x)", "force must be real and smooth about zero stretch"),
        ("a*b*x", "determined by the points, got a, b, other values .* such as a=1"),
        ("a*x + b*x**2 + c*x**2/3", "determined by the points, got b, c, other"),
        ("a*log(-1 - exp(b*x))", "law must be defined from stretch"),
    ],
)
def test_what_is_no_law_is_told(law: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        fit_force(STRETCH, noisy(cubic, 0), law=law)


@pytest.mark.parametrize(
    ("law", "fixed", "message"),
    [
        ("K2*x", {"K3": 1}, "fixed constants must be among K2, got 'K3'"),
        ("K2*x", {"K2": 1}, "one of them not fixed"),
        ("K2*x + K3*x**2", {"K3": "eps"}, "K3 must not depend on eps"),
        (None, {"K2": 1}, "fixed constants must come with a formula, got K2 and none"),
    ],
)
def test_what_cannot_be_fixed_is_told(law: str | None, fixed: dict[str, str], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        fit_force(STRETCH, noisy(cubic, 0), law=law, fixed=fixed)


LINES = [f"{x:.3f},{f:.4f}" for x, f in zip(STRETCH, noisy(cubic, 2), strict=True)]
UP = np.linspace(0, 1, 21)
FILES: dict[str, tuple[str, str]] = {
    "empty": ("", "line 1 must name the columns stretch, force .* got ''"),
    "no header": ("\n".join(LINES), r"line 1 must name .* got '-0.500,-0.5\d+' \(write stretch,f"),
    "other header": ("mm,N\n" + "\n".join(LINES), "line 1 must name the columns"),
    "a column more": ("stretch,force,time\n1,2,3\n", "line 1 must name the columns"),
    "word": ("stretch,force\n0,0\n0.1,abc\n", "line 3 must hold finite numbers, got '0.1,abc'"),
    "nan": ("stretch,force\n0,0\n0.1,nan\n", "line 3 must hold finite numbers, got '0.1,nan'"),
    "inf": ("stretch,force\n0,0\n0.1,inf\n", "line 3 must hold finite numbers"),
    "short": ("stretch,force\n0,0\n0.1\n", "line 3 must hold 2 numbers, stretch force, got '0.1'"),
    "blank": ("stretch,force\n0,0\n\n1,1\n", "line 3 must hold 2 numbers, stretch force, got ''"),
    "comma": ("stretch;force\n0;0\n0,1;0,1\n", "line 3 must hold finite numbers"),
    "few": ("stretch,force\n0,0\n1,1\n", "points must be 4 to 100000, got 2"),
    "few for it": ("stretch,force\n0,0\n1,1\n2,2\n3,3.1\n", r"at least 5 for the 2 constants of"),
    "doubled": (
        "stretch,force\n" + "\n".join([*LINES, LINES[4]]),
        "rows must be different, got row 22 the same as row 5",
    ),
    "deviation": (
        "stretch,force,deviation\n0,0,1\n1,1,0\n2,2,1\n3,3,1\n",
        "deviation must satisfy deviation > 0, got 0 in row 2",
    ),
    "one stretch": ("stretch,force\n1,1\n1,2\n1,3\n1,4\n1,5\n", "stretch must vary, got 1"),
    "no force": ("stretch,force\n1,0\n2,0\n3,0\n4,0\n5,0\n", "force must vary, got 0 in all rows"),
    "order": (
        "stretch,force\n" + "\n".join(LINES[i * 8 % 21] for i in range(21)),
        r"stretch must rise or fall from row to row, got \d+ turns in 21 rows \(sort",
    ),
    "loop": (
        "stretch,force\n"
        + "\n".join(f"{x:.3f},{x + 0.1 * x * (1 - x):.4f}" for x in UP)
        + "\n"
        + "\n".join(f"{x:.3f},{x - 0.1 * x * (1 - x):.4f}" for x in UP[-2:0:-1]),
        r"loading and unloading must agree within the noise, .* \(hysteresis: .* rows 1 to 21\)",
    ),
    "bytes": ("stretch,force\n\udcff", "force law must be a text in UTF-8"),
}


@pytest.mark.parametrize("name", FILES)
def test_what_is_no_force_law_is_told_in_one_line(name: str, tmp_path: Path) -> None:
    text, message = FILES[name]
    path = tmp_path / "force.csv"
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(ValueError, match=message) as error:
        fit_points(read_force(path), stated_law("K2*x + K4*x**3"))
    assert str(error.value).count("\n") == 0
    assert name == "few for it" or "force.csv" in str(error.value)


@pytest.mark.parametrize(
    ("names", "order"), [("Displacement (mm),Load (N)", 1), ("Load (N);Extension (mm)", -1)]
)
def test_the_file_of_a_testing_machine_is_one_error_that_reads_it(
    names: str, order: int, tmp_path: Path
) -> None:
    """Catches: one error after the other, and advice that does not read the file."""
    path = tmp_path / "force.csv"
    mark = ";" if ";" in names else ","
    rows = [mark.join(line.split(",")[::order]) for line in LINES]
    path.write_text("\n".join(["# Instron 5940, spring 3", names, *rows]), "utf-8")
    with pytest.raises(ValueError, match="line 1 must name the columns stretch, force") as error:
        read_force(path)
    assert names.split(mark)[0] in str(error.value)
    remedy = (
        "(leave out the lines above, and write stretch,force,deviation, and state --units mm,N)"
    )
    assert str(error.value).endswith(f" in line 2, below a comment {remedy}")
    pytest.importorskip("pint")
    path.write_text("\n".join([mark.join(["stretch", "force"][::order]), *rows]), "utf-8")
    assert read_force(path, "mm,N").stretch == pytest.approx(1e-3 * STRETCH)


@pytest.mark.parametrize("mark", [",", ";", "\t"])
def test_a_file_is_read_with_any_mark_and_order_of_columns(mark: str, tmp_path: Path) -> None:
    path = tmp_path / "force.csv"
    rows = ["Force, stretch , deviation", "1,0.2,.1", "2,0.4,.1", "3,0.5,.2", "4,0.7,.3"]
    path.write_text("\n".join(rows).replace(",", mark) + "\n\n", "utf-8")
    found = read_force(path)
    assert found.stretch.tolist() == [0.2, 0.4, 0.5, 0.7]
    assert found.force.tolist() == [1, 2, 3, 4]
    assert found.deviation is not None
    assert found.deviation.tolist() == [0.1, 0.1, 0.2, 0.3]


@pytest.mark.parametrize("deviation", [None, NOISE])
def test_branches_that_agree_are_one_law(deviation: float | None) -> None:
    """Catches: a loop that is only noise, or that is only the chords between points."""
    for seed in range(20):
        stretch = np.concatenate([UP, UP[-2::-1] + 0.02, UP[1:]])
        sd = None if deviation is None else np.full(stretch.size, deviation)
        found = ForceData.of(stretch, noisy(cubic, seed, stretch), sd)
        assert found.stretch.size == 61
        assert (np.diff(found.stretch) >= 0).all()


@pytest.mark.parametrize("deviation", [None, NOISE])
def test_a_loop_wider_than_the_noise_is_one(deviation: float | None) -> None:
    stretch = np.concatenate([UP, UP[-2::-1]])
    width = np.concatenate([0.02 * np.ones(21), -0.02 * np.ones(20)])
    sd = None if deviation is None else np.full(stretch.size, deviation)
    for seed in range(20):
        with pytest.raises(ValueError, match="loading and unloading must agree"):
            ForceData.of(stretch, noisy(cubic, seed, stretch) + width, sd)


def test_a_loop_that_is_wide_in_one_place_is_one() -> None:
    """Catches: the loop's own shape taken for noise."""
    up = np.linspace(0, 1, 101)
    stretch = np.concatenate([up, up[-2::-1]])
    lens = 0.1 * np.exp(-(((stretch - 0.5) / 0.12) ** 2)) * np.repeat([0.5, -0.5], [101, 100])
    with pytest.raises(ValueError, match="loading and unloading must agree"):
        ForceData.of(stretch, noisy(cubic, 0, stretch) + lens)


def test_two_short_branches_are_no_loop_by_chance() -> None:
    stretch = np.array([0, 0.25, 0.5, 0.75, 1, 0.8, 0.6, 0.4, 0.2])
    for seed in range(100):
        found = ForceData.of(stretch, noisy(cubic, seed, stretch), np.full(9, NOISE))
        assert found.stretch.size == stretch.size


def test_jitter_of_the_stretch_is_no_turn() -> None:
    stretch = np.linspace(0, 1, 200) + 0.02 * np.random.default_rng(0).normal(size=200)
    assert ForceData.of(stretch, noisy(cubic, 0, stretch)).stretch.size == 200


def test_lists_that_are_none_are_told() -> None:
    for given, message in (
        (([1, 2, 3, 4], [1, 2, 3]), "force must have a number for each stretch, 4, got 3"),
        (("a", [1]), "every stretch must be a real number, got 'a'"),
        (([1, 2, 3, 4], [1, math.nan, 3, 4]), "force must be finite, got nan in row 2"),
        (([[1, 2], [3, 4]], [1, 2]), "stretch must be a list of numbers"),
    ):
        with pytest.raises(ValueError, match=message):
            fit_force(*given)  # type: ignore[arg-type]


def written(folder: Path) -> Path:
    path = folder / "force.csv"
    path.write_text("stretch,force,deviation\n" + "\n".join(f"{x},0.01" for x in LINES), "utf-8")
    return path


def test_units_are_brought_to_metres_and_newtons(tmp_path: Path) -> None:
    pytest.importorskip("pint")
    plain, scaled = read_force(written(tmp_path)), read_force(written(tmp_path), "mm,kN")
    assert scaled.stretch == pytest.approx(1e-3 * plain.stretch)
    assert scaled.force == pytest.approx(1e3 * plain.force)
    assert scaled.deviation == pytest.approx(np.full(21, 10.0))
    assert read_force(written(tmp_path), "inch, kgf").stretch == pytest.approx(
        0.0254 * plain.stretch
    )


@pytest.mark.parametrize(
    ("units", "message"),
    [
        ("mm", "--units must be a length and a force, got 'mm'"),
        ("mm,N**9", r"--units must be a length and a force, got 'mm,N\*\*9'"),
        ("mm,kg", "got kg, which cannot be converted to N"),
        ("N,mm", "got N, which cannot be converted to m "),
        ("mmm,N", "got mmm, which is not a known unit"),
    ],
)
def test_wrong_units_are_told(units: str, message: str, tmp_path: Path) -> None:
    if "got '" not in message:
        pytest.importorskip("pint")
    with pytest.raises(ValueError, match=message):
        read_force(written(tmp_path), units)


def test_without_pint_units_say_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pint", None)
    with pytest.raises(ValueError, match=r"pip install 'longwave\[units\]'"):
        read_force(written(tmp_path), "mm,N")


def softening(stretch: Points) -> Points:
    return np.tanh(2 * stretch) + 0.1 * stretch


def test_a_spline_follows_what_no_polynomial_does() -> None:
    """Its law is 0 at no stretch and smooth there, and its slope is that of the law behind."""
    stretch = np.linspace(-1.2, 1.5, 91)
    deviation = np.full(91, 0.004)
    force = softening(stretch) + deviation * np.random.default_rng(5).normal(size=91)
    found = fit_force(stretch, force, deviation, law="table")
    assert not found.doubts
    assert fit_force(stretch, force, deviation).doubts
    fine = np.linspace(-1.2, 1.5, 400)
    assert np.abs(found.forces(fine) - softening(fine)).max() < 0.01
    assert found.forces(np.zeros(1)) == 0.0
    place = found.law.free.index(Symbol("K2", real=True))
    assert abs(found.values[place] - 2.1) < 3.0 * found.deviations[place]
    chain = found.lattice
    assert len(chain.bonds) == 1 + len(chain.unfelt_constants)
    numbers = numeric_lattice(chain, dict(found.measured.values))
    total = sum(bond.force(fine) for bond in numbers.bonds)
    np.testing.assert_allclose(total, found.forces(fine), atol=1e-12)


def test_splines_of_exact_cubics_have_no_knots() -> None:
    force = noisy(cubic, 3)
    found = fit_force(STRETCH, force, np.full(21, NOISE), law="table")
    assert [str(name) for name in found.law.free] == ["K2", "K3", "K4"]
    with pytest.raises(ValueError, match="fixed constants must come with a formula, got K2 and"):
        fit_force(STRETCH, force, law="table", fixed={"K2": 1})
