"""Solitary waves: energy, momentum, dH/dv and sign against closed forms and Newton's law."""

import copy
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath
import pytest
from flint import arb, ctx, fmpq

from longwave.waves.exact_wave import ExactWave
from longwave.waves.kernel.check import check_certificate
from longwave.waves.kernel.force_text import read_force
from longwave.waves.kernel.limits import CertificateError
from longwave.waves.kernel.line_kernel import LineKernel
from longwave.waves.kernel.periodic import Spring
from longwave.waves.kernel.reading import Record
from longwave.waves.kernel.solitary_claim import SolitaryClaim
from longwave.waves.proved import Existence, Interval, proved
from longwave.waves.solitary_waves import solitary_certificate
from longwave.waves.springs import Refused

Law = Callable[[Any], Any]


def wave_of(*forces: str, speed: str) -> ExactWave:
    """Return the solitary wave of a chain with a force for each neighbour."""
    springs = [Spring(m, read_force(text)) for m, text in enumerate(forces, start=1)]
    value = Fraction(speed)
    exact = fmpq(value.numerator, value.denominator)
    return proved(lambda: solitary_certificate(springs, exact, 1e-10), ExactWave)


def contains(interval: Interval, value: mpmath.mpf) -> bool:
    low, high = mpmath.mpf(interval.lower), mpmath.mpf(interval.upper)
    return bool(low <= value <= high and high - low < mpmath.mpf("1e-13") * abs(value))


def test_a_toda_soliton_has_its_closed_form() -> None:
    """Catches errors of any number; v = sinh k/k, H = 2 (sinh k cosh k - k)."""
    with mpmath.workdps(40):
        k = mpmath.findroot(lambda k: mpmath.sinh(k) / k - mpmath.mpf("1.1"), 0.8)
        sinh, cosh = mpmath.sinh(k), mpmath.cosh(k)
        numbers = wave_of("exp(r) - 1", speed="11/10").numbers
        assert contains(numbers["crest"], 2 * mpmath.log(cosh))
        assert contains(numbers["energy"], 2 * (sinh * cosh - k))
        assert contains(numbers["momentum"], -2 * sinh)
        slope = 4 * k**2 * sinh**2 / (k * cosh - sinh)
        low, high = (mpmath.mpf(end) for end in vars(numbers["energy_slope"]).values())
        assert low <= slope <= high
        assert high - low < mpmath.mpf("1e-9")


TARGETS = [
    ("r + r**2", "21/20", ".067511224271969585", ".627706144375643792"),
    ("r + r**3", "11/10", ".77166701797994484", "1.68855446533493156"),
]


@pytest.mark.parametrize(("force", "speed", "energy", "momentum"), TARGETS)
def test_energy_and_momentum(force: str, speed: str, energy: str, momentum: str) -> None:
    wave = wave_of(force, speed=speed)
    for interval, digits in ((wave.energy, energy), (wave.momentum, f"-{momentum}")):
        assert interval is not None
        for end in (interval.lower, interval.upper):
            assert abs(Fraction(end) - Fraction(digits)) < Fraction(2, 10**17)


@pytest.mark.slow
def test_the_energy_changes_with_the_speed_as_proved() -> None:
    """Catches a wrong derivative: five-point differences of the proved energies."""
    steps = [Fraction(s, 1000) for s in (-2, -1, 1, 2)]
    speeds = [Fraction(21, 20) + step for step in steps]
    energies = [wave_of("r + r**2", speed=str(speed)).numbers["energy"].value for speed in speeds]
    difference = (energies[0] - 8 * energies[1] + 8 * energies[2] - energies[3]) * 1000 / 12
    slope = wave_of("r + r**2", speed="21/20").numbers["energy_slope"]
    assert abs(difference - slope.value) < 1e-6
    assert slope.error < 1e-14


