"""Solitary waves of all small eps next to solitons, and certificates that must be refused."""

import copy
import dataclasses
from typing import Any

import mpmath
import numpy as np
import pytest
from flint import arb, ctx, fmpq

from longwave.derive import LATTICES
from longwave.waves.certificates import contracting_radius
from longwave.waves.exact_wave import ExactWave, exact_wave, waves_of_all_eps
from longwave.waves.kernel import line_tie_claim
from longwave.waves.kernel.check import check_certificate
from longwave.waves.kernel.cosine_series import norm
from longwave.waves.kernel.force_text import read_force
from longwave.waves.kernel.limits import CertificateError
from longwave.waves.kernel.line_block import line_block
from longwave.waves.kernel.line_tie import (
    LineTiePiece,
    Soliton,
    defect,
    line_tie_contraction,
    tie_block,
)
from longwave.waves.kernel.periodic import Contraction, Spring
from longwave.waves.kernel.reading import Record
from longwave.waves.line_ties import Corrections, line_tie_certificate
from longwave.waves.proved import Existence

SLOW = pytest.mark.slow


def tie(eps: str, near: str = "soliton", **values: object) -> ExactWave:
    return waves_of_all_eps(LATTICES["fput_strain"].with_values(values), near=near, eps=eps)


MKDV: dict[str, object] = {"K2": 1, "K3": 0, "K4": 1}
KDV: dict[str, object] = {"K2": 1, "K3": 1, "K4": 0}


def ends(certificate: Any) -> tuple[mpmath.mpf, mpmath.mpf]:
    (claim,) = certificate["claims"].values()
    low, high = map(mpmath.mpf, claim)
    return low, high


def soliton(p: int, x: Any) -> Any:
    omega = mpmath.sqrt(12)
    if p == 3:
        return mpmath.sqrt(2) * mpmath.sech(omega * x)
    return 1.5 * mpmath.sech(omega * x / 2) ** 2


def first_correction(p: int, b: Any) -> Any:
    """Return sup |psi|, psi the limit of (phi - Y)/eps^2 as eps -> 0.

    (1 - D^2/12 - p Y^(p-1)) psi = Y''''/360 + (Y^p)''/12 + b Y^(2 p - 1) has the even solution
    alpha Y + beta Y^p - x Y'/5.
    """
    beta = 3 * (b - 2) / mpmath.mpf(4) if p == 2 else (b - 3.6) / mpmath.mpf(3)
    alpha = -3 * beta - 2.4 if p == 2 else (-8 * beta - 5.4) / 2

    def psi(x: Any) -> Any:
        y = soliton(p, x)
        return alpha * y + beta * y**p - x * mpmath.diff(lambda t: soliton(p, t), x) / 5

    values = [abs(psi(mpmath.mpf(i) / 100)) for i in range(150)]
    place = max(range(150), key=values.__getitem__)
    if not place:
        return values[0]
    return abs(psi(mpmath.findroot(lambda x: mpmath.diff(psi, x), mpmath.mpf(place) / 100)))


FORCES = [
    ("r + r**2", 2, 0, 1.0, "K2 = 1, next to eps^2 Y(x) = eps^2 (3/2) sech(3^(1/2) eps x)^2"),
    ("2*r - r**2 + r**3/2", 2, 1, 2.0, "K2 = 2, next to eps^2 Y(x) = eps^2 (-3) sech("),
    pytest.param("r + r**3", 3, 0, 1.0, "eps Y(x) = eps (2)^(1/2) sech(12^(1/2)", marks=SLOW),
    pytest.param("r + 4*r**3 + 16*r**5", 3, 1, 0.5, "eps (1/2)^(1/2) sech", marks=SLOW),
]


@pytest.mark.parametrize(("force", "p", "b", "scale", "wave"), FORCES)
def test_the_limit_is_that_of_the_closed_form(
    force: str, p: int, b: int, scale: float, wave: str
) -> None:
    """Catches any error of the equation's first correction: it is known in closed form."""
    certificate = line_tie_certificate(Spring(1, read_force(force)), fmpq(1, 100))
    statement = check_certificate(certificate)
    assert f"V'(r) = {force} has" in statement
    assert wave in statement
    low, high = ends(certificate)
    limit = scale * first_correction(p, b)
    assert low < limit < high
    assert high - low < 0.05 * limit


