"""The contract: 1e-13 of max(1, |value|) everywhere, or an error that says what to do instead."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from longwave.derive import mkdv_normal_form
from longwave.solutions import CATALOGUE, ClosedForm, Wave, closed_form, rational

TOLERANCE = 1e-13
FOCUSING, DEFOCUSING = mkdv_normal_form(K2=4, K4=1), mkdv_normal_form(K2=1, K4=-1)
KINK = Wave(closed_form("kink"), DEFOCUSING, A=1)
PEREGRINE = Wave(rational(2), FOCUSING)


def repr_or_type(value: object) -> str:
    """Return a test's name for a value: its repr, or its type if that is too long."""
    return type(value).__name__ if isinstance(value, int) and value > 10**99 else repr(value)


def error(values: Any, reference: Any) -> float:
    """Return the worst error of Y, Y_X, Y_T in units of max(1, |value|)."""
    pairs = zip(values, reference, strict=True)
    return max(float(abs(float(v) - r) / max(1, abs(r))) for v, r in pairs)


@pytest.mark.parametrize("amplitude", [10, 40, 1000])
def test_steep_kinks(amplitude: int) -> None:
    """Catches: double arithmetic, where Y_T errs by 1.8e-12 at A = 10, by 3.9e-12 at A = 40."""
    wave = Wave(closed_form("kink"), DEFOCUSING, A=amplitude)
    for X in np.linspace(-3, 3, 25) / amplitude:
        assert error(wave(X, 0.0), wave.mp(float(X), 0, 40)) < TOLERANCE
    n = 80_000_000.0
    zero = wave.phase_zeros(n, 0.05)[0]
    for site in (zero, np.nextafter(zero, np.inf), round(zero)):
        found = wave.at(site, n, 0.05)
        assert error(found, wave.mp_at(float(site), n, 0.05, 40)) < TOLERANCE


def test_rogue_wave_at_a_strong_coupling() -> None:
    """Catches: double arithmetic, where Y_T errs by 9.8e-13 at k = 0.9, K2 = 1, K4 = 100."""
    wave = Wave(closed_form("rogue_cn"), mkdv_normal_form(K2=1, K4=100), k=0.9)
    for X in np.linspace(-0.2, 0.2, 5):
        for T in (0.0, -0.003):
            assert error(wave(X, T), wave.mp(float(X), T, 40)) < TOLERANCE


def test_tails_of_a_huge_derivative() -> None:
    """``1 - tanh**2`` loses Y_T, of size 1e21 on the kink, where it is as small as 1."""
    wave = Wave(closed_form("kink"), mkdv_normal_form(K2=1e-4, K4=-1e4), A=1000)
    X = 24.3 / 1000 / float(wave.normal_form.a)
    exact = wave.mp(X, 0, 40)
    assert 1 < abs(exact[2]) < 1e15
    assert error(wave(X, 0.0), exact) < TOLERANCE


def test_a_zero_of_a_huge_derivative_is_settled_in_mpmath() -> None:
    """At a zero of Y_T, elsewhere of size 1e20, double-double alone leaves rounding errors."""
    normal_form = mkdv_normal_form(K2=1e-4, K4=1e4)
    wave = Wave(closed_form("double_pole"), normal_form, A=1000, X_0=Fraction(1, 3))
    X = np.linspace(-1e-6, 1e-6, 4001)
    turn = np.flatnonzero(np.diff(np.sign(wave(X, 0.0).Y_T)))[0]
    low, high = X[turn], X[turn + 1]
    sign = np.sign(wave(low, 0.0).Y_T)
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if np.sign(wave(middle, 0.0).Y_T) == sign else (low, middle)
    assert np.max(abs(wave(X, 0.0).Y_T)) > 1e19
    assert error(wave(low, 0.0), wave.mp(float(low), 0, 60)) < TOLERANCE


