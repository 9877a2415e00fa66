"""The ring and its fractions: normal forms, denominators, and what is counted before it is done."""

import pytest
from flint import fmpq, fmpq_mpoly

from longwave.verify.kernel import CertificateError, ring
from longwave.verify.kernel.ring import Element, Ring, common, total


def spent(made: Ring) -> int:
    return made._work


@pytest.fixture
def three() -> tuple[Ring, fmpq_mpoly, fmpq_mpoly, fmpq_mpoly]:
    made = Ring(3)
    return (made, *made.generators)


Three = tuple[Ring, fmpq_mpoly, fmpq_mpoly, fmpq_mpoly]


def test_generators_are_ordered_the_last_one_highest(three: Three) -> None:
    made, x, y, z = three
    assert made.names == ("g0", "g1", "g2")
    assert [str(g) for g in (x, y, z)] == ["g0", "g1", "g2"]
    assert (x**9 + y).leading_coefficient() == 1
    assert Element(made, x**9 + 2 * y).numerator.leading_coefficient() == 2
    assert Element(made, x * z, {}).places == {0, 2}
    unit, powers = made.split(y + 1)
    assert Element(made, x, powers).places == {0, 1}
    assert unit == 1


def test_a_relation_has_earlier_generators_and_lower_powers(three: Three) -> None:
    made, x, y, z = three
    for value in (z, y**2, x * z):
        with pytest.raises(CertificateError, match="the relation of generator 1 needs a later one"):
            made.relate(1, 2, value)
    made.relate(1, 2, x * y + 1)
    made.relate(2, 3, y)
    assert made.reduced(y**2) == x * y + 1
    assert made.reduced(z**6) == x * y + 1
    assert made.reduced(z**2) == z**2
    assert [index for index, _, _ in made.relations] == [0, 1]


def test_the_work_of_products_and_divisions_is_counted(three: Three) -> None:
    made, x, y, z = three
    assert made.product(x + y, x + y + z) == (x + y) * (x + y + z)
    assert spent(made) == 6
    made.relate(2, 2, x + y)
    before = spent(made)
    assert made.reduced(z**5 + z + 1) == z * (x + y) ** 2 + z + 1
    assert spent(made) - before == 3 * 3 * 2
    made.reduced(z + x**9)
    assert spent(made) - before == 18


def test_work_beyond_the_budget_is_refused(three: Three, monkeypatch: pytest.MonkeyPatch) -> None:
    made, x, y, z = three
    monkeypatch.setattr(ring, "WORK", 12)
    made.product(x + y, x + y + z)
    made.product(x + y, x + y + z)
    with pytest.raises(CertificateError, match="the work of polynomial products must be at most"):
        made.product(x, y)


