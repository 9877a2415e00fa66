"""Time-periodic orbits: known periods and multipliers, and certificates that must be refused."""

import copy
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from flint import arb, arb_mat, ctx, fmpq
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from sympy import sin

from longwave.derive import LATTICES, Lattice
from longwave.derive.lattice import on_site, spring
from longwave.derive.symbols import x
from longwave.waves.exact_orbit import ExactOrbit, exact_orbit
from longwave.waves.kernel import orbit as kernel
from longwave.waves.kernel.check import check_certificate
from longwave.waves.kernel.force_text import read_force
from longwave.waves.kernel.limits import CertificateError
from longwave.waves.kernel.monodromy import Monodromy, multipliers
from longwave.waves.kernel.orbit_claim import BreatherClaim, OrbitClaim
from longwave.waves.kernel.periodic import Spring
from longwave.waves.kernel.reading import Record
from longwave.waves.orbits import breather_certificate
from longwave.waves.proved import Existence, Interval
from longwave.waves.springs import Refused, chain_forces

Vector = NDArray[np.float64]
ALPHA = LATTICES["alpha_fput"].with_values({"K2": 1, "K3": "1/5"})
BETA = LATTICES["beta_fput"].with_values({"K2": 1, "K4": 1})
HARD = LATTICES["klein_gordon"].with_values({"K2": "2/25", "g1": 1, "g2": 0, "g3": 1})


@pytest.fixture(scope="module")
def q_breather() -> ExactOrbit:
    return exact_orbit(ALPHA, sites=5, energy="1/2")


@pytest.fixture(scope="module")
def breather() -> ExactOrbit:
    return exact_orbit(HARD, frequency="8/5")


def contains(interval: Interval, number: str) -> bool:
    """Return whether a number, rounded to its last digit, fits an interval."""
    unit = Fraction(1, 10 ** len(number.partition(".")[2]))
    low, high = Fraction(interval.lower), Fraction(interval.upper)
    return low - unit <= Fraction(number) <= high + unit


def test_a_q_breather_has_its_period_and_multipliers(q_breather: ExactOrbit) -> None:
    assert q_breather.verdict is Existence.EXISTS
    assert contains(q_breather.period, "12.035673940323662837")
    assert q_breather.period.error < 1e-19
    published = [
        ("0.846921153749", "0.531718496323"),
        ("-0.304695310026", "0.952449876922"),
        ("-0.347219518416", "0.937783880236"),
        ("-0.355851803205", "0.934542398266"),
    ]
    for z, (real, imaginary) in zip(q_breather.multipliers, published, strict=True):
        assert contains(z.real, real)
        assert contains(z.imaginary, imaginary)
        assert z.real.error < 1e-15
        assert not z.is_unstable
    assert "spectrally stable" in q_breather.statement
    assert q_breather.energy.value == 0.5


def test_a_breather_has_its_displacements(breather: ExactOrbit) -> None:
    middle = len(breather.start) // 2
    assert contains(breather.start[middle], "1.37775127348174")
    for n in (middle - 1, middle + 1):
        assert contains(breather.start[n], "-0.07749257455358")
    assert breather.amplitude.error < 1e-18
    assert contains(breather.period, "3.92699081698724154808")


def chain_slopes(
    force: Callable[[Vector], Vector], on: Callable[[Vector], Vector], q: Vector
) -> Vector:
    pull = force(np.diff(np.concatenate([[0.0], q, [0.0]])))
    return np.diff(pull) - on(q)


def returned(q: Vector, slopes: Callable[[Vector], Vector], period: float) -> Vector:
    """Return displacements and momenta after a time from rest at ``q``."""
    half = len(q)

    def rates(_: float, y: Vector) -> Vector:
        return np.concatenate([y[half:], slopes(y[:half])])

    start = np.concatenate([q, np.zeros(half)])
    solution = solve_ivp(rates, (0, period), start, method="DOP853", rtol=1e-12, atol=1e-13)
    return np.asarray(solution.y[:, -1])