@pytest.mark.parametrize(
    ("name", "position"),
    [
        *((name, x) for name in ("rational_2", "soliton_sech") for x in (1e15, 1e200, 1.7e308)),
        *((name, x) for name in ("wave_cn", "rogue_cn") for x in (1e15, 3e17, 1e22, -1e30, 1e40)),
        ("wave_cn", 1e200),
    ],
)
def test_any_finite_point(name: str, position: float) -> None:
    parameters = {"A": 2} if name == "soliton_sech" else {"k": 0.5}
    given = {} if name == "rational_2" else parameters
    wave = Wave(closed_form(name), FOCUSING, **given)
    for time in (0.0, position):
        found, exact = wave(position, time), wave.mp(position, time, 30)
        assert error(found, exact) < TOLERANCE


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("wave_sn", {"k": 0.01}),
        ("wave_cn", {"k": 0.5}),
        ("wave_dn", {"k": 0.9}),
        ("rogue_cn", {"k": 0.5}),
        ("soliton_dn", {"k": 0.9}),
        ("breather_sn", {"k": 0.5, "alpha": 0.5}),
        ("breather", {"p": 1000, "q": 1000}),
    ],
)
@pytest.mark.parametrize("t", [1e8, 3.3e8, -1e10])
def test_late_times_of_a_soft_lattice_under_a_strong_force(
    name: str, parameters: dict[str, float], t: float
) -> None:
    """Phases of 10^17 .. 10^28: the values were wrong by 1, or left to mpmath at every point."""
    form = closed_form(name)
    normal_form = mkdv_normal_form(K2=1e-4, K4=1e4 * int(form.equation.s))
    wave = Wave(form, normal_form, **parameters)
    centre = round(t * float(normal_form.c))
    found = wave.at(centre + np.arange(2000), t, 0.5)  # more than may be settled in mpmath
    for i in (0, 700):
        exact = wave.mp_at(centre + i, t, 0.5, 30)
        assert error((part[i] for part in found), exact) < TOLERANCE


@pytest.mark.parametrize("distance", ["1e-6", "1e-9", "1e-12"])
def test_the_whole_crest_of_a_rogue_wave_near_the_triple_pole(distance: str) -> None:
    """G_1 and the small part of G_2 cancel in 20 digits: 1 point in 14 was left to mpmath."""
    normal_form = mkdv_normal_form(K2=1, K4=1e4)
    wave = Wave(closed_form("rogue_cn"), normal_form, k=1 - Fraction(distance))
    X = np.linspace(-30, 30, 20_000) / float(normal_form.a)
    found = wave(X, 0.0)
    for i in range(0, X.size, 2_500):
        exact = wave.mp(float(X[i]), 0, 30)
        assert error((part[i] for part in found), exact) < TOLERANCE


@pytest.mark.parametrize("wave", ["wave_cn", "rogue_cn", "soliton_dn", "breather_sn"])
@pytest.mark.parametrize("end", [Fraction(1, 10**20), 1 - Fraction(1, 10**20)])
def test_moduli_beyond_double(wave: str, end: Fraction) -> None:
    form = closed_form(wave)
    extra = {"alpha": 1} if wave == "breather_sn" else {}
    normal_form = FOCUSING if form.equation.s > 0 else DEFOCUSING
    sample = Wave(form, normal_form, k=end, **extra)
    for X, T in ((0.3, 0.1), (-2.0, 0.0), (7.0, -1.0)):
        assert error(sample(X, T), sample.mp(X, T, 30)) < TOLERANCE


@pytest.mark.parametrize(
    ("name", "parameters", "coefficient"),
    [("kink", {"A": 1e300}, r"-?1\.0e\+300"), ("rogue_cn", {"k": 1e-300}, ".*e-600")],
)
def test_values_beyond_doubles_are_refused(
    name: str, parameters: dict[str, float], coefficient: str
) -> None:
    form = closed_form(name)
    wave = Wave(form, FOCUSING if form.equation.s > 0 else DEFOCUSING, **parameters)
    with pytest.raises(ValueError, match=rf"coefficient within .* got {coefficient} for .*Wave.mp"):
        wave(0.1, 0.2)
    assert wave.mp(0, 0, 20)[0] == pytest.approx(3e-300 if name == "rogue_cn" else 0)


