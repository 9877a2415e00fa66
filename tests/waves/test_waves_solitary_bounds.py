"""Bounds of a solitary wave's proof at coarse centres, against the same maps computed by FFT.

In a certificate the errors at the ends of the interval are far below the others. Here the interval
is short and the centre is off, so that each term counts.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from flint import arb, ctx, fmpq
from numpy.typing import NDArray

from longwave.waves.exact_wave import ExactWave
from longwave.waves.kernel.force_text import read_force
from longwave.waves.kernel.periodic import Contraction, Spring
from longwave.waves.kernel.solitary import SolitaryCentre, solitary_contraction
from longwave.waves.kernel.solitary_numbers import SolitaryNumbers
from longwave.waves.proved import proved
from longwave.waves.solitary_waves import solitary_certificate

Vector = NDArray[np.float64]

LENGTH, POINTS = 48.0, 2**13
X = LENGTH * (2 * np.arange(POINTS) / POINTS - 1)
STEP = 2 * LENGTH / POINTS
K = 2 * np.pi * np.fft.fftfreq(POINTS, STEP)


def norm(f: Vector) -> float:
    return float(np.sqrt(STEP * (f**2).sum()))


@dataclass(frozen=True)
class Line:
    """Chain with V' = r + a r^2, and its kernels on the line."""

    factor: float
    speed: float

    def kernel(self, g: Vector, power: int = 1) -> Vector:
        square = np.sinc(K / 2 / np.pi) ** 2
        image = np.fft.fft(g) * square / (self.speed**2 - square) ** power
        return np.asarray(np.fft.ifft(image).real)

    def defect(self, g: Vector) -> Vector:
        return g - self.factor * self.kernel(g) ** 2

    def derivative(self, g: Vector, h: Vector) -> Vector:
        return h - 2 * self.factor * self.kernel(g) * self.kernel(h)


def on_line(centre: SolitaryCentre, modes: Any) -> Vector:
    """Return a cosine series on (-d, d), 0 outside."""
    d = float(centre.half_length)
    total = sum((2 if n else 1) * float(c) * np.cos(np.pi * n * X / d) for n, c in enumerate(modes))
    return np.asarray(np.where(np.abs(X) < d, total, 0.0))


def applied_inverse(centre: SolitaryCentre, h: Vector) -> Vector:
    """Return A h: the inverse on the first cosines on (-d, d), else the identity."""
    d, count = float(centre.half_length), centre.linear.count
    waves = [np.where(np.abs(X) < d, np.cos(np.pi * n * X / d), 0.0) for n in range(count)]
    basis = np.array([w / norm(w) for w in waves])
    inverse = np.array([[float(c) for c in row] for row in centre.linear.inverse.tolist()])
    known = STEP * basis @ h
    return np.asarray(h + (inverse @ known - known) @ basis)


@pytest.fixture(scope="module")
def wave() -> ExactWave:
    springs = [Spring(1, read_force("r + r**2"))]
    return proved(lambda: solitary_certificate(springs, fmpq(11, 10), 1e-10), ExactWave)


LINE = Line(1.0, 1.1)


def coarse(wave: ExactWave, d: float, scale: float = 1, block: int = 16) -> SolitaryCentre:
    """Return a centre on (-d, d) with the forces of the wave times ``scale``."""
    count = 24
    x = d * (np.arange(8 * count) + 0.5) / (8 * count)
    forces = scale * wave.at(x) ** 2
    modes = np.cos(np.pi * np.outer(np.arange(count), x) / d) @ forces / len(x)
    return SolitaryCentre(
        springs=(Spring(1, read_force("r + r**2")),),
        speed_squared=arb(fmpq(121, 100)),
        half_length=arb(d),
        kappa=arb("1.375"),
        modes=([arb(float(c)) for c in modes],),
        block=block,
        radius_bound=arb("0.25"),
    )


@pytest.fixture(autouse=True)
def _precision() -> Any:
    before, ctx.prec = ctx.prec, 128
    yield
    ctx.prec = before


CENTRES = [(4.0, 1.0), (6.0, 1.0), (3.0, 1.0), (8.0, 1.03), (5.0, 0.9), (2.0, 1.0)]


@pytest.mark.parametrize(("d", "scale"), CENTRES)
def test_the_defect_is_bounded(wave: ExactWave, d: float, scale: float) -> None:
    centre = coarse(wave, d, scale)
    defect = norm(applied_inverse(centre, LINE.defect(on_line(centre, centre.modes[0]))))
    bound = float(solitary_contraction(centre).y0)
    assert defect <= 1.01 * bound  # a hundredth for the grid, on which g jumps at the ends