def test_the_orbit_returns_and_its_multipliers_are_those_of_the_flow(
    q_breather: ExactOrbit,
) -> None:
    """Catches an orbit or a monodromy matrix of another chain."""
    q = np.array([value.value for value in q_breather.start])

    def slopes(q: Vector) -> Vector:
        return chain_slopes(lambda r: r + r * r / 5, np.zeros_like, q)

    period = q_breather.period.value
    assert np.abs(returned(q, slopes, period)[:5] - q).max() < 1e-9
    np.testing.assert_allclose(q_breather.at([0.0, period])[1], q, atol=1e-12)

    def perturbed(_: float, y: Vector) -> Vector:
        q, p, v = y[:5], y[5:10], y[10:].reshape(10, 10)
        stretch = np.diff(np.concatenate([[0.0], q, [0.0]]))
        g = 1 + 0.4 * stretch
        matrix = np.diag(g[1:] + g[:-1]) - np.diag(g[1:-1], 1) - np.diag(g[1:-1], -1)
        return np.concatenate([p, slopes(q), v[5:].ravel(), (-matrix @ v[:5]).ravel()])

    start = np.concatenate([q, np.zeros(5), np.eye(10).ravel()])
    flow = solve_ivp(perturbed, (0, period), start, method="DOP853", rtol=1e-12, atol=1e-13)
    values = np.linalg.eigvals(flow.y[10:, -1].reshape(10, 10))
    for z in q_breather.multipliers:
        distance = np.abs(values - complex(z.real.value, z.imaginary.value)).min()
        assert distance < 1e-8


def test_a_breather_returns(breather: ExactOrbit) -> None:
    q = np.array([value.value for value in breather.start])

    def slopes(q: Vector) -> Vector:
        return chain_slopes(lambda r: 0.08 * r, lambda u: u + u**3, q)

    end = returned(q, slopes, breather.period.value)
    assert np.abs(end - np.concatenate([q, 0 * q])).max() < 1e-10
    stretch = np.diff(np.concatenate([[0.0], q, [0.0]]))
    energy = np.sum(q**2 / 2 + q**4 / 4) + 0.04 * np.sum(stretch**2)
    assert abs(breather.energy.value - energy) < 1e-14
    assert breather.energy.error < 1e-20


def test_one_site_is_a_duffing_oscillator() -> None:
    """q'' = -2 q - 2 q^3 from q = 1, E = 3/2, has the period 2 K(1/4)."""
    orbit = exact_orbit(BETA, sites=1, energy="3/2")
    with mpmath.workdps(40):
        exact = str(mpmath.nstr(2 * mpmath.ellipk(mpmath.mpf(1) / 4), 20))
    assert contains(orbit.period, exact)
    assert contains(orbit.amplitude, "1.0")
    assert orbit.period.error < 1e-18
    assert orbit.multipliers == ()


def test_one_site_of_a_toda_chain() -> None:
    """q'' = -2 sinh q with the energy 2 cosh A - 2 = 1/2; catches a wrong potential or strip."""
    toda = LATTICES["toda"].with_values({"a": 1, "b": 1})
    orbit = exact_orbit(toda, sites=1, energy="1/2")
    with mpmath.workdps(30):
        top = mpmath.acosh(mpmath.mpf(5) / 4)
        period = 4 * mpmath.quad(
            lambda s: top * mpmath.cos(s)
            / mpmath.sqrt(4 * (mpmath.cosh(top) - mpmath.cosh(top * mpmath.sin(s)))),
            [0, mpmath.pi / 4, mpmath.pi / 2 - mpmath.mpf(10) ** -9],
        )  # fmt: skip
        assert contains(orbit.amplitude, mpmath.nstr(top, 18))
    assert abs(orbit.period.value - float(period)) < 1e-7
    assert orbit.period.error < 1e-15


def uncoupled(force: str, frequency: fmpq) -> dict[str, Any]:
    springs = (Spring(0, read_force(force)), Spring(1, read_force("0*r")))
    return breather_certificate(springs, frequency, 1e-10)


def test_a_breather_without_coupling_is_a_duffing_oscillator() -> None:
    """4 K(m) = 2 pi (1 + A^2)^(1/2)/Omega, m = A^2/(2 (1 + A^2))."""
    low, high = uncoupled("r + r**3", fmpq(3, 2))["claims"]["amplitude"]

    def defect(a: Any) -> Any:
        square = 1 + a * a
        return 4 * mpmath.ellipk(a * a / (2 * square)) - 2 * mpmath.pi * mpmath.sqrt(square) / 1.5

    with mpmath.workdps(30):
        exact = mpmath.nstr(mpmath.findroot(defect, mpmath.mpf(low)), 20)
    assert contains(Interval(low, high), exact)