CHAINS: list[tuple[tuple[str, ...], str, tuple[Law, ...]]] = [
    (("1 - (1 - r)**(3/2)",), "27/20", (lambda r: -((1 - r) ** 1.5),)),
    (
        ("(1 + r)**(-7) - (1 + r)**(-13)",),
        "29/10",
        (lambda r: (1 + r) ** -7 - (1 + r) ** -13,),
    ),
    (("r + r**2/2", "r/8 + r**2/5"), "4/3", (lambda r: r + r**2 / 2, lambda r: r / 8 + r**2 / 5)),
    (("r + r**2", "-r/25"), "24/25", (lambda r: r + r**2, lambda r: -r / 25)),
    (("r + r**3", "0", "r/50"), "6/5", (lambda r: r + r**3, lambda r: 0, lambda r: r / 50)),
]


@pytest.mark.slow
@pytest.mark.parametrize(("forces", "speed", "laws"), CHAINS)
def test_newtons_law_holds(forces: tuple[str, ...], speed: str, laws: tuple[Law, ...]) -> None:
    """Catches a wrong symbol, stretch or force: r_n'' of the series is that of the chain."""
    wave = wave_of(*forces, speed=speed)
    assert wave.verdict is Existence.EXISTS, wave.reason
    with mpmath.workdps(30):
        f, second = _profile(wave)
        for x in (mpmath.mpf("0.3"), mpmath.mpf("1.7"), mpmath.mpf("-4.9")):
            total = mpmath.mpf(0)
            for m, law in enumerate(laws, start=1):
                stretch = {s: sum(f(x + s + i) for i in range(m)) for s in (-m, 1 - m, 0, 1)}
                pulls = {s: law(value) for s, value in stretch.items()}
                total += pulls[1] - pulls[1 - m] - pulls[0] + pulls[-m]
            expected = mpmath.mpf(Fraction(speed).numerator) / Fraction(speed).denominator
            assert abs(expected**2 * second(x) - total) < mpmath.mpf("1e-15")
            assert abs(second(x)) > 1e-6


