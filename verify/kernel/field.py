"""The images of a certificate's formulas in its generators, with their slopes and relations.

A generator is given by its meaning alone.  Relations and slopes follow from the axioms; sums,
products and integer powers are computed; a function must be a generator, or follow from generators
by an axiom whose premises are checked here, by exact arithmetic on images.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

from flint import acb, fmpq_mpoly

from . import axioms, further
from .derivations import Derivation, Slopes
from .functions import Functions
from .images import Form, Generator, Images
from .limits import CertificateError
from .nodes import SPECIAL, Balls, children, value_at
from .ring import Element


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


FREE = ("symbol", "pi", "elliptic_k", "elliptic_e", "exp", "log", "atan", *SPECIAL, "jet")
FREE_JACOBI = ("jacobi_epsilon", "jacobi_zeta", "jacobi_theta")
"""Functions that satisfy no polynomial relation of their own."""


class Field(Images):
    """Generators, images of nodes, and derivatives."""

    @cached_property
    def _functions(self) -> Functions:
        return Functions(self)

    @cached_property
    def _derivations(self) -> dict[int, tuple[frozenset[int], Derivation]]:
        return {}

    @cached_property
    def _slopes(self) -> Slopes:
        return Slopes(self)

    def register(self, node: int) -> None:
        """The next generator stands for ``node``, a function or a symbol.

        It is not used where another one stands for the same function of equal arguments.
        """
        self.walk(children(self.nodes.all[node]))
        known = self.known(node)
        if known is not None and node not in self._images:
            self.generators.append(Generator(node))
            self._images[node] = known
            return
        match self.nodes.all[node]:
            case ("symbol", *_) if node in self.circles:
                self._algebraic(node, 2, self.one - self.image(self.circles[node]) ** 2)
            case ("I",):
                self._algebraic(node, 2, -self.one)
            case ("Pow", base, exponent) if exponent.p == 1 and exponent.q > 1:
                self._algebraic(node, int(exponent.q), self.image(base))
            case ("exp", z) if (share := further.share_of_turn(self.nodes, z)) is not None:
                self._algebraic(node, *further.cyclotomic_relation(self._next, share))
            case ("parity", z) if self.nodes.all[z][0::2] == ("symbol", "integer"):
                self._algebraic(node, 2, self.one)
            case ("Abs", inner):
                self._algebraic(node, 2, self.squared(inner))
            case ("jacobi_sn" | "jacobi_cn" | "jacobi_dn" | "weierstrass_p_prime", *_):
                self._register_related(node)
            case (str(name), *_) if name in (*FREE, *FREE_JACOBI):
                self._functions.need_parameters(node)
                self._add(node, self._next, Generator(node))
            case (name, *_):
                raise CertificateError(f"{name} is no generator")

    def register_scaled(self, node: int, scale: int) -> None:
        """The next generator stands for ``scale`` times a Jacobi function."""
        match self.nodes.all[node]:
            case ("jacobi_sn" | "jacobi_cn" | "jacobi_dn", *_) if self.signs.is_clean(scale):
                self._register_related(node, self.image(scale))
            case _:
                raise CertificateError("what is scaled must be a Jacobi function")

    def register_circle(self, root: int, symbol: int) -> None:
        """The next generator stands for sqrt(1 - s**2); s itself is a root of it later."""
        if root != axioms.read(self.nodes, "sqrt(1 - z**2)", z=symbol):
            raise CertificateError("a circle must be of a symbol s and sqrt(1 - s**2)")
        if self.nodes.all[symbol][0] != "symbol" or symbol in self.variables:
            raise CertificateError("a circle must be of a parameter")
        self._add(root, self._next, Generator(root))
        self.circles[symbol] = root

    def register_quotient(self, node: int, below: int) -> None:
        """The next generator stands for ``node/below``, two theta functions."""
        for theta in (node, below):
            if self.nodes.all[theta][0] != "jacobi_theta":
                raise CertificateError("a quotient must be of theta functions")
            self._functions.need_parameters(theta)
        self._add(node, self._next * self.image(below), Generator(node, below=below))

    def register_forms(self, primitives: Sequence[int], rows: Sequence[Form]) -> None:
        """The next generators are linear in as many symbols or functions, with constant factors.

        The images of these follow by elimination.
        """
        for node in primitives:
            name = self.nodes.all[node][0]
            if node in self._images or (name not in FREE and name not in FREE_JACOBI):
                raise CertificateError(f"a {name} cannot be in a linear form, or is known")
            self._functions.need_parameters(node)
        places = range(len(self.generators), len(self.generators) + len(rows))
        table = []
        for place, (factors, shift) in zip(places, rows, strict=True):
            if not all(self.signs.is_clean(node) for node in (*factors, shift)):
                raise CertificateError("a linear form must be analytic on the domain")
            if any(map(self.moves, factors)):
                raise CertificateError("the factors of a linear form must be constant")
            rest = self.ring.generator(place) - self.image(shift)
            table.append([*map(self.image, factors), rest])
            pairs = tuple(zip(factors, primitives, strict=True))
            self.generators.append(Generator(0, form=pairs, shift=shift))
        for node, value in zip(primitives, solved(table), strict=True):
            self._images[node] = value
            self._atoms.setdefault(self.nodes.all[node][0], []).append(node)

    def register_part(self, left: int, right: int) -> None:
        """The next generator stands for either of two formulas that were proved equal."""
        self._add(left, self._next, Generator(left))
        self._images[right] = self._images[left]

    def slope(self, place: int, variable: int) -> Element:
        """The derivative of a generator."""
        return self._slopes.slope(place, variable)

    def derivative(self, element: Element, variable: int) -> Element:
        """The derivative of an element, of which all generators' slopes follow from the axioms."""
        known, derivation = self._derivations.get(variable, (frozenset[int](), None))
        if derivation is None or not element.places <= known:
            known |= element.places
            derivation = Derivation(self.ring, {p: self.slope(p, variable) for p in known})
            self._derivations[variable] = known, derivation
        return derivation(element)

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

    def _register_related(self, node: int, scale: Element | None = None) -> None:
        self._functions.need_parameters(node)
        own, *rest = self.nodes.all[node]
        for (name, other), text in axioms.SQUARES.items():
            if name == own and self.nodes.made(other, *rest) in self._images:
                letters = axioms.letters(self.nodes.all[node])
                square = self.image(axioms.read(self.nodes, text, **letters))
                self._algebraic(node, 2, square, scale)
                return
        self._add_scaled(node, _whole(scale or self.one))

    def is_kept(self, name: str, f: int, value: int) -> bool:
        """Whether ``value``, of which the function is ``f``, is principal by continuity."""
        return further.is_kept(self, name, f, value)

    def _function(self, node: int) -> Element:
        return self._functions.value(node)


def _whole(element: Element) -> fmpq_mpoly:
    """The polynomial that a fraction is."""
    if element.powers:
        raise CertificateError("a scale must be a polynomial in the generators")
    return element.numerator