def test_degrees_beyond_the_limit_are_refused(
    three: Three, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, x, y, _ = three
    monkeypatch.setattr(ring, "DEGREE", 6)
    assert made.product(x**2 * y, y**3 + 1) == x**2 * y**4 + x**2 * y
    with pytest.raises(CertificateError, match="degrees must be at most 6, got 7"):
        made.product(x**2 * y, y**4 + 1)
    pair = Element(made, 2 * x * y)
    assert (pair**3).numerator == 8 * x**3 * y**3
    with pytest.raises(CertificateError, match="degrees must be at most 6, got 8"):
        pair**4


def test_a_power_is_counted_before_it_is_taken(
    three: Three, monkeypatch: pytest.MonkeyPatch
) -> None:
    made, x, y, _ = three
    monkeypatch.setattr(ring, "HEIGHT", 42)
    tall = Element(made, 10_000 * x + y)  # 14 bits, 2 * (14 + 2) in all
    assert (tall**3).numerator == (10_000 * x + y) ** 3
    assert spent(made) == 2 + 4 + 6 + (2 * 32 * 1) // 64 + (3 * 32 * 2) // 64
    for exponent in (4, -4):
        with pytest.raises(CertificateError, match="the bits of a coefficient must be at most 42"):
            tall.inverse() ** exponent if exponent < 0 else tall**exponent
    assert (Element(made, made.context.constant(0)) ** 3).is_zero
    assert (tall**0).numerator == 1


def test_a_power_with_relations_is_reduced(three: Three) -> None:
    made, x, y, _ = three
    made.relate(1, 2, x)
    assert (Element(made, y) ** 4).numerator == x**2
    assert (Element(made, y) ** -2 * Element(made, x)).numerator == 1
    assert (Element(made, y + 1) ** 2).numerator == x + 2 * y + 1


def test_a_polynomial_is_a_number_times_powers_of_factors(three: Three) -> None:
    made, x, y, _ = three
    polynomial = 6 * (x + 1) ** 2 * (x - y)
    unit, powers = made.split(polynomial)
    assert unit * made.multiplied_out(powers) == polynomial
    assert sorted(powers.values()) == [1, 2]
    assert made.split(x + 1)[1].keys() <= powers.keys()
    assert len(made.factors) == 2


@pytest.mark.parametrize(("limit", "edge"), [("FACTOR_TERMS", 4), ("FACTOR_DEGREE", 2)])
def test_what_is_long_is_not_split(
    three: Three, monkeypatch: pytest.MonkeyPatch, limit: str, edge: int
) -> None:
    polynomial = 3 * (three[1] + 1) * (three[2] + 2)
    for bound, count in ((edge, 2), (edge - 1, 1)):
        made = Ring(3)
        monkeypatch.setattr(ring, limit, bound)
        unit, powers = made.split(polynomial)
        assert len(powers) == len(made.factors) == count
        assert unit * made.multiplied_out(powers) == polynomial
        inverse = Element(made, polynomial).inverse()
        assert (inverse * Element(made, polynomial)).numerator == 1


@pytest.mark.parametrize("degree", [2, 3, 5])
@pytest.mark.parametrize("power", [1, 2, 4])
def test_a_root_below_is_rationalized(degree: int, power: int) -> None:
    made = Ring(2)
    x, root = made.generators
    made.relate(1, degree, x + 2)
    inverse = Element(made, root**power * (x + 5)).inverse()
    assert all(made.factors[place] != root for place in inverse.powers)
    whole = inverse * Element(made, made.reduced(root**power * (x + 5)))
    assert whole.numerator == 1
    assert not whole.powers
    assert made.roots() == [(made.factors.index(root), degree, x + 2)]


def test_zero_has_no_inverse_and_only_what_is_used_is_a_root() -> None:
    made = Ring(2)
    x, root = made.generators
    made.relate(1, 2, x)
    assert made.roots() == []
    with pytest.raises(CertificateError, match="a denominator vanishes identically"):
        (Element(made, root) * Element(made, root) - Element(made, x)).inverse()


def test_sums_are_over_the_least_common_denominator(three: Three) -> None:
    made, x, y, _ = three
    _, first = made.split(x)
    _, second = made.split(y)
    (a,), (b,) = first, second
    one = made.context.constant(1)
    parts = [Element(made, one, {a: 1, b: 2}), Element(made, one, {a: 3}), Element(made, one)]
    assert common(parts) == {a: 3, b: 2}
    whole = total(made, parts)
    assert whole.powers == {a: 3, b: 2}
    assert whole.numerator == x**2 + y**2 + x**3 * y**2
    assert parts[0].denominator() == x * y**2
    assert parts[0].over({a: 2, b: 2}) == x
    product = parts[0] * Element(made, x**2 * y, {b: 1})
    assert (product.numerator, product.powers) == (x, {b: 2})
    assert ((parts[1] - parts[1]).powers, (parts[1] - parts[1]).is_zero) == ({}, True)
    assert (-parts[1] + parts[1]).is_zero
    assert (made.number(fmpq(3)) / made.number(2)).numerator == fmpq(3, 2)
    quotient = made.quotient(x * y, x)
    assert quotient == y
    assert made.quotient(x * y + 1, x) is None