def test_eps_out_of_range_is_refused() -> None:
    with pytest.raises(ValueError, match="parameters and eps must keep every coefficient"):
        KINK.at(0, 1.0, 1e-260)


def test_too_many_uncertain_points_are_refused() -> None:
    n = np.linspace(1e200, 2e200, 1200)
    wave = Wave(closed_form("wave_cn"), FOCUSING, k=0.5)
    with pytest.raises(
        ValueError, match=r"at most 1000 points .* got 1200, the first at \(1e\+200"
    ):
        wave(n, 0.0)


@pytest.mark.parametrize(
    "digits", [-1, 0, 1.5, True, "30", None, 10**9, 10**5000], ids=repr_or_type
)
def test_digits_are_a_whole_number(digits: Any) -> None:
    with pytest.raises(ValueError, match=r"^digits must be a whole number from 1 to 100000, got"):
        PEREGRINE.mp(0, 0, digits=digits)


@pytest.mark.parametrize("digits", [1, 2, 3, np.int64(5), 300])
def test_few_digits_and_many_are_right(digits: Any) -> None:
    assert PEREGRINE.mp(0, 0, digits=digits)[0] == 5
    Y, *_ = PEREGRINE.mp(Fraction(1, 3), Fraction(1, 7), digits=digits)
    exact, *_ = PEREGRINE.mp(Fraction(1, 3), Fraction(1, 7), digits=320)
    assert abs(Y / exact - 1) < 2 * 10.0 ** -int(digits)


@pytest.mark.parametrize("bad", [float("nan"), np.inf, "1", None, 1j, True, np.float64("nan")])
def test_the_reference_refuses_invalid_numbers(bad: Any) -> None:
    with pytest.raises(ValueError, match=r"^X must be"):
        PEREGRINE.mp(bad, 0)
    with pytest.raises(ValueError, match=r"^T must be"):
        PEREGRINE.mp(0, bad)


BAD_POINTS = {
    "datetime64": np.array(["2020-01-01"], dtype="datetime64[D]"),
    "timedelta64": np.array([1], dtype="timedelta64[s]"),
    "complex": np.array([1 + 0j]),
    "bool": np.array([True]),
    "text": "1",
    "texts": np.array(["1", "2"]),
    "bytes": b"1",
    "None": None,
    "objects": np.array([1, None], dtype=object),
    "complex object": np.array([1j], dtype=object),
    "true object": np.array([True, 2], dtype=object),
    "ragged": [[1.0], [1.0, 2.0]],
    "masked": np.ma.masked_array([1.0, 2.0], mask=[False, True]),
    "record": np.zeros(1, dtype=[("x", float)]),
    "huge": 10**400,
    "huge text": 10**5000,
    "odd": 2**53 + 1,
    "odd unsigned": np.array([2**64 - 1], dtype=np.uint64),
    "odd object": np.array([2**80 + 1], dtype=object),
    "long": np.array([np.longdouble(10) ** 400]),
    "set": {1.0},
    "dict": {"x": 1.0},
}


@pytest.mark.parametrize("name", BAD_POINTS)
def test_invalid_points_are_refused_in_one_line(name: str) -> None:
    bad: Any = BAD_POINTS[name]
    for call, word in (
        (lambda: KINK(bad, 0.0), "position"),
        (lambda: KINK(0.0, bad), "time"),
        (lambda: KINK.at(bad, 0.0, 0.1), "position"),
        (lambda: KINK.background(0.0, bad), "time"),
        (lambda: KINK.pairs_at(0.0, bad, 0.1), "time"),
    ):
        with pytest.raises(ValueError, match=rf"^(every|no).* {word} .*\)$") as caught:
            call()
        assert "\n" not in str(caught.value)


def test_shapes_that_do_not_broadcast() -> None:
    with pytest.raises(ValueError, match=r"must broadcast, got the shapes \(2,\) and \(3,\)"):
        KINK([1, 2], [1, 2, 3])


