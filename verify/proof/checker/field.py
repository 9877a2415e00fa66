"""The images of a certificate's formulas in its generators, with their slopes and relations.

A generator is given by its meaning alone.  Relations and slopes follow from the axioms; sums,
products and integer powers are computed; a function must be a generator, or follow from generators
by an axiom whose premises are checked here, by exact arithmetic on images.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from flint import acb, fmpq, fmpq_mpoly

from . import axioms
from .axioms import Station
from .limits import EXPONENT, CertificateError, within
from .nodes import ELLIPTIC, Nodes, children
from .points import Balls, value_at
from .ring import Element, Ring
from .signs import ANY, BELOW_ONE, NOT_NEGATIVE, POSITIVE, Sign, Signs

Sum = tuple[tuple[fmpq, int], ...]
"""Coefficients and nodes."""

HALF_PI = fmpq(15707963, 10**7)
"""A little less than pi/2."""

UNBOUNDED = ("coth", "csch", "tan", "cot", "sec", "csc", "log", "sign")
"""Functions with poles or jumps at real arguments."""

FREE = ("symbol", "pi", "elliptic_k", "elliptic_e", "exp", "log", "atan")
FREE_JACOBI = ("jacobi_epsilon", "jacobi_zeta", "jacobi_theta")
AXIOMS = ("symbol", "exp", "log", "atan", *(f"jacobi_{name}" for name in ELLIPTIC if name != "eta"))
CLEAN = ("number", "symbol", "I", "pi", "Add", "Mul", "poly", "exp", "elliptic_k", "elliptic_e")


@dataclass(frozen=True)
class Hints:
    """Which axiom instances to use: nothing of this is believed, all of it is checked.

    ``sums[f(z)]`` writes the argument of exp, sn or theta as a combination of others,
    ``values[f]`` names what a root or an absolute value is, ``logs[log f]`` the factors of f,
    ``signs[f]`` a formula with the same image whose structure shows its sign.
    """

    sums: Mapping[int, Sum]
    values: Mapping[int, int]
    logs: Mapping[int, Sum]
    signs: Mapping[int, int]


@dataclass(frozen=True)
class Generator:
    """What a generator stands for: ``scale * node / below``, or a sum of products and a shift."""

    node: int
    scale: fmpq_mpoly | None = None
    below: int | None = None
    form: tuple[tuple[int, int], ...] = ()
    shift: int = 0

    @property
    def nodes(self) -> list[int]:
        """The nodes whose values make the generator's."""
        if self.form:
            return [self.shift, *(node for pair in self.form for node in pair)]
        return [self.node] if self.below is None else [self.node, self.below]


@dataclass(frozen=True)
class Form:
    """``factors`` of primitives, and what is added."""

    factors: tuple[int, ...]
    shift: int


