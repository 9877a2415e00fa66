"""Residuals of statements in text, as balls: Taylor series of trees at rational points.

A ball that excludes 0 shows that an equation fails there.  What cannot be said with certainty (a
value on a branch cut, a pole, a point where a modulus has no slope) raises CannotJudge.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from fractions import Fraction
from math import factorial

from flint import acb, acb_series, arb, ctx, fmpq

from searches.texts import special_series
from searches.texts.taylor_sum import TaylorSum
from searches.texts.text_statement import TextPoint, TextStatement
from searches.texts.trees import DERIVED, Tree, read

BITS = (100, 400, 1600, 6400)
"""Further out than the first two are changes by 10**-40 and tails such as 1 - tanh(1000)."""

AtBall = Callable[[acb, int], list[acb]]


class CannotJudge(ArithmeticError):
    """There is no certain value."""


@contextmanager
def precision(bits: int) -> Iterator[None]:
    """Work with so many bits inside."""
    before, ctx.prec = ctx.prec, bits
    try:
        yield
    finally:
        ctx.prec = before


# functions of one variable: their coefficients at a ball


def _series(z: acb, order: int) -> acb_series:
    return acb_series([z, 1], order + 1)


def _listed(series: acb_series, order: int) -> list[acb]:
    found = list(series.coeffs())
    return found + [acb(0)] * (order + 1 - len(found))


def _integrated(value: acb, slope: acb_series, order: int) -> list[acb]:
    return [value, *(c / (i + 1) for i, c in enumerate(_listed(slope, order)[:order]))]


def _exponentials(combined: Callable[[acb_series, acb_series], acb_series]) -> AtBall:
    """A quotient of exp(z) and exp(-z)."""

    def found(z: acb, order: int) -> list[acb]:
        w = _series(z, order)
        return _listed(combined(w.exp(), (-w).exp()), order)

    return found


def _plain(name: str) -> AtBall:
    return lambda z, order: _listed(getattr(_series(z, order), name)(), order)


def _ratio(above: str, below: str) -> AtBall:
    def found(z: acb, order: int) -> list[acb]:
        w = _series(z, order)
        top = getattr(w, above)() if above else acb_series([1], order + 1)
        return _listed(top / getattr(w, below)(), order)

    return found


def _inverse(name: str, slope: Callable[[acb_series], acb_series]) -> AtBall:
    return lambda z, order: _integrated(getattr(z, name)(), slope(_series(z, order)), order)


TAYLOR: Mapping[str, AtBall] = {
    **{name: _plain(name) for name in ("exp", "log", "sqrt", "sin", "cos", "tan", "atan")},
    **{f"airy_{name}": _plain(f"airy_{name}") for name in ("ai", "ai_prime", "bi", "bi_prime")},
    "erf": _plain("erf"),
    "lambert_w": _plain("lambertw"),
    "cot": _ratio("cos", "sin"),
    "sec": _ratio("", "cos"),
    "csc": _ratio("", "sin"),
    "sinh": _exponentials(lambda e, f: (e - f) / 2),
    "cosh": _exponentials(lambda e, f: (e + f) / 2),
    "tanh": _exponentials(lambda e, f: (e - f) / (e + f)),
    "coth": _exponentials(lambda e, f: (e + f) / (e - f)),
    "sech": _exponentials(lambda e, f: 2 / (e + f)),
    "csch": _exponentials(lambda e, f: 2 / (e - f)),
    "asin": _inverse("asin", lambda w: (1 - w * w).rsqrt()),
    "acos": _inverse("acos", lambda w: -(1 - w * w).rsqrt()),
    "asinh": _inverse("asinh", lambda w: (1 + w * w).rsqrt()),
    "acosh": _inverse("acosh", lambda w: (w - 1).rsqrt() * (w + 1).rsqrt()),
    "atanh": _inverse("atanh", lambda w: 1 / (1 - w * w)),
}


def _theta(place: int, z: TaylorSum, q: TaylorSum) -> TaylorSum:
    """A theta function; by w = log q its slope is -1/4 of the second one by z."""
    if not q.value.real > 0:
        raise CannotJudge(f"a theta function of the nome {q.value}")
    w = _applied("log", [q])
    slopes = special_series.theta(place, z.value, w.value, 3 * z.order)
    start = (0,) * len(next(iter(w.terms)))
    step = w + TaylorSum(w.order, {start: -w.value})
    found = TaylorSum(z.order, {start: acb(0)})
    for n in range(z.order, -1, -1):
        series = [c / factorial(i) for i, c in enumerate(slopes[2 * n :][: z.order + 1])]
        found = found * step + z.of(series).times(acb(-1) ** n / (4**n * factorial(n)))
    return found


CUTS: Mapping[str, Callable[[acb], bool]] = {
    "atan": lambda z: z.imag == 0 or not z.real.contains(0) or abs(z.imag) < 1,
    "asinh": lambda z: z.imag == 0 or not z.real.contains(0) or abs(z.imag) < 1,
    "asin": lambda z: not z.imag.contains(0) or abs(z.real) < 1,
    "acos": lambda z: not z.imag.contains(0) or abs(z.real) < 1,
    "atanh": lambda z: not z.imag.contains(0) or abs(z.real) < 1,
    "acosh": lambda z: not z.imag.contains(0) or z.real > 1,
    "lambert_w": lambda z: not z.imag.contains(0) or z.real > fmpq(-36, 100),
}
"""Where a function is known to be off its cuts."""


def _off_negative_axis(z: TaylorSum) -> bool:
    """Off the cut of log and of roots; a real function may lie on it."""
    return not z.value.imag.contains(0) or z.value.real > 0 or (z.is_real and z.value.real < 0)


class Judge:
    """Reads a statement once; finds the residuals of its equations at points."""

    def __init__(self, statement: TextStatement) -> None:
        self.statement = statement
        pairs = [text.split("=", 1) for text in statement.solutions]
        self.solutions = {left.strip().partition("[")[0]: read(right) for left, right in pairs}
        unknowns = tuple(self.solutions)
        self.equations = [_one_side(text, unknowns) for text in statement.equations]
        self.definitions = {name: read(text) for name, text in statement.definitions}
        self.letters = [v.name for v in statement.letters if v.name in DERIVED]
        inner = (*self.solutions.values(), *self.definitions.values())
        self.order = max(map(_order, self.equations)) + max(map(_order, inner), default=0)

    def residuals(self, point: TextPoint, bits: int) -> Iterator[acb]:
        """The residual of each equation; raises CannotJudge."""
        with precision(bits):
            for equation in self.equations:
                place = _Place(self, point)
                found = place.value(equation, self.order).value
                if not found.is_finite():
                    raise CannotJudge(f"no finite value of {equation}")
                yield found

    def fails_at(self, point: TextPoint, bits: Sequence[int] = BITS) -> bool:
        """Whether an equation has a residual other than 0.

        False says that at the highest precision all residuals are in small balls around 0.  Raises
        CannotJudge where there is no value, or none in a small ball.
        """
        reason = CannotJudge("no precision was tried")
        for size in bits:
            try:
                found = list(self.residuals(point, size))
            except CannotJudge as error:
                reason = error
                continue
            except (ZeroDivisionError, ValueError, OverflowError) as error:
                reason = CannotJudge(str(error))
                continue
            if any(not residual.contains(0) for residual in found):
                return True
            with precision(size):
                small = arb(2) ** (-size // 4)
                wide = [residual for residual in found if not residual.abs_upper() < small]
            reason = CannotJudge(f"a residual is only known to be in {wide[0]}" if wide else "")
        if str(reason):
            raise reason
        return False


def _one_side(text: str, unknowns: tuple[str, ...]) -> Tree:
    left, _, right = text.partition("=")
    return read(left, unknowns) - (read(right, unknowns) if right else 0)


def _order(tree: Tree) -> int:
    below = max(map(_order, tree.args), default=0)
    if tree.head == "diff":
        return below + len(str(tree.value))
    return len(tree.jet[1]) if tree.head == "jet" else below


class _Place:
    """Trees at one point, the site perhaps shifted."""

    def __init__(self, judge: Judge, point: TextPoint) -> None:
        self.judge = judge
        self.point = point
        self.start = (0,) * len(judge.letters)
        self.known: dict[str, TaylorSum] = {}

    def value(self, tree: Tree, order: int) -> TaylorSum:
        head = tree.head
        if head == "number":
            return self._constant(_exact(tree.number), order)
        if head == "name":
            return self._named(str(tree.value), order)
        if head == "jet":
            return self._jet(*tree.jet, order)
        if head == "diff":
            return self._derived(tree.args[0], str(tree.value), order)
        if head == "**":
            return self._power(tree.args[0], tree.args[1], order)
        parts = [self.value(argument, order) for argument in tree.args]
        if head == "+":
            found = parts[0]
            for part in parts[1:]:
                found += part
            return found
        return parts[0] * parts[1] if head == "*" else _applied(head, parts)

    def _constant(self, number: acb, order: int) -> TaylorSum:
        return TaylorSum(order, {self.start: number})

    def _named(self, letter: str, order: int) -> TaylorSum:
        if letter == "pi":
            return self._constant(acb.pi(), order)
        if letter == "I":
            return self._constant(acb(0, 1), order)
        if letter in self.judge.definitions:
            return self.value(self.judge.definitions[letter], order)
        found = self._constant(_exact(self.point[letter]), order)
        if letter in self.judge.letters and order:
            step = tuple(int(own == letter) for own in self.judge.letters)
            found = TaylorSum(order, {**found.terms, step: acb(1)})
        return found

    def _jet(self, unknown: str, steps: str, shift: int | None, order: int) -> TaylorSum:
        key = f"{unknown} {shift} {order}"
        if key not in self.known:
            moved = dict(self.point)
            if shift:
                moved["n"] += shift
            place = _Place(self.judge, moved)
            self.known[key] = place.value(self.judge.solutions[unknown], order)
        return self._slopes(self.known[key], steps)

    def _derived(self, tree: Tree, steps: str, order: int) -> TaylorSum:
        return self._slopes(self.value(tree, order), steps)

    def _slopes(self, found: TaylorSum, steps: str) -> TaylorSum:
        for letter in steps:
            found = found.slope(self.judge.letters.index(letter))
        return found

    def _power(self, base: Tree, exponent: Tree, order: int) -> TaylorSum:
        below, above = self.value(base, order), self.value(exponent, order)
        whole = _integer(exponent, self.point)
        if whole is not None:
            return _whole_power(below, whole)
        if not _off_negative_axis(below):
            raise CannotJudge(f"a power of {below.value}, perhaps on the cut")
        return _applied("exp", [above * _applied("log", [below])])


def _integer(exponent: Tree, point: TextPoint) -> int | None:
    """The exponent if it is an integer: a number, the site or a letter of integers, their sums."""
    if exponent.head == "number" and exponent.number.denominator == 1:
        return int(exponent.number)
    if exponent.head == "name" and exponent.value == "n":
        return int(point["n"])
    if exponent.head in ("+", "*"):
        parts = [_integer(argument, point) for argument in exponent.args]
        if all(part is not None for part in parts):
            whole = [int(part or 0) for part in parts]
            return sum(whole) if exponent.head == "+" else whole[0] * whole[1]
    return None


def _whole_power(base: TaylorSum, exponent: int) -> TaylorSum:
    if exponent < 0:
        if base.value.contains(0):
            raise CannotJudge("a division by what may be 0")
        inverse = acb_series([base.value, 1], base.order + 1).inv()
        return _whole_power(base.of(_listed(inverse, base.order)), -exponent)
    found = TaylorSum(base.order, {(0,) * len(next(iter(base.terms))): acb(1)})
    while exponent:
        if exponent & 1:
            found = found * base
        exponent >>= 1
        if exponent:
            base = base * base
    return found


def _exact(number: Fraction) -> acb:
    return acb(arb(fmpq(number.numerator, number.denominator)))


def _applied(name: str, parts: Sequence[TaylorSum]) -> TaylorSum:
    z = parts[0]
    if name in ("conjugate", "re", "im", "abs", "sign"):
        return _by_conjugate(name, z)
    if name.startswith("jacobi_theta_"):
        return _theta(int(name[-1]) - 1, *parts)
    if name.startswith("bessel_"):
        order, at = _constant_of(z), parts[1]
        if not special_series.is_off_cut(name, order, at.value):
            raise CannotJudge(f"{name} of {at.value}, perhaps on the cut")
        return at.of(special_series.bessel(name, order, at.value, at.order))
    if name.startswith("weierstrass_"):
        g, h = map(_constant_of, parts[1:])
        return z.of(special_series.weierstrass(name, z.value, g, h, z.order))
    if name.startswith("jacobi_"):
        return _elliptic(name, *parts)
    if name in ("elliptic_k", "elliptic_e"):
        _check_parameter(z)
        return TaylorSum(z.order, {i: getattr(c, name)() for i, c in z.terms.items() if not any(i)})
    if name in ("log", "sqrt") and not _off_negative_axis(z):
        raise CannotJudge(f"{name} of {z.value}, perhaps on the cut")
    if name in CUTS and not CUTS[name](z.value):
        raise CannotJudge(f"{name} of {z.value}, perhaps on the cut")
    return z.of(TAYLOR[name](z.value, z.order))


def _constant_of(parameter: TaylorSum) -> acb:
    if not parameter.is_constant:
        raise CannotJudge("a parameter that has a slope")
    return parameter.value


def _by_conjugate(name: str, z: TaylorSum) -> TaylorSum:
    other = z.conjugate()
    if name == "conjugate":
        return other
    if name == "re":
        return (z + other).times(acb(fmpq(1, 2)))
    if name == "im":
        return (z + other.times(acb(-1))).times(acb(0, fmpq(-1, 2)))
    if z.value.contains(0):
        raise CannotJudge(f"{name} of what may be 0")
    if z.is_real:
        sign = acb(1 if z.value.real > 0 else -1)
        return z.times(sign) if name == "abs" else z.of([sign] + [acb(0)] * z.order)
    square = z * other
    size = _applied("sqrt", [TaylorSum(z.order, {i: acb(c.real) for i, c in square.terms.items()})])
    return size if name == "abs" else z * _whole_power(size, -1)


def _check_parameter(m: TaylorSum) -> None:
    if not m.is_constant or m.value.imag != 0 or not m.value.real < 1:
        raise CannotJudge(f"an elliptic function of the parameter {m.value}")


def _elliptic(name: str, z: TaylorSum, m: TaylorSum) -> TaylorSum:
    """By theta functions at the value, and by the differential equations behind it."""
    _check_parameter(m)
    k = m.value
    if not k.real > 0:
        raise CannotJudge(f"an elliptic function of the parameter {k}")
    quarter, other = k.elliptic_k(), (1 - k).elliptic_k()
    tau, place = acb(0, 1) * other / quarter, z.value / (2 * quarter)
    one, two, three, four = acb.modular_theta(place, tau)
    _, two0, three0, four0 = acb.modular_theta(acb(0), tau)
    s = [three0 / two0 * one / four]
    c = [four0 / two0 * two / four]
    d = [four0 / three0 * three / four]
    for n in range(z.order):
        s.append(_convolved(c, d, n) / (n + 1))
        c.append(-_convolved(s, d, n) / (n + 1))
        d.append(-k * _convolved(s, c, n) / (n + 1))
    listed = {"jacobi_sn": s, "jacobi_cn": c, "jacobi_dn": d}
    if name in listed:
        return z.of(listed[name])
    if name not in ("jacobi_zeta", "jacobi_epsilon"):
        raise CannotJudge(f"{name} has no value here")
    mean = k.elliptic_e() / quarter
    slope = [_convolved(d, d, n) for n in range(z.order + 1)]
    value = acb.modular_theta(place, tau, 1)[3] / four / (2 * quarter)
    if name == "jacobi_zeta":
        slope[0] -= mean
    else:
        value += mean * z.value
    return z.of([value, *(slope[n] / (n + 1) for n in range(z.order))])


def _convolved(left: Sequence[acb], right: Sequence[acb], place: int) -> acb:
    return sum((left[i] * right[place - i] for i in range(place + 1)), acb(0))
