"""Intervals by brute force: what an operation gives is what it does to numbers in its operands."""

from collections.abc import Iterator, Sequence
from itertools import product

import pytest
from flint import arb, fmpq

from longwave.verify.kernel.bounds import LARGEST, MICRO, Interval, of_constant

ENDS = [fmpq(-2), fmpq(-1), fmpq(0), fmpq(1), fmpq(2)]
FAR, NEAR = fmpq(1000), fmpq(1, 1000)
"""What stands for a number beyond all bounds, and for one that is as near as one likes."""

WHOLE = Interval()


def intervals() -> Iterator[Interval]:
    """Those with these ends, open, closed or none, none of them empty."""
    for low, high in product([None, *ENDS], repeat=2):
        for low_open, high_open in product((False, True), repeat=2):
            missing = (low is None and low_open) or (high is None and high_open)
            both = low is not None and high is not None
            empty = both and (low > high or (low == high and (low_open or high_open)))
            if not missing and not empty:
                yield Interval(low, high, low_open, high_open)


GRID = list(intervals())


def contains(interval: Interval, number: fmpq) -> bool:
    (low, low_open), (high, high_open) = interval.ends
    above = low is None or low < number or (low == number and not low_open)
    return above and (high is None or number < high or (number == high and not high_open))


def numbers_in(interval: Interval) -> list[fmpq]:
    """Numbers at the ends or close to them, far out where there is none, and at integers."""
    tried = [*ENDS, *(end + step for end in ENDS for step in (NEAR, -NEAR)), FAR, -FAR]
    return [number for number in tried if contains(interval, number)]


NUMBERS = {interval: numbers_in(interval) for interval in GRID}


def is_low(end: fmpq | None, is_open: bool, least: fmpq) -> bool:
    """Whether an end is that of a set whose least number, or one close to its end, is ``least``."""
    if end is None:
        return least < -FAR / 10
    return end < least < end + 1 / fmpq(10) if is_open else end == least


def is_range(interval: Interval, numbers: Sequence[fmpq]) -> bool:
    """Whether an interval is the smallest around what the numbers stand for, open ends too."""
    low, high = interval.ends
    up = None if high[0] is None else -high[0]
    return is_low(*low, min(numbers)) and is_low(up, high[1], -max(numbers))


def test_what_is_said_of_an_interval_is_said_of_its_numbers() -> None:
    for interval, numbers in NUMBERS.items():
        assert is_range(interval, numbers)
        assert interval.is_positive is all(number > 0 for number in numbers)
        assert interval.is_not_negative is all(number >= 0 for number in numbers)
        above, below = (all(sign * number > 0 for number in numbers) for sign in (1, -1))
        assert interval.is_not_zero is (above or below)
        at_most = all(number <= 0 for number in numbers)
        assert interval.is_below is (at_most and any(number < 0 for number in numbers))


@pytest.mark.parametrize("sign", [1, -1])
def test_sums_and_differences_are_those_of_numbers(sign: int) -> None:
    for left, right in product(GRID, repeat=2):
        found = left + (right if sign == 1 else -right)
        assert is_range(found, [a + sign * b for a in NUMBERS[left] for b in NUMBERS[right]])


def test_products_are_those_of_numbers() -> None:
    for left, right in product(GRID, repeat=2):
        found = left * right
        if found != WHOLE:
            assert is_range(found, [a * b for a in NUMBERS[left] for b in NUMBERS[right]])
        else:  # an unbounded factor that has a number of the other sign as well, or the other has
            assert any(None in (one.low, one.high) for one in (left, right))
            assert not (left.side() != WHOLE and right.side() != WHOLE)
            assert not any(one == Interval(fmpq(0), fmpq(0)) for one in (left, right))


def test_what_is_in_both_is_in_what_they_have_in_common() -> None:
    tried = sorted({number for numbers in NUMBERS.values() for number in numbers})
    for left, right in product(GRID, repeat=2):
        found = left & right
        for number in tried:
            assert contains(found, number) is (contains(left, number) and contains(right, number))


def test_absolute_values_and_sides() -> None:
    for interval, numbers in NUMBERS.items():
        found = interval.absolute()
        if found != Interval(fmpq(0)):
            assert is_range(found, [abs(number) for number in numbers])
        else:
            assert None in (interval.low, interval.high)
            assert not interval.is_positive
        zero = fmpq(0)
        expected = (
            Interval(zero, None, True)
            if interval.is_positive
            else Interval(None, zero, False, True)
            if (-interval).is_positive
            else Interval(zero)
            if interval.is_not_negative
            else Interval(None, zero)
            if interval.is_below
            else WHOLE
        )
        assert interval.side() == expected