def _profile(wave: ExactWave) -> tuple[Law, Law]:
    """Return the strain of the certificate's series and its second derivative."""
    with ctx.workprec(160):
        centre = SolitaryClaim(Record(dict(wave.certificate), "certificate")).centre
        modes = [mpmath.mpf(c.mid().str(40, radius=False)) for c in centre.strain]
        length = mpmath.mpf(centre.half_length.mid().str(40, radius=False))

    def series(x: Any, order: int) -> Any:
        k = [mpmath.pi * n / length for n in range(len(modes))]
        terms = (c * q**order * mpmath.cos(q * x) for q, c in zip(k, modes, strict=True))
        return (2 * sum(terms) - (0 if order else modes[0])) * (-1) ** (order // 2)

    return lambda x: series(x, 0), lambda x: series(x, 2)


SIGNS = [
    (("r + r**2",), "21/20", "f > 0 everywhere"),
    (("r - r**2",), "21/20", "f < 0 everywhere"),
    *(
        pytest.param(forces, speed, words, marks=pytest.mark.slow)
        for forces, speed, words in (
            (("r + r**2/2 - r**3/5",), "21/20", "f > 0 everywhere"),
            (("r + r**3",), "21/20", "f > 0 everywhere"),
            (("exp(-r) - exp(-2*r)",), "21/20", "f < 0 everywhere"),
            (("r + r**2", "r/10"), "5/4", "f > 0 everywhere"),
        )
    ),
]


@pytest.mark.parametrize(("forces", "speed", "words"), SIGNS)
def test_the_sign_is_stated(forces: tuple[str, ...], speed: str, words: str) -> None:
    assert words in wave_of(*forces, speed=speed).statement


def test_no_sign_is_stated_if_a_spring_pushes() -> None:
    """Catches a sign that is taken from the crest: with K_2 < 0 the kernel is not positive."""
    wave = wave_of("r + r**2", "-r/25", speed="24/25")
    assert wave.verdict is Existence.EXISTS, wave.reason
    assert "everywhere" not in wave.statement


def test_a_resonant_speed_is_refused() -> None:
    springs = [Spring(1, read_force("r + r**2")), Spring(2, read_force("-r/5"))]
    with pytest.raises(Refused, match=r"resonant with wavenumber 0\.5"):
        solitary_certificate(springs, fmpq(1, 2), 1e-10)


@pytest.fixture(scope="module")
def certificate() -> dict[str, Any]:
    return dict(wave_of("exp(r) - 1", speed="6/5").certificate)


def strip_with(certificate: dict[str, Any], **values: Any) -> dict[str, Any]:
    return {**certificate, "strip": {**certificate["strip"], **values}}


CHANGES: list[tuple[Callable[[dict[str, Any]], dict[str, Any]], str]] = [
    (lambda c: strip_with(c, margin="1e-9"), "margin"),
    (lambda c: strip_with(c, samples=16), "samples"),
    (lambda c: strip_with(c, rho="9/10"), "rho > nu"),
    (lambda c: {k: v for k, v in c.items() if k != "strip"}, "needs a strip"),
    (lambda c: {**c, "block": 3}, "fails"),
    (lambda c: {**c, "block": 0}, "block"),
    (lambda c: {**c, "kappa": "40"}, "kappa < 10"),
    (lambda c: {**c, "kappa": "3"}, "not proved positive"),
    (lambda c: {**c, "modes": []}, "modes must be"),
    (lambda c: {**c, "slope_modes": c["slope_modes"][:-1]}, "as many as modes"),
    (lambda c: {**c, "slope_modes": ["0"] * len(c["modes"])}, "claim energy_slope is not proved"),
    (lambda c: {k: v for k, v in c.items() if k != "slope_modes"}, "unknown keys: energy_slope"),
    (lambda c: {**c, "claims": {"energy": ["0.1", "0.2"]}}, "claim energy is not proved"),
    (lambda c: {**c, "claims": {"momentum": ["0", "9"]}}, "claim momentum is not proved"),
    (lambda c: {**c, "degree": 4}, "unknown keys: degree"),
]


@pytest.mark.parametrize(("change", "words"), CHANGES)
def test_a_changed_certificate_is_refused(
    certificate: dict[str, Any], change: Callable[[dict[str, Any]], dict[str, Any]], words: str
) -> None:
    with pytest.raises(CertificateError, match=words):
        check_certificate(change(copy.deepcopy(certificate)))


def test_without_slope_modes_the_other_numbers_are_proved(certificate: dict[str, Any]) -> None:
    claims = {name: certificate["claims"][name] for name in ("crest", "energy", "momentum")}
    shorter = {k: v for k, v in certificate.items() if k != "slope_modes"}
    assert "energy" in check_certificate({**shorter, "claims": claims})


def symbols(kernel: LineKernel, k: Any) -> Any:
    squares = [(s, (2 * mpmath.sin(m * k / 2) / k) ** 2) for m, s in kernel.stiffness]
    speed_squared = mpmath.mpf(str(float(kernel.speed_squared)))
    return speed_squared - sum(float(s) * square for s, square in squares)


KERNELS = [
    LineKernel(((1, arb(1)),), arb("1.1025"), arb("0.6"), (1,)),
    LineKernel(((1, arb(1)), (2, arb("-0.0625"))), arb("0.90625"), arb("0.6"), (1, 2)),
    LineKernel(((1, arb(1)), (8, arb("0.0625"))), arb(6), arb("0.125"), (1,)),
]


@pytest.mark.slow
@pytest.mark.parametrize("kernel", KERNELS)
def test_the_constants_bound_their_integrals_closely(kernel: LineKernel) -> None:
    """Catches missing pieces of the line: against mpmath's quadrature of the same integrals."""
    kappa = mpmath.mpf(str(float(kernel.kappa)))
    for power, constant in enumerate(kernel.constants, start=1):

        def density(x: Any, power: int = power) -> Any:
            k = mpmath.mpc(x, kappa)
            boxes = sum(abs(2 * mpmath.sin(m * k / 2) / k) ** 2 for m in kernel.boxes)
            return boxes / abs(symbols(kernel, k)) ** power

        edges = [0, *(mpmath.mpf(2) ** i / 16 for i in range(14)), 2000]
        integral = mpmath.quad(density, edges) / mpmath.pi
        assert integral < float(constant) < 1.7 * integral