GOOD_POINTS = {
    "float16": np.array([0.5, -2.0], dtype=np.float16),
    "float32": np.array([0.5, -2.0], dtype=np.float32),
    "longdouble": np.array([0.5, -2.0], dtype=np.longdouble),
    "int8": np.array([1, -2], dtype=np.int8),
    "uint64": np.array([1, 2**63], dtype=np.uint64),
    "objects": np.array([Fraction(1, 2), 3], dtype=object),
    "masked nowhere": np.ma.masked_array([0.5, -2.0], mask=False),
    "strided": np.linspace(-3, 3, 12)[::3],
    "reversed": np.linspace(-3, 3, 4)[::-1],
    "transposed": np.linspace(-3, 3, 6).reshape(2, 3).T,
    "big endian": np.array([0.5, -2.0], dtype=">f8"),
    "subnormal": np.array([5e-324, -0.0]),
    "list": [0.5, -2],
    "empty": np.empty((0, 3)),
    "number": 0.25,
}


@pytest.mark.parametrize("name", GOOD_POINTS)
def test_every_kind_of_number_is_the_double_that_it_is(name: str) -> None:
    points = GOOD_POINTS[name]
    plain = np.array(points, dtype=float)
    for found, expected in zip(KINK(points, 0.5), KINK(plain, 0.5), strict=True):
        assert np.shape(found) == np.shape(points)
        assert np.array_equal(found, expected)


def test_arguments_are_left_alone() -> None:
    X = np.linspace(-1, 1, 5)
    X.setflags(write=False)
    KINK(X, X)
    assert np.array_equal(X, np.linspace(-1, 1, 5))


@settings(max_examples=30, deadline=None)
@given(
    form=st.sampled_from(CATALOGUE.of("mKdV")),
    X=st.floats(-1e15, 1e15),
    T=st.floats(-1e15, 1e15),
)
def test_finite_in_finite_out(form: Any, X: float, T: float) -> None:
    values = {"k": 0.7, "alpha": 0.5, "A": 2, "p": 1, "q": 2, "A_1": 2, "A_2": 1, "kappa": 1}
    given = {p.name: values[p.name] for p in form.parameters if p.name in values}
    wave = Wave(form, FOCUSING if form.equation.s > 0 else DEFOCUSING, **given)
    assert all(np.isfinite(part) and abs(part) < 1e6 for part in wave(X, T))


@pytest.mark.parametrize("form", CATALOGUE.of("mKdV"), ids=lambda form: form.name)
def test_pairs_have_25_digits(form: Any, draw: Any, normal_forms: Any, ctx: Any) -> None:
    wave = Wave(form, normal_forms[form.equation.s], **draw(form))
    n, t = 37.0, 3.0
    X = Fraction(1, 4) * (int(n) - int(wave.normal_form.c) * int(t))
    exact = wave.mp(X, Fraction(1, 64) * int(t), 40)
    for found, expected in zip(wave.pairs_at(n, t, 0.25), exact, strict=True):
        assert abs(ctx.mpf(float(found[0])) + float(found[1]) - expected) < 1e-25


def test_pairs_agree_in_double(normal_forms: Any, rng: np.random.Generator) -> None:
    wave = Wave(closed_form("breather_sn"), normal_forms[-1], k=0.6, alpha=0.4)
    n = rng.normal(scale=100, size=(3, 700))
    for single, pair in zip(wave.at(n, 2.0, 0.1), wave.pairs_at(n, 2.0, 0.1), strict=True):
        assert pair.shape == (2, 3, 700)
        assert np.allclose(single, pair[0], rtol=0, atol=1e-14)


@pytest.mark.parametrize("form", CATALOGUE.of("mKdV"), ids=lambda form: form.name)
def test_no_points_give_no_values(form: ClosedForm, draw: Any, normal_forms: Any) -> None:
    wave = Wave(form, normal_forms[form.equation.s], **draw(form))
    nothing = np.zeros((2, 0))
    for found in (wave(nothing, 0.0), wave.at(nothing, 1e6, 0.1)):
        assert [part.shape for part in found] == [(2, 0)] * 3