@pytest.mark.parametrize("exponent", [-3, -2, -1, 0, 1, 2, 3, 4])
def test_powers_are_those_of_numbers(exponent: int) -> None:
    for interval, numbers in NUMBERS.items():
        found = interval.power(exponent)
        powers = [n**exponent for n in numbers if exponent >= 0 or n != 0]
        if interval.is_not_zero or (exponent >= 0 and found not in (WHOLE, Interval(fmpq(0)))):
            assert is_range(found, powers)
        elif exponent < 0:
            assert found == interval.power(-exponent).side()
            assert all(contains(found, power) for power in powers)
        elif found == WHOLE:
            assert interval.side() == WHOLE
            assert exponent % 2
        else:
            assert None in (interval.low, interval.high)
            assert all(contains(found, power) for power in powers)


def test_a_high_power_has_a_side_alone() -> None:
    assert Interval(fmpq(1), fmpq(2)).power(LARGEST) == Interval(fmpq(1), fmpq(2) ** 20)
    for exponent in (LARGEST + 1, LARGEST + 2):
        assert Interval(fmpq(1), fmpq(2)).power(exponent) == Interval(fmpq(0), None, True)
        assert Interval(fmpq(0), fmpq(2)).power(exponent) == Interval(fmpq(0))
        assert Interval(fmpq(1), fmpq(2)).power(-exponent).is_positive
    assert Interval(fmpq(-2), fmpq(-1)).power(21) == Interval(None, fmpq(0), False, True)
    assert Interval(fmpq(-2), fmpq(1)).power(22) == Interval(fmpq(0))
    assert Interval(fmpq(-2), fmpq(1)).power(21) == WHOLE


@pytest.mark.parametrize("far", [fmpq(2), fmpq(19), fmpq(20), fmpq(21), fmpq(10**6), fmpq(10**30)])
def test_exponentials_are_those_of_numbers(far: fmpq) -> None:
    for low, high in ((None, far), (far, None), (-far, far), (None, -far), (-far, None)):
        for opens in product((False, True), repeat=2):
            inner = Interval(low, high, opens[0] and low is not None, opens[1] and high is not None)
            found = inner.exponential()
            assert found.is_positive
            for end, bound, sign in ((low, found.low, 1), (high, found.high, -1)):
                if end is None or (end > 20 and sign == -1):
                    assert bound is None or bound == 0
                    continue
                value = arb(min(end, fmpq(20))).exp()
                assert bound is not None
                assert not sign * (value - arb(bound)) < 0
                assert abs(value - arb(bound)) < arb(2) / MICRO
    assert Interval(fmpq(0), fmpq(0)).exponential() == Interval(fmpq(1), fmpq(1))
    assert Interval(fmpq(0), None, True).exponential() == Interval(fmpq(1), None, True)
    assert WHOLE.exponential() == Interval(fmpq(0), None, True)


def test_a_root_is_on_the_side_of_1() -> None:
    for interval in GRID:
        if not interval.is_not_negative:
            continue
        below, above = interval.high is not None and interval.high <= 1, interval.low >= 1
        expected = fmpq(1 if above else 0), fmpq(1) if below else None
        opens = interval.is_positive and not above
        assert interval.root() == Interval(*expected, opens)
    half = Interval(fmpq(1, 2), fmpq(3, 2))
    assert half.root() == Interval(fmpq(0), None, True)
    assert Interval(fmpq(3, 2), fmpq(7, 4)).root() == Interval(fmpq(1))


@pytest.mark.parametrize(
    ("value", "low", "high", "low_open", "high_open"),
    [
        (arb.pi(), 3141592, 3141593, False, False),
        (-arb.pi(), -3141593, -3141592, False, False),
        (arb(1) / 2, 500000, 500000, False, False),
        (arb("1e-9"), 0, 1, True, False),
        (arb("-1e-9"), -1, 0, False, True),
        (arb(0), 0, 0, False, False),
        (arb(0, 1), -1000001, 1000001, False, False),
        (arb(1, 1), 0, 2000001, False, False),
    ],
)
def test_bounds_of_a_constant_are_multiples_of_a_millionth(
    value: arb, low: int, high: int, low_open: bool, high_open: bool
) -> None:
    assert MICRO == 1_000_000
    found = of_constant(value)
    assert found.low_open is low_open
    assert found.high_open is high_open
    gaps = abs(found.low * MICRO - low), abs(found.high * MICRO - high)
    assert max(gaps) <= (1 if value.rad() > 0.5 else 0)
    assert arb(found.low) <= value.lower()
    assert value.upper() <= arb(found.high)
    assert of_constant(arb("nan")) == WHOLE