def shapes(d: float) -> list[Vector]:
    """Return even functions in the middle, at the ends, and outside."""
    places = [0, d / 3, 2 * d / 3, d - 1, d - 0.3, d + 0.3, d + 1, d + 3]
    bumps = [
        np.exp(-((np.abs(X) - place) ** 2) / width**2) for place in places for width in (0.3, 1.5)
    ]
    ends = [np.where(np.abs(X) > d, np.exp(rate * (d - np.abs(X))), 0) for rate in (0.6, 1.2)]
    inside = [np.where(np.abs(X) < d, np.cos(np.pi * n * X / d), 0) for n in (0, 1, 2, 5, 17, 20)]
    edge = [np.where(np.abs(X) < d, np.exp(np.abs(X) - d), 0)]
    return [*bumps, *ends, *inside, *edge]


@pytest.mark.parametrize(("d", "block"), [(2.0, 16), (4.0, 16), (6.0, 16), (8.0, 3), (8.0, 20)])
def test_the_linear_part_is_bounded(wave: ExactWave, d: float, block: int) -> None:
    centre = coarse(wave, d, block=block)
    bounds = solitary_contraction(centre)
    g = on_line(centre, centre.modes[0])
    largest = 0.0
    for h in shapes(d):
        image = h - applied_inverse(centre, LINE.derivative(g, h))
        largest = max(largest, norm(image) / norm(h))
    bound = float(bounds.z0 + bounds.z1)
    assert largest <= bound


def test_the_second_derivative_is_bounded(wave: ExactWave) -> None:
    centre = coarse(wave, 6)
    second = float(solitary_contraction(centre).z2)
    g = on_line(centre, centre.modes[0])
    for shift in (np.exp(-(X**2)), np.exp(-np.abs(X) / 2)):
        change = 0.1 * shift / norm(shift)
        for h in shapes(6):
            difference = LINE.derivative(g + change, h) - LINE.derivative(g, h)
            assert norm(applied_inverse(centre, difference)) <= second * 0.1 * norm(h)


@pytest.mark.parametrize(("d", "scale"), CENTRES)
@pytest.mark.parametrize("power", [1, 2, 3])
def test_the_kernels_are_bounded(wave: ExactWave, d: float, scale: float, power: int) -> None:
    """Catches images that are left out: periodic and whole line, in (-d, d) and outside."""
    centre = coarse(wave, d, scale)
    kappa, inside = float(centre.kappa), np.abs(X) < d
    g = on_line(centre, centre.modes[0])
    y = LINE.kernel(g, power)
    modes = centre.boxed(centre.potential(centre.modes, power), 1)
    error = np.abs(on_line(centre, modes) - y)[inside] * np.exp(kappa * (d - np.abs(X[inside])))
    bound = float(centre.periodic_error(power, centre.weight))
    assert error.max() <= bound
    assert norm(y) <= float(centre.norm_of_kernel(power)) * norm(g)
    if power == 1:
        outer = np.abs(y[~inside]) * np.exp(kappa * (np.abs(X[~inside]) - d))
        assert outer[np.abs(X[~inside]) < d + 5].max() <= float(centre.outer)
        assert np.abs(y).max() <= float(centre.embedding) * norm(g)


NUMBERS: list[tuple[str, Callable[[SolitaryNumbers], arb]]] = [
    ("crest", lambda numbers: numbers.crest),
    ("energy", lambda numbers: numbers.energy),
    ("momentum", lambda numbers: -numbers.speed * numbers.stretch),
]


@pytest.mark.parametrize(("name", "number"), NUMBERS)
@pytest.mark.parametrize(("d", "scale"), [*CENTRES, (12.0, 1.001), (12.0, 0.999)])
def test_numbers_contain_those_of_the_wave(
    wave: ExactWave,
    name: str,
    number: Callable[[SolitaryNumbers], arb],
    d: float,
    scale: float,
) -> None:
    """Catches an error that is left out: the wave is within ``radius`` of a coarse centre."""
    centre = coarse(wave, d, scale)
    exact = LINE.kernel(np.where(np.abs(X) < 30, wave.at(X) ** 2, 0))
    radius = norm(exact**2 - on_line(centre, centre.modes[0])) * 1.0001
    bounds = solitary_contraction(centre)
    value = number(SolitaryNumbers(centre, bounds, arb(radius)))
    assert abs(float(value.mid()) - wave.numbers[name].value) <= float(value.rad())