class Field:
    """Generators, images of nodes, and derivatives.

    ``positive`` are the nodes that the domain states to be positive (True: or 0).
    """

    def __init__(
        self,
        nodes: Nodes,
        count: int,
        variables: Sequence[int],
        positive: Mapping[int, bool],
        hints: Hints,
    ) -> None:
        self.nodes, self.ring, self.hints = nodes, Ring(count), hints
        self.variables = variables
        self.generators: list[Generator] = []
        self.signs = Signs(nodes, self._stated, self._witness)
        self.one = self.ring.number(1)
        self.zero = self.ring.number(0)
        self._positive = positive
        self._circles: dict[int, int] = {}
        self._images: dict[int, Element] = {}
        self._atoms: dict[str, list[int]] = {}
        self._slopes: dict[tuple[int, int], Element] = {}
        self._rates: dict[tuple[int, int], Element] = {}
        self._stations: dict[tuple[int, int, str], Station] = {}

    # Generators.

    def register(self, node: int) -> None:
        """The next generator stands for ``node``, a function or a symbol.

        It is not used where another one stands for the same function of equal arguments.
        """
        known = self._known(node)
        if known is not None and node not in self._images:
            self.generators.append(Generator(node))
            self._images[node] = known
            return
        match self.nodes.all[node]:
            case ("symbol", *_) if node in self._circles:
                self._algebraic(node, 2, self.one - self.image(self._circles[node]) ** 2)
            case ("I",):
                self._algebraic(node, 2, -self.one)
            case ("Pow", base, exponent) if exponent.p == 1 and exponent.q > 1:
                self._algebraic(node, int(exponent.q), self.image(base))
            case ("Abs", inner):
                self._algebraic(node, 2, self._squared(inner))
            case ("jacobi_sn" | "jacobi_cn" | "jacobi_dn", z, m):
                self._jacobi(node, z, m)
            case (str(name), z, m) if name in FREE_JACOBI:
                self._parameter(name, m)
                self._add(node, self._next, Generator(node))
            case (str(name), *_) if name in FREE:
                if name in ("elliptic_k", "elliptic_e"):
                    self._parameter(name, self.nodes.all[node][1])
                self._add(node, self._next, Generator(node))
            case (name, *_):
                raise CertificateError(f"{name} is no generator")

    def register_scaled(self, node: int, scale: int) -> None:
        """The next generator stands for ``scale`` times a Jacobi function."""
        match self.nodes.all[node]:
            case ("jacobi_sn" | "jacobi_cn" | "jacobi_dn", z, m) if self.is_clean(scale):
                self._jacobi(node, z, m, self.image(scale))
            case _:
                raise CertificateError("what is scaled must be a Jacobi function")

    def register_circle(self, root: int, symbol: int) -> None:
        """The next generator stands for sqrt(1 - s**2); s itself is a root of it later."""
        square = self.nodes.made("Pow", symbol, fmpq(2))
        negative = self.nodes.made("Mul", self.nodes.rational(-1), square)
        rest = self.nodes.made("Add", self.nodes.rational(1), negative)
        if self.nodes.all[root] != ("Pow", rest, fmpq(1, 2)):
            raise CertificateError("a circle must be of a symbol s and sqrt(1 - s**2)")
        if self.nodes.all[symbol][0] != "symbol" or symbol in self.variables:
            raise CertificateError("a circle must be of a parameter")
        self._add(root, self._next, Generator(root))
        self._circles[symbol] = root

    def register_quotient(self, node: int, below: int) -> None:
        """The next generator stands for ``node/below``, two theta functions."""
        for theta in (node, below):
            if self.nodes.all[theta][0] != "jacobi_theta":
                raise CertificateError("a quotient must be of theta functions")
            self._parameter("jacobi_theta", self.nodes.all[theta][2])
        self._add(node, self._next * self.image(below), Generator(node, below=below))

    def register_forms(self, primitives: Sequence[int], rows: Sequence[Form]) -> None:
        """The next generators are linear in as many symbols or functions, with constant factors.

        The images of these follow by elimination.
        """
        for node in primitives:
            name = self.nodes.all[node][0]
            if node in self._images or (name not in FREE and name not in FREE_JACOBI):
                raise CertificateError(f"a {name} cannot be in a linear form, or is known")
            if name in FREE_JACOBI or name in BELOW_ONE:
                self._parameter(name, self.nodes.all[node][-1])
        places = range(len(self.generators), len(self.generators) + len(rows))
        table = []
        for place, form in zip(places, rows, strict=True):
            if not all(map(self.is_clean, (*form.factors, form.shift))):
                raise CertificateError("a linear form must be analytic on the domain")
            if any(map(self._moves, form.factors)):
                raise CertificateError("the factors of a linear form must be constant")
            rest = self.ring.generator(place) - self.image(form.shift)
            table.append([*map(self.image, form.factors), rest])
            pairs = tuple(zip(form.factors, primitives, strict=True))
            self.generators.append(Generator(0, form=pairs, shift=form.shift))
        for node, value in zip(primitives, solved(table), strict=True):
            self._images[node] = value
            self._atoms.setdefault(self.nodes.all[node][0], []).append(node)

    def register_part(self, left: int, right: int) -> None:
        """The next generator stands for either of two formulas that were proved equal."""
        self._add(left, self._next, Generator(left))
        self._images[right] = self._images[left]

    @property
    def _next(self) -> Element:
        place = len(self.generators)
        if place >= len(self.ring.names):
            raise CertificateError("there are more generators than announced")
        return self.ring.generator(place)

    def _add(self, node: int, image: Element, generator: Generator) -> None:
        if node in self._images:
            raise CertificateError("a generator must be new")
        self.generators.append(generator)
        self._images[node] = image
        self._atoms.setdefault(self.nodes.all[node][0], []).append(node)

    def _algebraic(
        self, node: int, degree: int, value: Element, scale: Element | None = None
    ) -> None:
        """The generator is D times scale times a root, so that its power is a polynomial."""
        place = len(self.generators)
        scale = scale or self.one
        value = value * scale**degree
        below = value.denominator()
        power = value.numerator
        for _ in range(degree - 1):
            power = self.ring.product(power, below)
        self._add_scaled(node, self.ring.product(below, _whole(scale)))
        self.ring.relate(place, degree, power)

    def _add_scaled(self, node: int, scale: fmpq_mpoly) -> None:
        if scale.is_one():
            self._add(node, self._next, Generator(node))
        else:
            self._add(node, self._next / Element(self.ring, scale), Generator(node, scale=scale))

    def _jacobi(self, node: int, z: int, m: int, scale: Element | None = None) -> None:
        self._parameter(self.nodes.all[node][0], m)
        name = self.nodes.all[node][0].removeprefix("jacobi_")
        for other in ("sn", "cn", "dn"):
            companion = self._images.get(self.nodes.made(f"jacobi_{other}", z, m))
            if companion is not None and other != name:
                square = axioms.SQUARES[name, other](companion, self.image(m), self.one)
                self._algebraic(node, 2, square, scale)
                return
        self._add_scaled(node, _whole(scale or self.one))

    def _parameter(self, name: str, m: int) -> None:
        """Elliptic functions have a constant parameter; K and what is made with it, one below 1."""
        if self._moves(m):
            raise CertificateError("the parameter m of an elliptic function must be constant")
        if name in BELOW_ONE and not self.signs.below_one(m):
            raise CertificateError(f"{name} needs m < 1, which is not shown on the domain")
        if name in ("jacobi_theta", "jacobi_eta") and not self.signs.positive(m):
            raise CertificateError(f"{name} needs m > 0, which is not shown on the domain")

    def _moves(self, node: int) -> bool:
        return any(inner in self.variables for inner in self.nodes.below([node]))

    def is_clean(self, node: int) -> bool:
        """Whether a formula is analytic on the whole domain but for isolated poles."""
        for inner in self.nodes.below([node]):
            name = self.nodes.all[inner][0]
            if name == "Pow":
                base, exponent = self.nodes.all[inner][1:]
                if exponent.q != 1 and not (self.signs.positive(base) and self._is_bounded(base)):
                    return False
            elif name in BELOW_ONE:
                if not self._is_bounded(self.nodes.all[inner][-1]):
                    return False
            elif name not in CLEAN and not name.startswith("jacobi_"):
                return False
        return True

    def _is_bounded(self, node: int) -> bool:
        """Whether a formula, with the witnesses of its sign, has evidently no poles or jumps.

        Then it is positive at every point if it is shown to be; 1/(1 + 1/x**2) is 0 at 0.
        """
        todo, seen = [node], set()
        while todo:
            for inner in self.nodes.below([todo.pop()]):
                if inner in seen:
                    continue
                seen.add(inner)
                name, *arguments = self.nodes.all[inner]
                if name == "Pow" and arguments[1] < 0 and 0 in self.signs.sign(arguments[0]):
                    return False
                complex_jacobi = name.startswith("jacobi_") and not self.signs.is_real(inner)
                if complex_jacobi or name in (*UNBOUNDED, *BELOW_ONE):
                    return False
                if inner in self.hints.signs:
                    todo.append(self.hints.signs[inner])
        return True

    # Images.

    def walk(self, nodes: Sequence[int]) -> None:
        """Make the images of ``nodes`` from the inside out."""
        wanted = set(nodes)
        for node in range(max(nodes, default=-1), -1, -1):
            if node in wanted and node not in self._images:
                wanted.update(children(self.nodes.all[node]))
        for node in sorted(wanted):
            self.image(node)

    def image(self, node: int) -> Element:
        """The image of a node; raises CertificateError where it does not follow from generators."""
        if node not in self._images:
            self._images[node] = self._image(node)
        return self._images[node]

    def equal(self, left: int, right: int) -> bool:
        """Whether two nodes have the same image."""
        return left == right or (self.image(left) - self.image(right)).is_zero

    def _image(self, node: int) -> Element:
        match self.nodes.all[node]:
            case ("number", value):
                return self.ring.number(value)
            case ("Add", *terms):
                return self._sum([self.image(term) for term in terms])
            case ("Mul", *factors):
                return self._product([self.image(factor) for factor in factors])
            case ("poly", terms, *places):
                return self._polynomial(terms, [self.image(place) for place in places])
            case ("Pow", base, exponent):
                return self._power(node, base, int(exponent.p), int(exponent.q))
            case ("symbol", name, _):
                raise CertificateError(f"there is no generator for the symbol {name}")
            case (name, *arguments) if arguments:
                return self._function(node, name, arguments)
            case (name,):
                raise CertificateError(f"there is no generator for {name}")
        raise CertificateError("a node has no image")

    def _sum(self, parts: list[Element]) -> Element:
        """The sum; polynomials are added first."""
        whole = self.zero.numerator
        for part in parts:
            if not part.powers:
                whole += part.numerator
        result = Element(self.ring, whole)
        for part in parts:
            if part.powers:
                result = result + part
        return result

    def _product(self, parts: list[Element]) -> Element:
        total = parts[0]
        for part in parts[1:]:
            total = total * part
        return total

    def _polynomial(
        self, terms: Sequence[tuple[fmpq, tuple[int, ...]]], values: list[Element]
    ) -> Element:
        parts = []
        for coefficient, exponents in terms:
            powers = (v**n for v, n in zip(values, exponents, strict=True) if n)
            parts.append(self._product([self.ring.number(coefficient), *powers]))
        return self._sum(parts)

    def _power(self, node: int, base: int, p: int, q: int) -> Element:
        if q != 1:
            if p != 1:
                return self.image(self.nodes.made("Pow", base, fmpq(1, q))) ** p
            return self._root(node, base, q)
        inner = self.nodes.all[base]
        if inner[0] == "Abs" and p % 2 == 0:
            return self._squared(inner[1]) ** (p // 2)
        return self.image(base) ** p

    def _known(self, node: int) -> Element | None:
        """The image of the same function of equal arguments, if that is a generator."""
        name, *arguments = self.nodes.all[node]
        if not arguments or name == "symbol":
            return None
        for atom in self._atoms.get(name, []):
            others = self.nodes.all[atom][1:]
            if name == "Pow" and arguments[1] != others[1]:
                continue
            inner = zip(children(self.nodes.all[node]), children(self.nodes.all[atom]), strict=True)
            if all(self.equal(a, b) for a, b in inner):
                return self._images[atom]
        return None

    def _root(self, node: int, base: int, q: int) -> Element:
        known = self._known(node)
        if known is not None:
            return known
        value = self._hinted(node, self.hints.values)
        if not (self.image(value) ** q - self.image(base)).is_zero:
            raise CertificateError(f"the power {q} of what a root is said to be is another")
        if not (self.signs.not_negative(value) or (q == 2 and self._is_principal(value))):
            raise CertificateError("what a root is said to be is not shown to be >= 0 there")
        return self.image(value)

    def _is_principal(self, node: int) -> bool:
        """Whether a value w is shown to be the root of w**2: Re w > 0, or w = i s with s >= 0."""
        height, real = self._angle(node), self._real_part(node)
        above = height is not None and self.signs.not_negative(height)
        return above or (real is not None and self.signs.positive(real))

    def _real_part(self, node: int) -> int | None:
        """A node for the real part of a sum of real terms, phases and multiples of them."""
        made = self.nodes.made
        if self.signs.is_real(node):
            return node
        match self.nodes.all[node]:
            case ("I",):
                return self.nodes.rational(0)
            case ("Add", *terms):
                parts = [self._real_part(term) for term in terms]
                known = [part for part in parts if part is not None]
                return made("Add", *known) if len(known) == len(parts) else None
            case ("Mul", *factors):
                rest = [factor for factor in factors if not self.signs.is_real(factor)]
                part = self._real_part(rest[0]) if len(rest) == 1 else None
                real = [factor for factor in factors if factor not in rest]
                return None if part is None else made("Mul", part, *real)
            case ("exp", z):
                angle = self._angle(z)
                return None if angle is None else made("cos", angle)
            case ("Pow", _, exponent) if exponent == fmpq(1, 2):
                return made("Abs", made("re", node))  # the principal root's is not negative
        return None

    def _angle(self, z: int) -> int | None:
        """The real factor of I in a node ``I * angle``."""
        match self.nodes.all[z]:
            case ("Mul", *factors):
                rest = [f for f in factors if self.nodes.all[f] != ("I",)]
                if len(factors) == len(rest) + 1 and rest and all(map(self.signs.is_real, rest)):
                    return rest[0] if len(rest) == 1 else self.nodes.made("Mul", *rest)
        return None

    def _absolute(self, node: int, inner: int) -> Element:
        value = self._hinted(node, self.hints.values)
        if not (self.image(value) ** 2 - self._squared(inner)).is_zero:
            raise CertificateError("what an absolute value is said to be has another square")
        if not self.signs.not_negative(value):
            raise CertificateError(
                "what an absolute value is said to be is not shown to be >= 0 there"
            )
        return self.image(value)

    def _squared(self, inner: int) -> Element:
        """abs(f)**2 = f conj(f)."""
        return self.image(inner) * self.image(self.conjugate(inner))

    def _hinted(self, node: int, hints: Mapping[int, int]) -> int:
        if node not in hints:
            raise CertificateError(f"there is no generator for a {self.nodes.all[node][0]}")
        return hints[node]

    def _function(self, node: int, name: str, arguments: Sequence[int]) -> Element:
        known = self._known(node)
        if known is not None:
            return known
        first = arguments[0]
        if name in axioms.HYPERBOLIC:
            return axioms.HYPERBOLIC[name](self._made("exp", first), self.one)
        if name in axioms.TRIGONOMETRIC:
            i = self.nodes.made("I")
            e = self._made("exp", self.nodes.made("Mul", i, first))
            return axioms.TRIGONOMETRIC[name](e, self.one, self.image(i))
        rules: dict[str, Callable[[], Element]] = {
            "exp": lambda: self._exponential(first),
            "log": lambda: self._logarithm(node, first),
            "atan": lambda: self._arctangent(node, first),
            "Abs": lambda: self._absolute(node, first),
            "sign": lambda: self.image(first) / self._made("Abs", first),
            "conjugate": lambda: self.image(self.conjugate(first)),
            "re": lambda: self._half(first, +1) * self.ring.number(fmpq(1, 2)),
            "im": lambda: (
                self._half(first, -1)
                / self.image(self.nodes.made("I"))
                * self.ring.number(fmpq(1, 2))
            ),
        }
        if name in rules:
            return rules[name]()
        if name.startswith("jacobi_"):
            return self._jacobi_value(name.removeprefix("jacobi_"), *arguments)
        raise CertificateError(f"there is no generator for a {name}")

    def _made(self, name: str, *arguments: int) -> Element:
        return self.image(self.nodes.made(name, *arguments))

    def _half(self, inner: int, sign: int) -> Element:
        other = self.image(self.conjugate(inner))
        return self.image(inner) + other if sign > 0 else self.image(inner) - other

    def _exponential(self, z: int) -> Element:
        """exp(sum n u) = product of exp(u)**n, with exp(q log f) = f**q."""
        result = self.one
        for coefficient, u in self._sum_of(self.nodes.made("exp", z)):
            inner = self.nodes.all[u]
            angle = self._angle(u)
            if inner[0] == "log":
                power = self.nodes.made("Pow", inner[1], coefficient)
                result = result * self.image(power)
            elif angle is not None and self.nodes.all[angle][0] == "atan":
                half = self._integer(coefficient / 2)
                result = result * self._phase(self.nodes.all[angle][1]) ** half
            else:
                result = result * self._made("exp", u) ** self._integer(coefficient)
        return result

    def _phase(self, f: int) -> Element:
        """exp(2 i atan f) = (1 + i f)/(1 - i f)."""
        turned = self.image(self.nodes.made("I")) * self.image(f)
        return (self.one + turned) / (self.one - turned)

    def _sum_of(self, function: int) -> Sum:
        """The combination that a hint gives for a function's argument, checked."""
        found, z = self.hints.sums.get(function), self.nodes.all[function][1]
        if found is None:
            raise CertificateError("there is no generator for a function of a sum")
        parts = [self.ring.number(n) * self.image(u) for n, u in found]
        if not (self._sum([self.zero, *parts]) - self.image(z)).is_zero:
            raise CertificateError("an argument is not the sum that it is said to be")
        return found

    def _integer(self, value: fmpq) -> int:
        if value.q != 1:
            raise CertificateError("coefficients in a sum of arguments must be integers")
        within("coefficients", abs(int(value.p)), EXPONENT)
        return int(value.p)

    def _logarithm(self, node: int, inner: int) -> Element:
        """log of a product of powers of positive factors."""
        if node not in self.hints.logs:
            raise CertificateError("there is no generator for a log")
        product, total = self.one, self.zero
        for q, factor in self.hints.logs[node]:
            if not self.signs.not_negative(factor):  # it is not 0 where the logarithm is smooth
                raise CertificateError("a factor in a logarithm is not shown to be positive")
            product = product * self.image(self.nodes.made("Pow", factor, q))
            part = self.nodes.all[factor]
            value = self.image(part[1]) if part[0] == "exp" else self._made("log", factor)
            total = total + self.ring.number(q) * value
        if product.is_zero or not (product - self.image(inner)).is_zero:
            raise CertificateError("a logarithm is not of the product that it is said to be of")
        return total

    def _arctangent(self, node: int, inner: int) -> Element:
        """The number between -pi/2 and pi/2 with a given tangent."""
        value = self._hinted(node, self.hints.values)
        if not self._is_between(value, -HALF_PI, HALF_PI):
            raise CertificateError("what an atan is said to be is not shown to be within pi/2 of 0")
        if not (self._made("tan", value) - self.image(inner)).is_zero:
            raise CertificateError("what an atan is said to be has another tangent")
        return self.image(value)

    # Elliptic functions.

    def _jacobi_value(self, name: str, z: int, m: int) -> Element:
        self._parameter(f"jacobi_{name}", m)
        if name == "theta":
            return self._theta(z, m)
        if name == "eta":
            root = self.image(self.nodes.made("Pow", m, fmpq(1, 4)))
            return root * self._made("jacobi_sn", z, m) * self._made("jacobi_theta", z, m)
        if name == "zeta" and not self._atoms.get("jacobi_zeta"):
            mean = self._made("elliptic_e", m) / self._made("elliptic_k", m)
            return self._made("jacobi_epsilon", z, m) - self.image(z) * mean
        station = self._station(z, m, name if name in ("epsilon", "zeta") else "")
        if name in ("epsilon", "zeta"):
            if station.second is None:
                return self.zero
            return station.second
        found: Element = getattr(station, name)
        return found

    def _station(self, z: int, m: int, second: str) -> Station:
        if (z, m, second) not in self._stations:
            found = self._sum_of(self.nodes.made("jacobi_sn", z, m))
            parts = [(self._integer(n), u) for n, u in found]
            total: Station | None = None
            for n, u in parts:
                if n:
                    step = self._base(u, m, second).times(n)
                    total = step if total is None else total + step
            if total is None:
                total = Station(self.image(m), self.zero, self.one, self.one, self.zero)
            self._stations[z, m, second] = total
        return self._stations[z, m, second]

    def _base(self, u: int, m: int, second: str) -> Station:
        """A generator's argument, or K, or again a sum."""
        made, parameter = self.nodes.made, self.image(m)
        if self.nodes.all[u] == ("elliptic_k", m):
            rest = made("Add", self.nodes.rational(1), made("Mul", self.nodes.rational(-1), m))
            dn = self.image(made("Pow", rest, fmpq(1, 2)))
            value = self._made("elliptic_e", m) if second == "epsilon" else self.zero
            return Station(parameter, self.one, self.zero, dn, value)
        names = [f"jacobi_{name}" for name in ("sn", "cn", "dn", second) if name]
        return Station(parameter, *(self._made(name, u, m) for name in names))

    def _theta(self, z: int, m: int) -> Element:
        """Theta is even; Theta(u-d) by the product theorem."""
        for atom in self._atoms.get("jacobi_theta", []):
            _, other, parameter = self.nodes.all[atom]
            if self.equal(m, parameter) and (self.image(z) + self.image(other)).is_zero:
                return self._images[atom]
        match self._sum_of(self.nodes.made("jacobi_theta", z, m)):
            case ((plus, u), (minus, d)) if plus == 1 and minus == -1:
                arguments = (self.nodes.made("Add", u, d), u, d, self.nodes.rational(0))
            case _:
                raise CertificateError("theta's argument must be a difference of two")
        ahead, here, shift, zero = (self._made("jacobi_theta", a, m) for a in arguments)
        sines = (self._made("jacobi_sn", u, m), self._made("jacobi_sn", d, m))
        return axioms.behind(self.image(m), (ahead, here, shift, zero), sines)

    # Conjugates, signs.

    def conjugate(self, node: int) -> int:
        """The complex conjugate of a node as a node."""
        made = self.nodes.made
        if self.signs.is_real(node):
            return node
        match self.nodes.all[node]:
            case ("I",):
                return made("Mul", self.nodes.rational(-1), node)
            case (("Add" | "Mul") as name, *parts):
                return made(name, *map(self.conjugate, parts))
            case ("Pow", base, exponent) if exponent.q == 1:
                return made("Pow", self.conjugate(base), exponent)
            case ("poly", terms, *parts):
                return made("poly", terms, *map(self.conjugate, parts))
            case ("conjugate", inner):
                return int(inner)
            case (str(name), inner) if name in ("exp", *axioms.HYPERBOLIC, *axioms.TRIGONOMETRIC):
                return made(name, self.conjugate(inner))
            case (("jacobi_sn" | "jacobi_cn" | "jacobi_dn") as name, z, m) if self.signs.is_real(m):
                return made(name, self.conjugate(z), m)
            case (name, *_):
                raise CertificateError(f"the conjugate of {name} does not follow from the domain")
        raise CertificateError("a node has no conjugate")

    def _stated(self, node: int) -> Sign:
        """The sign that an inequality of the domain gives a node with the same image."""
        if node in self._positive:
            return Sign((0, 1)) if self._positive[node] else Sign((1,))
        match self.nodes.all[node]:
            case ("cos", z) if self._is_between(z, -HALF_PI, HALF_PI):
                return POSITIVE
            case ("sin", z) if self._is_between(z, fmpq(0), 2 * HALF_PI):
                return POSITIVE if self.signs.positive(z) else NOT_NEGATIVE
        if self.nodes.all[node][0] not in ("Add", "Mul", "symbol"):
            return ANY
        if all(self.nodes.all[inner][0] != "symbol" for inner in self.nodes.below([node])):
            value = Balls(self.nodes, {}).ball(node).real
            return Sign((1 if value > 0 else -1,)) if value > 0 or value < 0 else ANY
        for bound, weak in self._positive.items():
            try:
                found = self._multiple(self.image(node), self.image(bound))
            except CertificateError:  # a formula of the domain that the proof has no generator for
                continue
            if found is not None:
                ratio, gap = found
                side = 1 if ratio > 0 else -1
                if gap * side >= 0:
                    return Sign((0, side)) if weak and gap == 0 else Sign((side,))
        return ANY

    def _is_between(self, node: int, low: fmpq, high: fmpq) -> bool:
        """Whether ``node`` is shown to be real and not outside two rational numbers."""
        made, number = self.nodes.made, self.nodes.rational
        negative = made("Mul", number(-1), node)
        above = made("Add", node, number(-int(low.p), int(low.q)))
        below = made("Add", negative, number(int(high.p), int(high.q)))
        return self.signs.not_negative(above) and self.signs.not_negative(below)

    def _multiple(self, element: Element, other: Element) -> tuple[fmpq, fmpq] | None:
        """Rational r, not 0, and c with ``element = r * other + c``."""
        above, below = element.numerator, other.numerator
        if element.powers or other.powers or above.is_constant() or below.is_constant():
            return None
        ratio = above.leading_coefficient() / below.leading_coefficient()
        gap = above - ratio * below
        if not gap.is_constant():
            return None
        return ratio, fmpq(0) if gap.is_zero() else gap.leading_coefficient()

    def _witness(self, node: int) -> int | None:
        other = self.hints.signs.get(node)
        if other is None:
            return None
        if not self.equal(node, other):
            raise CertificateError("the witness of a sign has another image")
        return other

    # Derivatives and values.

    def slope(self, place: int, variable: int) -> Element:
        """The derivative of a generator."""
        if (place, variable) not in self._slopes:
            self._slopes[place, variable] = self._slope(self.generators[place], variable)
        return self._slopes[place, variable]

    def _slope(self, generator: Generator, variable: int) -> Element:
        if generator.form:
            parts = [
                self.image(factor) * self._atom_slope(node, variable)
                for factor, node in generator.form
            ]
            return self._sum([self._rate(generator.shift, variable), *parts])
        slope, image = self._atom_slope(generator.node, variable), self._images[generator.node]
        if generator.scale is not None:
            scale = Element(self.ring, generator.scale)
            return slope * scale + image * self.derivative(scale, variable)
        if generator.below is not None:
            below = self.image(generator.below)
            return (slope - image * self._rate(generator.below, variable) / below) / below
        return slope

    def derivative(self, element: Element, variable: int) -> Element:
        """The chain rule, for the arguments of generators."""
        result = self.zero
        for place in sorted(element.places):
            name = self.ring.names[place]
            partial = element.numerator.derivative(name)
            if not partial.is_zero():
                part = Element(self.ring, partial, element.powers).cancelled()
                result = result + part * self.slope(place, variable)
            for factor, power in element.powers.items():
                partial = self.ring.factors[factor].derivative(name)
                if not partial.is_zero():
                    rate = Element(self.ring, power * partial, {factor: 1}).cancelled()
                    result = result - element * rate * self.slope(place, variable)
        return result

    def _atom_slope(self, node: int, variable: int) -> Element:
        """The axioms of differentiation."""
        image = self.image(node)
        match self.nodes.all[node]:
            case ("symbol", *_):
                return self.one if node == variable else self.zero
            case ("I",) | ("pi",) | (("elliptic_k" | "elliptic_e"), _):
                return self.zero
            case ("exp", z):
                return image * self._rate(z, variable)
            case ("log", f):
                return self._rate(f, variable) / self.image(f)
            case ("atan", f):
                return self._rate(f, variable) / (self.one + self.image(f) ** 2)
            case ("Pow", *_) if node in self._circles.values():
                return self.zero
            case ("Pow", base, exponent):
                rate = self._rate(base, variable)
                degree = self.ring.number(int(exponent.q))
                return self.zero if rate.is_zero else image * rate / (self.image(base) * degree)
            case ("Abs", f):
                rate = self.derivative(self._squared(f), variable)
                return self.zero if rate.is_zero else rate / (image + image)
            case (str(name), z, m) if name.startswith("jacobi_"):
                rate = self._rate(z, variable)
                if rate.is_zero:
                    return self.zero
                return rate * self._jacobi_slope(name.removeprefix("jacobi_"), image, z, m)
        raise CertificateError("the derivative of a generator does not follow from the axioms")

    def _rate(self, node: int, variable: int) -> Element:
        """The derivative of a formula, by its structure."""
        if (node, variable) not in self._rates:
            self._rates[node, variable] = self._made_rate(node, variable)
        return self._rates[node, variable]

    def _made_rate(self, node: int, variable: int) -> Element:
        if not self._moves(node):
            return self.zero
        match self.nodes.all[node]:
            case ("Add", *terms):
                return self._sum([self._rate(term, variable) for term in terms])
            case ("Mul", *factors):
                parts = []
                for i, factor in enumerate(factors):
                    rate = self._rate(factor, variable)
                    if not rate.is_zero:
                        others = (self.image(f) for j, f in enumerate(factors) if j != i)
                        parts.append(self._product([rate, *others]))
                return self._sum([self.zero, *parts])
            case ("Pow", base, exponent) if exponent.q == 1:
                outer = self.ring.number(exponent) * self.image(base) ** (int(exponent.p) - 1)
                return outer * self._rate(base, variable)
            case (name, *_) if name in AXIOMS:
                return self._atom_slope(node, variable)
        return self.derivative(self.image(node), variable)

    def _jacobi_slope(self, name: str, image: Element, z: int, m: int) -> Element:
        if name == "theta":
            return image * self._made("jacobi_zeta", z, m)
        if name in ("epsilon", "zeta"):
            square = self._made("jacobi_dn", z, m) ** 2
            if name == "epsilon":
                return square
            return square - self._made("elliptic_e", m) / self._made("elliptic_k", m)
        sign, with_m, functions = axioms.PRODUCTS[name]
        parts = [self._made(f"jacobi_{function}", z, m) for function in functions]
        result = self.ring.number(sign) * parts[0] * parts[1]
        return result * self.image(m) if with_m else result

    def balls(self, balls: Balls) -> list[acb]:
        """The values of the generators at a point."""
        values: list[acb] = []
        for generator in self.generators:
            if generator.form:
                parts = (balls.ball(factor) * balls.ball(node) for factor, node in generator.form)
                values.append(sum(parts, balls.ball(generator.shift)))
                continue
            value = balls.ball(generator.node)
            if generator.scale is not None:
                rest = [*values, *[acb(0)] * (len(self.ring.names) - len(values))]
                value *= value_at(generator.scale, rest)
            if generator.below is not None:
                value /= balls.ball(generator.below)
            values.append(value)
        return values


def solved(table: list[list[Element]]) -> list[Element]:
    """The solution of linear equations, each row with its right-hand side; by elimination."""
    size = len(table)
    for column in range(size):
        pivot = next((i for i in range(column, size) if not table[i][column].is_zero), None)
        if pivot is None:
            raise CertificateError("linear forms must be independent")
        table[column], table[pivot] = table[pivot], table[column]
        unit = table[column][column].inverse()
        table[column] = [entry * unit for entry in table[column]]
        for i in range(size):
            factor = table[i][column]
            if i != column and not factor.is_zero:
                pairs = zip(table[i], table[column], strict=True)
                table[i] = [entry - factor * other for entry, other in pairs]
    return [row[-1] for row in table]


def _whole(element: Element) -> fmpq_mpoly:
    """The polynomial that a fraction is."""
    if element.powers:
        raise CertificateError("a scale must be a polynomial in the generators")
    return element.numerator