def test_a_sine_force_has_a_breather() -> None:
    """Catches sites at rest that an analytic force moves."""
    bonds = (spring(x / 50, ((0,), 0), ((1,), 0)), on_site(sin(x)))
    lattice = Lattice("pendula", "pendula", ("u",), (x**0,), bonds)
    orbit = exact_orbit(lattice, frequency="9/10")
    q = np.array([value.value for value in orbit.start])
    end = returned(q, lambda q: chain_slopes(lambda r: r / 50, np.sin, q), orbit.period.value)
    assert np.abs(end[: len(q)] - q).max() < 1e-9


def test_an_unstable_orbit_says_so() -> None:
    lattice = LATTICES["klein_gordon"].with_values({"K2": "1/10", "g1": 1, "g2": 0, "g3": 1})
    orbit = exact_orbit(lattice, sites=2, mode=2, energy=1)
    assert any(z.is_unstable for z in orbit.multipliers)
    assert "UNSTABLE" in orbit.statement
    data = orbit.to_json()
    assert len(data["multipliers"]) == 1
    assert not any(name.startswith("multiplier_") for name in data)


def test_the_continuation_stays_on_its_branch() -> None:
    """Catches a jump to another mode: to mode 4 and to an orbit of a third of the period."""
    lattice = LATTICES["klein_gordon"].with_values({"K2": "1/10", "g1": 1, "g2": 0, "g3": 1})
    second, fourth = (exact_orbit(lattice, sites=4, mode=m, energy=1) for m in (2, 4))
    assert second.period.value > 1.05 * fourth.period.value
    assert exact_orbit(BETA, sites=3, energy=20).verdict is Existence.EXISTS