@pytest.mark.parametrize(("d", "scale"), CENTRES)
def test_the_profile_is_within_its_error(wave: ExactWave, d: float, scale: float) -> None:
    """Catches the tail outside the interval that is left out."""
    centre = coarse(wave, d, scale)
    exact = np.where(np.abs(X) < 30, wave.at(X), 0)
    radius = norm(exact**2 - on_line(centre, centre.modes[0])) * 1.0001
    numbers = SolitaryNumbers(centre, solitary_contraction(centre), arb(radius))
    difference = np.abs(exact - on_line(centre, centre.strain))
    assert difference.max() <= float(numbers.profile_error)


@pytest.mark.parametrize(("d", "scale"), [(9.0, 1.0), (12.0, 1.0005), (12.0, 0.9995)])
def test_the_energy_slope_contains_that_of_the_wave(
    wave: ExactWave, d: float, scale: float
) -> None:
    centre = coarse(wave, d, scale, block=22)
    g = on_line(centre, centre.modes[0])
    radius = norm(wave.at(X) ** 2 - g) * 1.0001
    change = np.zeros(POINTS)
    slope, second = 2 * wave.at(X), LINE.kernel(g, 2)
    for _ in range(20):
        push = slope * (LINE.kernel(change) + second)
        change = change - applied_inverse(centre, change - push)
    waves = [np.where(np.abs(X) < d, np.cos(np.pi * n * X / d), 0) for n in range(24)]
    modes = [arb(float(STEP * w @ change / (2 * d))) for w in waves]
    numbers = SolitaryNumbers(centre, solitary_contraction(centre), arb(radius))
    value = numbers.energy_slope([modes])
    assert abs(float(value.mid()) - wave.numbers["energy_slope"].value) <= float(value.rad())


def test_a_centre_that_is_not_a_wave_has_a_large_defect(wave: ExactWave) -> None:
    centre = coarse(wave, 8)
    halved = replace(centre, modes=([c / 2 for c in centre.modes[0]],))
    assert solitary_contraction(halved).y0 > 100 * solitary_contraction(centre).y0


ERRORS = [
    ("y0", "delta"),
    ("y0", "edge_slope"),
    ("y0", "third"),
    ("y0", "outer"),
    ("y0", "outer_third"),
    ("z1", "delta"),
    ("z1", "edge_slope"),
    ("z1", "third"),
    ("z1", "outer"),
    ("z1", "outer_third"),
    ("z1", "images"),
    ("z2", "third"),
    ("z2", "outer_third"),
    ("z2", "embedding"),
]


@pytest.mark.parametrize(("bound", "name"), ERRORS)
def test_every_error_counts(wave: ExactWave, bound: str, name: str) -> None:
    """Catches a term that is left out of a bound, though the others are larger."""
    before = float(getattr(solitary_contraction(coarse(wave, 4)), bound))
    centre = coarse(wave, 4)
    centre.__dict__[name] = 10**6 * getattr(centre, name)
    assert float(getattr(solitary_contraction(centre), bound)) > 10 * before


NUMBER_ERRORS = [
    ("crest", "delta"),
    ("crest", "embedding"),
    ("energy", "delta"),
    ("energy", "outer"),
    ("energy", "outer_third"),
    ("energy", "weight"),
    ("stretch", "outer"),
    ("stretch", "outer_third"),
]


@pytest.mark.parametrize(("number", "name"), NUMBER_ERRORS)
def test_every_error_of_a_number_counts(wave: ExactWave, number: str, name: str) -> None:
    before = getattr(SolitaryNumbers(coarse(wave, 4), _NO_BOUNDS, arb("0.01")), number)
    centre = coarse(wave, 4)
    centre.__dict__[name] = 10**6 * getattr(centre, name)
    after = getattr(SolitaryNumbers(centre, _NO_BOUNDS, arb("0.01")), number)
    assert float(after.rad()) > 10 * float(before.rad())


@pytest.mark.parametrize("name", ["slope_rest", "values_rest", "third", "outer_third"])
def test_every_error_of_the_derivative_counts(wave: ExactWave, name: str) -> None:
    results = []
    for factor in (0, 10**9):
        centre = coarse(wave, 9, block=22)
        bounds = solitary_contraction(centre)
        if name.endswith("_rest"):
            law = replace(centre.laws[0], **{name: arb(factor) / 10**9})
            centre.__dict__["laws"] = (law,)
        else:
            centre.__dict__[name] = (1 + factor) * getattr(centre, name)
        numbers = SolitaryNumbers(centre, bounds, arb("1e-6"))
        value = numbers.energy_slope(centre.modes) if name != "values_rest" else numbers.energy
        results.append(float(value.rad()))
    assert results[1] > 2 * results[0]


_NO_BOUNDS = Contraction(arb(0), arb(0), arb(0), arb(0))