def distance_by_iteration(p: int, eps: float) -> float:
    """Return sup |phi - Y|/eps^2 of a wave by Petviashvili's iteration in double precision."""
    count, half = 4096, 8.0
    x = (np.arange(count) - count // 2) * 2 * half / count
    xi = 2 * np.pi * np.fft.fftfreq(count, 2 * half / count)
    mu = np.sinc(eps * xi / (2 * np.pi)) ** 2
    multiplier = mu / (1 + (1 - mu) / eps**2)
    y = np.array([float(soliton(p, float(at))) for at in x])
    phi = y.copy()
    for _ in range(200):
        image = np.fft.ifft(multiplier * np.fft.fft(phi**p)).real
        # <phi, phi>/<phi, image> is 1 at the wave; the power is that of the fastest convergence
        phi = image * (np.sum(phi * phi) / np.sum(phi * image)) ** (p / (p - 1))
    assert np.abs(phi - np.fft.ifft(multiplier * np.fft.fft(phi**p)).real).max() < 1e-13
    return float(np.abs(phi - y).max()) / eps**2


@pytest.mark.parametrize(("force", "p"), [("r + r**2", 2), pytest.param("r + r**3", 3, marks=SLOW)])
def test_one_value_of_eps_agrees_to_four_digits(force: str, p: int) -> None:
    """Catches errors of order eps^2, which the limit does not show."""
    corrections = Corrections(Soliton.of(read_force(force)))
    corrections.solve(arb("0.04"))
    piece = corrections.at(arb("0.04"))
    bounds = line_tie_contraction(piece)
    bound = arb(contracting_radius(bounds))
    bounds.require(bound, piece.bound)
    low, high = map(float, dataclasses.replace(piece, bound=bound).distance)
    assert low - 5e-5 < distance_by_iteration(p, 0.2) < high < low + 2e-3


@SLOW
@pytest.mark.parametrize(
    ("values", "p", "expected"), [(MKDV, 3, (0.93, 1.50)), (KDV, 2, (0.91, 0.94))]
)
def test_single_waves_are_within_the_bounds_of_all(
    values: dict[str, object], p: int, expected: tuple[float, float]
) -> None:
    wave = tie("7/100", **values)
    assert wave.verdict is Existence.EXISTS
    assert "For every 0 < eps <= 7/100" in wave.statement
    low, high = map(float, ends(wave.certificate))
    assert expected[0] < low < high < expected[1]
    for eps in (0.02, 0.05, 0.07):
        assert low < distance_by_iteration(p, eps) < high


@SLOW
def test_a_solitary_wave_proved_by_itself_is_within_the_bounds() -> None:
    """v = 545/544 is that of eps = 33/544."""
    eps = 33 / 544
    lattice = LATTICES["fput_strain"].with_values(MKDV)
    wave = exact_wave(lattice, speed="545/544")
    x = np.linspace(-20, 20, 801)
    y = np.sqrt(2) / np.cosh(np.sqrt(12) * eps * x)
    distance = np.abs(wave.at(x) - eps * y).max() / eps**3
    low, high = map(float, ends(tie("7/100", **MKDV).certificate))
    assert low < distance < high


@SLOW
def test_a_wide_range_is_proved_too() -> None:
    """Catches pieces that are not divided where the proof needs it."""
    low, high = ends(tie("1/5", **KDV).certificate)
    assert low < distance_by_iteration(2, 0.2) < high < 1.1


@pytest.mark.parametrize("p", [2, 3])
def test_the_soliton_has_the_stated_transform_and_bounds(p: int) -> None:
    wave = Soliton.of(read_force("r + r**2" if p == 2 else "r + r**3"))
    for xi in (0, 1, 5):
        value = 2 * mpmath.quad(lambda x, k=xi: soliton(p, x) * mpmath.cos(k * x), [0, 1, 4, 12])
        assert abs(value - mpmath.mpf(float(wave.transform(arb(xi))))) < 1e-12
    second, fourth = 3 * p * (p * p - 1), {2: 144, 3: 720}[p]
    assert abs(float(wave.source_bound) - second / 12 - fourth / 360) < 1e-12
    for i in range(30):
        x = mpmath.mpf(i) / 20
        y = soliton(p, x)
        force = mpmath.diff(lambda t: soliton(p, t) ** p, x, 2)
        assert abs(force) <= second * y * (1 + 1e-8)
        assert abs(mpmath.diff(lambda t: soliton(p, t), x, 4)) <= fourth * y * (1 + 1e-8)
        assert y <= float(wave.front) * mpmath.exp(-mpmath.sqrt(12) * x)


def piece_of(**changes: Any) -> LineTiePiece:
    data = {
        "soliton": Soliton.of(read_force("r + r**3")), "square": arb("0.01"),
        "half_length": arb(7), "kappa": arb("2.9"), "correction": [arb(0)], "top": 40,
        "bound": arb("0.5"),
    }  # fmt: skip
    return LineTiePiece(**{**data, **changes})


@pytest.mark.parametrize("square", ["1e-4", "0.01", "0.1"])
def test_the_kernel_decays_as_stated(square: str) -> None:
    """Catches a constant C that is too small: K is computed by a sum of cosines."""
    piece = piece_of(square=arb(square))
    s, step = float(square), 0.02
    xi = step * (np.arange(200_000) + 0.5)
    mu = np.sinc(np.sqrt(s) * xi / (2 * np.pi)) ** 2
    multiplier = mu / (1 + (1 - mu) / s)
    for x in (0.0, 0.3, 1.0, 1.6):
        kernel = step / np.pi * np.sum(multiplier * np.cos(xi * x))
        assert -1e-3 < kernel < float(piece.decay_constant) * np.exp(-2.9 * x)
    assert np.all(multiplier <= 1 / (1 + xi * xi / 12) + 1e-15)
    assert piece.multiplier(41) <= piece.tail
    # |K*h| <= ||K|| ||h||, with equality for h = K
    assert np.sqrt(step / np.pi * np.sum(multiplier**2)) < float(piece.embedding)


def test_the_distance_allows_for_the_remainder() -> None:
    exact, wide = piece_of(bound=arb(0)).distance, piece_of(bound=arb("0.1")).distance
    assert exact[0] - wide[0] >= arb("0.09306")
    assert wide[1] - exact[1] >= arb("0.09306")


def values(modes: Any, half_length: float, x: Any) -> Any:
    order = np.arange(len(modes))
    modes = np.array([float(c) for c in modes]) * np.where(order, 2, 1)
    return np.cos(np.pi * np.outer(x, order) / half_length) @ modes


def test_a_short_interval_shows_its_images() -> None:
    """Catches bounds that leave out what the periodic sum adds, or what is outside (-d, d)."""
    short, wide = piece_of(half_length=arb("2.5")), piece_of(half_length=arb(9))
    inside, outside = np.linspace(0, 2.5, 101), np.linspace(2.5, 5, 101)
    names = ("modes", "change")
    for name, error, outer in zip(names, short.periodic_errors, short.outer, strict=True):
        exact = values(getattr(wide, name), 9, inside)
        difference = np.abs(values(getattr(short, name), 2.5, inside) - exact).max()
        assert 1e-5 < difference < float(error)
        assert np.abs(values(getattr(wide, name), 9, outside)).max() < float(outer)


@pytest.mark.parametrize("force", ["r + r**3", "r + r**2"])
def test_the_modes_left_out_are_bounded(force: str) -> None:
    """Catches powers of the wavenumber that are left out of the tail of T."""
    piece = piece_of(soliton=Soliton.of(read_force(force)))
    total_y = total_t = arb(0)
    for n in range(len(piece.modes), 3 * len(piece.modes)):
        square = piece.wavenumber(n) * piece.wavenumber(n)
        value = piece.soliton.transform(piece.wavenumber(n)) / piece.half_length
        total_y += value
        total_t += value * (square / 12 + square * square * (arb(1) / 144 + arb(1) / 360))
    assert total_y < piece.rests[0]
    assert total_t < piece.rests[1]


def test_every_bound_of_the_theorem_enters() -> None:
    """Catches a term that is left out: on a short interval each is large."""
    s, c, kappa, d = 0.01, 0.5, 2.9, 2.5
    piece = piece_of(half_length=arb("2.5"))
    bounds, (block, _) = line_tie_contraction(piece), tie_block(piece)
    y, z = map(float, piece.periodic_errors)
    outer_y, outer_z = map(float, piece.outer)
    front_y, front_z = map(float, piece.fronts)
    z_size = float(norm(piece.change, arb(1)))
    reach = np.sqrt(2) + y + s * (z_size + z)
    size = float(block.size)
    outside = outer_z * 3 * (outer_y + s * outer_z) ** 2 / np.sqrt(2 * kappa)
    inner = np.sqrt(2 * d) * (6 * reach * (z_size + z) * y + 3 * reach**2 * z)
    assert float(bounds.y0) > (1 - 1e-9) * (
        float(block.image_size([defect(piece)])) + size * inner + outside
    )
    slope = 3 * (front_y + s * front_z) ** 2 * np.exp(-kappa * d) * np.sqrt(2 * d / kappa)
    edges = 3 * float(piece.decay_constant) * slope
    least = size * (edges + 6 * reach * (y + s * z)) + 3 * (outer_y + s * outer_z) ** 2
    assert float(bounds.z1) > (1 - 1e-6) * least
    assert bounds.z0 == block.contraction
    assert float(bounds.z2) > size * 6 * (reach + s * c * 0.93) * s * 0.93


@pytest.mark.parametrize("beyond", [1.0, 0.01])
def test_the_block_bounds_the_whole_operator(beyond: float) -> None:
    """Catches parts of I - A (I - W K_per) that are left out: 160 modes by quadrature."""
    d, top, count, points = 2.0, 12, 160, 640
    slope = [arb("0.9"), arb("-0.4"), arb("0.3"), arb("0.2"), arb("-0.1")]

    def multiplier(n: int) -> arb:
        return (arb(beyond) if n > top else 1) / (1 + arb(n * n) / 30)

    block = line_block([slope], lambda n: [[multiplier(n)]], multiplier(top + 1), top + 1, arb(d))
    x = d * (np.arange(points) + 0.5) / points
    basis = np.cos(np.pi * np.outer(x, np.arange(count)) / d) / np.sqrt(d)
    basis[:, 0] /= np.sqrt(2)
    weights = 2 * d / points * values(slope, d, x)
    product = basis.T @ (weights[:, None] * basis) * [float(multiplier(n)) for n in range(count)]
    inverse = np.eye(count)
    inverse[: top + 1, : top + 1] = np.array(block.inverse.tolist(), dtype=float)
    # the last modes couple to those beyond 160
    whole = (np.eye(count) - inverse @ (np.eye(count) - product))[:, :-4]
    norm_of_whole = np.linalg.norm(whole, 2)
    assert norm_of_whole < float(block.contraction) < 4 * norm_of_whole
    assert np.linalg.norm(inverse, 2) < float(block.size)
    f = [arb(n) / 7 for n in (3, -2, *range(20))]
    scaled = np.array([float(c) for c in f]) * 2 * np.sqrt(d)
    scaled[0] /= np.sqrt(2)
    image = inverse[: len(f), : len(f)] @ scaled
    assert abs(float(block.image_size([f])) - np.linalg.norm(image)) < 1e-9


CONSTANTS = [
    ({"kappa": "3.47"}, "0 < kappa < sqrt"),
    ({"kappa": "-1"}, "0 < kappa < sqrt"),
    ({"square": "0.2"}, "eps kappa <= 1"),
    ({"kappa": "3.46", "square": "0.08"}, "take a smaller kappa"),
    ({"half_length": "0"}, "half_length > 0"),
    ({"half_length": "5000"}, "too large for the modes"),
    ({"bound": "0"}, "bound > 0"),
]


@pytest.mark.parametrize(("changes", "message"), CONSTANTS)
def test_constants_without_a_theorem_are_refused(changes: dict[str, str], message: str) -> None:
    piece = piece_of(**{name: arb(value) for name, value in changes.items()})
    with pytest.raises(CertificateError, match=message):
        line_tie_contraction(piece)


@pytest.fixture(scope="module")
def certificate() -> dict[str, Any]:
    return dict(tie("1/50", **KDV).certificate)


def springs(force: str, neighbour: int = 1) -> dict[str, Any]:
    return {"lattice": {"springs": [{"neighbour": neighbour, "force": force}]}}


def changes_of(certificate: dict[str, Any]) -> list[dict[str, Any]]:
    """Return changes, those first that are refused soon."""
    pieces = certificate["pieces"]
    first = pieces[0]
    half = {**first, "bound": str(float(first["bound"]) / 2)}
    zero = {**first, "correction": ["0"] * len(first["correction"])}
    cut = {**first, "correction": first["correction"][:40]}
    claim = certificate["claims"]["distance_over_eps4"]
    return [
        {"eps": "0"},
        {"eps": "-1/50"},
        {"pieces": []},
        {"pieces": pieces[::-1]},
        {"pieces": [half, *pieces[1:]]},
        {"pieces": [zero, *pieces[1:]]},
        {"pieces": [{**first, "weight": "1"}, *pieces[1:]]},
        {"block": 1500},
        {"block": 4},
        springs("r**2 + r", 2),
        springs("r - r**3"),
        springs("r"),
        springs("sinh(r)"),
        springs("1 + r + r**2"),
        {"half_length": "2"},
        {"kappa": "0.5"},
        {"pieces": [cut, *pieces[1:]]},
        springs("1.01*r**2 + r"),
        springs("r**2 + r + r**3"),
        {"eps": "1/49"},
        {"pieces": pieces[:-1]},
        {"pieces": pieces[1:]},
        {"pieces": [*pieces, pieces[-1]]},
        {"near": {"form": "dn", "k": "3/5"}},
        {"claims": {"distance_over_eps4": ["0.93", claim[1]]}},
        {"claims": {"distance_over_eps4": [claim[0], "0.92"]}},
        {"claims": {"distance_over_eps3": claim}},
    ]


@pytest.mark.parametrize("part", [slice(14), pytest.param(slice(14, None), marks=SLOW)])
def test_a_changed_certificate_is_refused(certificate: dict[str, Any], part: slice) -> None:
    for change in changes_of(certificate)[part]:
        with pytest.raises(CertificateError):
            check_certificate({**copy.deepcopy(certificate), **change})


def test_the_claim_covers_every_piece(
    certificate: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ctx, "prec", certificate["bits"])
    claim = line_tie_claim.LineTieClaim(Record(certificate, "certificate"))
    low, high = ends(certificate)
    for piece in claim.read():
        least, most = (mpmath.mpf(end.str(25, radius=False)) for end in piece.distance)
        assert low <= least * (1 + 1e-20)
        assert most * (1 - 1e-20) <= high


def test_the_zero_wave_is_refused(
    certificate: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches phi = 0, whose distance from the soliton is Y(0)."""
    far = {**certificate, "pieces": copy.deepcopy(certificate["pieces"])}
    for piece in far["pieces"]:
        piece["correction"][0] = "-5000"
    zero = arb(0)
    passing = Contraction(zero, zero, zero, zero)
    monkeypatch.setattr(line_tie_claim, "line_tie_contraction", lambda _: passing)
    with pytest.raises(CertificateError, match="differ from 0"):
        check_certificate(far)


def test_the_names_of_the_catalogue_state_the_equation() -> None:
    with pytest.raises(ValueError, match="near must be kdv_soliton"):
        tie("1/50", "soliton_sech", **KDV)
    with pytest.raises(ValueError, match="near must be soliton_sech"):
        tie("1/50", "kdv_soliton", **MKDV)


def test_what_states_no_soliton_is_refused() -> None:
    lattice = LATTICES["fput_strain"].with_values(MKDV)
    with pytest.raises(ValueError, match="k must not be given"):
        waves_of_all_eps(lattice, near="soliton", k="1/2", eps="1/50")
    with pytest.raises(ValueError, match="eps must be > 0"):
        waves_of_all_eps(lattice, near="soliton", eps=0)
    with pytest.raises(ValueError, match="all eps at once"):
        exact_wave(lattice, near="soliton", eps="1/50")
    defocusing = tie("1/50", **{**MKDV, "K4": -1})
    assert defocusing.verdict is Existence.REFUSED
    assert "K4 > 0" in defocusing.reason
    second = LATTICES["next_nearest"].with_values(
        {"K2": 1, "K3": 0, "K4": 1, "L2": "1/4", "L3": 0, "L4": 0}
    )
    assert waves_of_all_eps(second, near="soliton", eps="1/50").verdict is Existence.REFUSED


@pytest.mark.parametrize(
    ("force", "message"),
    [("r + r**3 + r**4", "odd powers"), ("r + exp(r)", "polynomial"), ("-r + r**2", "K2 > 0")],
)
def test_a_force_without_this_theorem_is_refused(force: str, message: str) -> None:
    with pytest.raises(CertificateError, match=message):
        Soliton.of(read_force(force))


def test_a_large_eps_is_not_proved() -> None:
    wave = tie("2/5", **MKDV)
    assert wave.verdict is Existence.NOT_PROVED
    assert "eps kappa <= 1" in wave.reason