@pytest.mark.parametrize("cut", [1e-6, 5.0])
def test_the_bounds_hold_on_a_larger_space(cut: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches rows, columns or modes of the stiffness that the bound of I - A DF leaves out."""
    with ctx.workprec(128):
        finite = exact_orbit(ALPHA, sites=3, energy="1/5").certificate
        centre = OrbitClaim(Record(dict(finite), "certificate")).centre
        for weight in ("1", "1e-9"):
            _compare(replace(centre, weight=arb(weight)), cut, monkeypatch)
        infinite = exact_orbit(HARD, frequency="8/5").certificate
        centre = BreatherClaim(Record(dict(infinite), "certificate")).centre
        centre = replace(centre, modes=[m[:14] for m in centre.modes[15:-15]], margin=1)
        for top in (3, 9):
            _compare(replace(centre, block_top=top), cut, monkeypatch)


def _compare(centre: kernel.OrbitCentre, cut: float, monkeypatch: pytest.MonkeyPatch) -> None:
    infinite = centre.energy is None
    if not infinite:
        centre = replace(centre, modes=[modes[:9] for modes in centre.modes], block_top=6)
    monkeypatch.setattr(kernel, "STIFFNESS_CUT", cut)
    bounds = kernel.orbit_contraction(centre)
    block = kernel._Block(centre)
    monkeypatch.undo()
    margin = 3 if infinite else 0
    rest = [arb(0)] * len(centre.modes[0])
    padded = [*[rest] * margin, *centre.modes, *[rest] * margin]
    large = replace(
        centre, modes=[[*modes, *[arb(0)] * 6] for modes in padded], margin=0, block_top=2000
    )
    big = kernel._Block(large)
    first = int(not infinite)
    inverse = np.zeros((len(big.rows), len(big.rows)))
    places = list(range(first))
    small = [(n + margin, k) for n, k in centre.index]
    for i, (n, k) in enumerate(large.index):
        if (n, k) in small:
            continue
        inverse[i + first, i + first] = 1 / float(large.diagonal(k))
    places += [large.index.index(key) + first for key in small]
    inverse[np.ix_(places, places)] = np.array(block.inverse.tolist(), dtype=float)
    same = replace(large, margin=margin + centre.margin, block_top=centre.block_top)
    assert float(kernel._Block(same).defect()) == pytest.approx(float(block.defect()), rel=1e-7)
    jacobian = np.array([[float(c) for c in row] for row in big.jacobian.tolist()])
    rows = np.array([float(w) for w in big.rows])
    defect = np.abs(np.eye(len(rows)) - inverse @ jacobian)
    norm = float(((rows[:, None] * defect).sum(axis=0) / rows).max())
    assert norm <= float(bounds.z0 + bounds.z1) * (1 + 1e-7)
    assert norm > 0.2 * float(bounds.z1) or cut > 0.01


def test_the_matrix_is_the_derivative_of_the_equations() -> None:
    """Catches a wrong factor of a mean or a harmonic."""
    certificate = dict(exact_orbit(ALPHA, sites=2, energy="1/5").certificate)
    claim = OrbitClaim(Record(certificate, "certificate"))
    centre = replace(claim.centre, modes=[modes[:5] for modes in claim.centre.modes])

    def equations(shift: float, place: int) -> Vector:
        moved = [list(modes) for modes in centre.modes]
        square = centre.frequency_squared
        if place:
            n, k = centre.index[place - 1]
            moved[n][k] += shift
        else:
            square = square + shift
        other = replace(centre, modes=moved, frequency_squared=square)
        rows = [kernel.energy_at_start(other), *(other.residual(n, k) for n, k in other.index)]
        return np.array([float(row) for row in rows])

    jacobian = kernel._Block(centre).jacobian.tolist()
    for place in range(len(centre.index) + 1):
        slope = (equations(1e-5, place) - equations(-1e-5, place)) / 2e-5
        column = [float(row[place]) for row in jacobian]
        np.testing.assert_allclose(column, slope, atol=1e-8)


def test_the_errors_of_the_numbers_have_the_radius(
    q_breather: ExactOrbit, breather: ExactOrbit
) -> None:
    """Catches an error of the orbit that does not enter its numbers."""
    claim = OrbitClaim(Record({**q_breather.certificate, "radius": "1e-9"}, "certificate"))
    claim.monodromy = None
    numbers = claim.prove()
    square = float(claim.centre.frequency_squared)
    half_widths = {name: float(high - low) / 2 for name, (low, high) in numbers.items()}
    assert half_widths["amplitude"] == pytest.approx(1e-9, rel=1e-3)
    assert half_widths["period"] == pytest.approx(np.pi * square**-1.5 * 1e-9, rel=1e-3)
    centre = BreatherClaim(Record(dict(breather.certificate), "certificate")).centre
    middle = len(centre.modes) // 2
    moved = [list(modes) for modes in centre.modes]
    moved[middle][1] += 5e-4
    other = replace(centre, modes=moved)
    assert kernel.energy_at_start(centre, arb("1e-3")).contains(kernel.energy_at_start(other))


@pytest.mark.parametrize(("top", "steps", "order"), [(31, 20, 16), (17, 32, 44)])
def test_the_errors_of_the_multipliers(
    q_breather: ExactOrbit, top: int, steps: int, order: int
) -> None:
    """Catches errors of the Taylor series, or of a coarse orbit, that are left out."""
    with ctx.workprec(128):
        fine = OrbitClaim(Record(dict(q_breather.certificate), "certificate")).centre
        missing = sum((2 * abs(c) * fine.nu**k for modes in fine.modes
                       for k, c in enumerate(modes) if k >= top), arb(0))  # fmt: skip
        cut = [modes[:top] for modes in fine.modes]
        coarse = replace(fine, modes=cut, weight=arb(10) ** 30)
        pairs = multipliers(Monodromy(coarse, missing + arb("1e-22"), steps, order).half())
        for pair, z in zip(pairs, q_breather.multipliers, strict=True):
            low, high = arb(z.real.lower), arb(z.real.upper)
            assert pair.value.real.contains(low)
            assert pair.value.real.contains(high)
            assert high - low < pair.value.real.rad() < 1e-3


@pytest.mark.parametrize("weight", [1, 10_000])
def test_the_bound_of_the_second_derivative(weight: int) -> None:
    """Catches a factor: each site feels 4 times the slope 2/5 of V", and the energy both V"."""
    with ctx.workprec(128):
        certificate = dict(exact_orbit(ALPHA, sites=3, energy="1/5").certificate)
        centre = OrbitClaim(Record(certificate, "certificate")).centre
        centre = replace(centre, weight=arb(weight), radius_bound=arb("0.01"))
        bounds, block = kernel.orbit_contraction(centre), kernel._Block(centre)
        q = [float(modes[0] + 2 * sum(modes[1:], arb(0))) for modes in centre.modes]
        slopes = 1 + 0.4 * (np.diff([0.0, *q, 0.0]) + 0.01)
        energy = float(block.size_of_energy) * (slopes[1:] + slopes[:-1]).max()
        rest = max(1.6 * float(block.size), float(block.size_of_squares) / weight)
        assert float(bounds.z2) == pytest.approx(rest + energy, rel=1e-9)
        assert (rest > 1.6 * float(block.size)) == (weight == 1)


def changed(certificate: Any, **changes: Any) -> dict[str, Any]:
    return {**copy.deepcopy(dict(certificate)), **changes}


def test_a_changed_orbit_is_refused(q_breather: ExactOrbit) -> None:
    certificate: dict[str, Any] = dict(q_breather.certificate)
    modes = certificate["modes"]
    zero = [["0"] * len(site) for site in modes]
    stiff = {"lattice": {"springs": [{"neighbour": 1, "force": "r + r**2 + r**30"}]}}
    changes: list[tuple[str, dict[str, Any]]] = [
        ("fails", {"energy": "0.5001"}),
        ("fails", {"frequency_squared": "0.27"}),
        ("fails", {"modes": [*modes[:-1], zero[0]]}),
        ("same length", {"modes": [*modes[:-1], modes[0][:-1]]}),
        ("same length", {"modes": []}),
        ("same length", {"modes": [[]] * 5}),
        ("a list of at most", {"modes": ["0"] * 5}),
        ("fails", {"modes": [site[:8] for site in modes]}),
        ("radius", {"radius": "1e-3"}),
        ("radius", {"radius": "0"}),
        ("fails", {"radius": "1e-30"}),
        ("nu >= 1", {"nu": "9/10"}),
        ("nu >= 1", {"weight": "0"}),
        ("nu >= 1", {"frequency_squared": "-1"}),
        ("fails", {"nu": "1"}),
        ("all sites", {"block": {"margin": 1, "top": 2000}}),
        ("fails", {"block": {"margin": 0, "top": 2}}),
        ("claim period", {"claims": {"period": ["12.03", "12.035"]}}),
        ("unknown", {"claims": {"periods": ["12", "13"]}}),
        ("unknown", {"block": {"margin": 0, "top": 30, "bottom": 1}}),
        ("unknown", {"frequency": "1"}),
        ("steps", {"multipliers": {"steps": 0, "order": 44}}),
        ("not", {"multipliers": {"steps": 2, "order": 4}, "claims": {}}),
        ("entries", {"modes": [["0"] * 1900] * 40, "block": {"margin": 0, "top": 1}, **stiff}),
        ("entries", {"modes": [["0"] * 1900] * 20, "block": {"margin": 0, "top": 2000}}),
    ]  # fmt: skip
    for message, change in changes:
        with pytest.raises(CertificateError, match=message):
            check_certificate(changed(certificate, **change))


def test_a_force_that_only_looks_alike_is_refused(q_breather: ExactOrbit) -> None:
    springs = [{"neighbour": 1, "force": "r + r**2/5 + r**3/1000000000"}]
    with pytest.raises(CertificateError, match="fails"):
        check_certificate(changed(q_breather.certificate, lattice={"springs": springs}))


def test_rest_is_no_breather(breather: ExactOrbit) -> None:
    """Catches the zero centre, which solves the equations exactly."""
    certificate = dict(breather.certificate)
    zero = [["0"] * len(site) for site in certificate["modes"]]
    with pytest.raises(CertificateError, match="q = 0 is no orbit"):
        check_certificate(changed(certificate, modes=zero, claims={}))


def test_a_changed_breather_is_refused(breather: ExactOrbit) -> None:
    certificate: dict[str, Any] = dict(breather.certificate)
    coupling = {"neighbour": 1, "force": "2*r/25"}
    forces = {
        "resonant": "12*r/5 + r**3",
        "0 at rest": "r + r**3 + 1/1000",
        "more harmonics": "200*r + r**3",
        "fails": "r + r**3 + r**2/1000000",
    }
    changes: list[tuple[str, dict[str, Any]]] = [
        *(
            (message, {"lattice": {"springs": [{"neighbour": 0, "force": text}, coupling]}})
            for message, text in forces.items()
        ),
        ("fails", {"frequency": "1.6001"}),
        ("frequency > 0", {"frequency": "-8/5"}),
        ("must have a site", {"block": {"margin": 100, "top": 3}}),
        ("fails", {"block": {"margin": 17, "top": 1}, "radius": "1e-24"}),
        ("fails", {"modes": certificate["modes"][10:-10], "block": {"margin": 2, "top": 3}}),
        ("unknown", {"energy": "2"}),
        ("claim energy", {"claims": {"energy": ["2", "2.02"]}}),
        ("claim amplitude", {"claims": {"amplitude": ["0", "1.37"]}}),
    ]
    for message, change in changes:
        with pytest.raises(CertificateError, match=message):
            check_certificate(changed(certificate, **change))


def propagator(products: list[list[float]]) -> arb_mat:
    """Return P with b = 1 and c half of a matrix, so that A = 1 + ``products``."""
    size = len(products)
    zero, unit = np.zeros((size, size)), np.eye(size)
    return arb_mat(np.block([[unit, unit], [np.array(products) / 2, zero]]).tolist())


def test_multipliers_on_and_off_the_circle() -> None:
    """mu = 1/2, -2, 3 and -2 +- i beside 1 have multipliers in closed form."""
    products = np.diag([0.0, -0.5, -3.0, 2.0, -3.0, -3.0])
    products[4, 5], products[5, 4] = 1.0, -1.0
    result = {complex(z.value): z.is_on_circle for z in multipliers(propagator(products.tolist()))}
    square = (-2 + 1j) - ((-2 + 1j) ** 2 - 1) ** 0.5
    expected = {
        0.5 + 0.75**0.5 * 1j: True,
        -2 - 3**0.5: False,
        3 + 8**0.5: False,
        square: False,
        square.conjugate(): False,
    }
    for value, on_circle in expected.items():
        (near,) = [z for z in result if abs(z - value) < 1e-12]
        assert result[near] is on_circle
    assert len(result) == len(expected)


@pytest.mark.parametrize(
    ("products", "message"),
    [
        ([[0.0, 0.0, 0.0], [0.0, -0.5, 0.0], [0.0, 0.0, -0.5]], "different"),
        ([[0.0, 0.0], [0.0, -2.0]], "separated from 1 or -1"),
        ([[1.0, 0.0], [0.0, -0.5]], "not separated from the others"),
    ],
)
def test_multipliers_that_are_not_separated(products: list[list[float]], message: str) -> None:
    with pytest.raises(CertificateError, match=message):
        multipliers(propagator(products))


def test_what_states_no_orbit() -> None:
    for options, message in (
        ({}, "got none"),
        ({"sites": 5, "frequency": 1}, "got both"),
        ({"sites": 5}, "energy must be positive"),
        ({"sites": 100, "energy": 1}, "sites must be"),
        ({"sites": 5, "mode": 6, "energy": 1}, "mode must be"),
        ({"frequency": -1}, "frequency must be positive"),
        ({"frequency": 1, "energy": 1}, "without an energy"),
    ):
        with pytest.raises(ValueError, match=message):
            exact_orbit(ALPHA, **options)  # type: ignore[arg-type]


def test_lattices_outside_the_theorems_are_refused() -> None:
    strain = LATTICES["fput_strain"].with_values({"K2": 1, "K3": 0, "K4": 1})
    assert "displacement" in exact_orbit(strain, sites=3, energy=1).reason
    assert exact_orbit(BETA, frequency=3).verdict is Existence.REFUSED
    with pytest.raises(Refused):
        chain_forces(strain)


def test_a_frequency_in_the_band_is_not_proved() -> None:
    orbit = exact_orbit(HARD, frequency="51/50")
    assert orbit.verdict is Existence.REFUSED
    assert "harmonic 1" in orbit.reason
    soft = exact_orbit(HARD, frequency="9/10")
    assert soft.verdict is Existence.NOT_PROVED
    assert soft.reason == "no oscillation of one site has this frequency"


@pytest.mark.slow
@pytest.mark.parametrize("energy", ["1/100", "1/10", "1/2"])
def test_q_breathers_of_eight_sites(energy: str) -> None:
    """An independent integration returns to the start."""
    lattice = LATTICES["fput"].with_values({"K2": 1, "K3": "1/4", "K4": "1/5"})
    orbit = exact_orbit(lattice, sites=8, mode=2, energy=energy)
    assert orbit.verdict is Existence.EXISTS
    q = np.array([value.value for value in orbit.start])

    def slopes(q: Vector) -> Vector:
        return chain_slopes(lambda r: r + r**2 / 4 + r**3 / 5, np.zeros_like, q)

    end = returned(q, slopes, orbit.period.value)
    assert np.abs(end[:8] - q).max() < 1e-8
