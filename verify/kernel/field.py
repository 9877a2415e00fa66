"""Field of a proof: images of its formulas in its generators, and the generators' relations.

A generator is given by its meaning alone, a formula.  Relations and slopes follow from the axioms;
sums, products and integer powers are computed; a function must be a generator, or follow from
generators by a rule whose premises are checked, by exact arithmetic on images.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import mul
from typing import Any, ClassVar

from flint import acb, fmpq, fmpq_mpoly

from .axioms import FUNCTIONS, SQUARES
from .limits import CertificateError
from .node_balls import Balls, value_at
from .nodes import Nodes, children
from .reading import axiom
from .ring import Derivation, Element, Ring, total
from .signs import Signs


@dataclass(frozen=True)
class Rule:
    """Rule for one question about some functions; ``answer`` returns None if it does not apply."""

    question: str
    functions: tuple[str, ...]
    answer: Callable[..., Any]
    assumes: str


class Rules:
    """Rules in the order in which they are tried; `table.RULES` are those of the kernel."""

    def __init__(self, *rows: Rule) -> None:
        self.rows = rows
        self._answers: defaultdict[tuple[str, str], list[Callable[..., Any]]] = defaultdict(list)
        for row in rows:
            for name in row.functions:
                self._answers[row.question, name].append(row.answer)

    def tried(self, question: str, function: str) -> Sequence[Callable[..., Any]]:
        """Return the ``answer`` callables of the rules for a question and a function, in order."""
        return self._answers[question, function]


Row = tuple[Sequence[int], int]
"""Linear form in given functions: the nodes of their factors, and of the term added to them."""


@dataclass(frozen=True)
class Hints:
    """Hints for a proof, all of which are checked.

    ``values`` maps a root, absolute value, logarithm or inverse function to an equal node, or f(z)
    to f of a sum equal to z; ``signs`` maps a node to an equal one whose structure shows its sign.
    """

    values: Mapping[int, int]
    signs: Mapping[int, int]


@dataclass(frozen=True)
class Generator:
    """Meaning of a generator: the node ``formula`` times ``scale``, a ring polynomial.

    The formula is a linear form plus a further term; ``form`` has pairs (factor, primitive).
    """

    formula: int
    scale: fmpq_mpoly
    form: tuple[tuple[int, int], ...]


class Slopes:
    """Derivatives of a field's generators, and of the elements and formulas made of them."""

    def __init__(self, field: Field) -> None:
        self._field = field
        self._slopes: dict[tuple[int, int], Element] = {}
        self._rates: dict[tuple[int, int], Element] = {}
        self._derivations: dict[int, tuple[frozenset[int], Derivation]] = {}

    def derivative(self, element: Element, variable: int) -> Element:
        """Return the derivative of an element, by the slopes of its generators."""
        known, derivation = self._derivations.get(variable, (frozenset[int](), None))
        if derivation is None or not element.places <= known:
            slopes = {p: self.slope(p, variable) for p in sorted(known | element.places)}
            derivation = Derivation(self._field.ring, slopes)
            self._derivations[variable] = frozenset(slopes), derivation
        return derivation(element)

    def slope(self, place: int, variable: int) -> Element:
        """Return the derivative of generator number ``place`` in ``variable``."""
        if (place, variable) not in self._slopes:
            generator = self._field.generators[place]
            rate = self.rate(generator.formula, variable)
            if not generator.scale.is_one():
                factor = Element(self._field.ring, generator.scale)
                image = self._field.ring.generator(place) / factor
                rate = rate * factor + image * self.derivative(factor, variable)
            self._slopes[place, variable] = rate
        return self._slopes[place, variable]

    def rate(self, node: int, variable: int) -> Element:
        """Return the derivative of a formula, by its structure and the axioms."""
        if (node, variable) not in self._rates:
            moves = variable in self._field.nodes.below([node])
            rate = self._made_rate(node, variable) if moves else self._field.zero
            self._rates[node, variable] = rate
        return self._rates[node, variable]

    def _made_rate(self, node: int, variable: int) -> Element:
        field = self._field
        match field.nodes.all[node]:
            case ("symbol", *_):
                return field.one
            case ("Add", *terms):
                return field.sum([self.rate(term, variable) for term in terms])
            case ("Mul", *factors):
                parts = [field.zero]
                for i, factor in enumerate(factors):
                    rate = self.rate(factor, variable)
                    if not rate.is_zero:
                        others = [f for j, f in enumerate(factors) if j != i]
                        parts.append(rate * field.product(others) if others else rate)
                return field.sum(parts)
            case ("Pow", base, exponent) if node in field.primitives("Pow"):
                rate = field.ring.number(exponent) * self.rate(base, variable)
                return rate if rate.is_zero else rate * field.image(node) / field.image(base)
            case ("Pow", base, exponent) if exponent.q == 1:
                outer = field.image(base) ** (int(exponent.p) - 1)
                return field.ring.number(exponent) * outer * self.rate(base, variable)
            case ("Abs", f) if node in field.primitives("Abs"):
                rate = self.derivative(field.squared(f), variable)
                return rate if rate.is_zero else rate / (field.image(node) + field.image(node))
            case ("jet" | "theta", *_):
                return self._free_rate(node, variable)
            case (str(name), *arguments) if name in FUNCTIONS and FUNCTIONS[name].slope:
                letters = FUNCTIONS[name].arguments(*arguments)
                rate = self.rate(letters["z"], variable)
                return rate if rate.is_zero else rate * field.read(FUNCTIONS[name].slope, **letters)
            case (name, *_) if node in field.primitives(name):
                raise CertificateError("a generator's derivative does not follow from the axioms")
        return self.derivative(field.image(node), variable)

    def _free_rate(self, node: int, variable: int) -> Element:
        """Return the derivative of an arbitrary or theta function; theta has f_zz = -4 q f_q."""
        field = self._field
        name, z, *nome, (label, order) = field.nodes.all[node]
        total = field.zero
        inner = self.rate(z, variable)
        if not inner.is_zero:
            total = inner * field.image_of(name, z, *nome, (label, order + 1))
        for q in nome:
            turn = self.rate(q, variable)
            if not turn.is_zero:
                factor = turn / (field.ring.number(-4) * field.image(q))
                total = total + factor * field.image_of(name, z, q, (label, order + 2))
        return total


class Field:
    """Generators, images of nodes, and derivatives.

    ``positive`` has the nodes that the domain states to be > 0 (True: >= 0).  ``circles`` maps a
    symbol s to the node of sqrt(1 - s**2), if that is an earlier generator than s.
    """

    ring_type: ClassVar[type[Ring]] = Ring
    slopes_type: ClassVar[type[Slopes]] = Slopes

    def __init__(
        self,
        nodes: Nodes,
        count: int,
        variables: Sequence[int],
        positive: Mapping[int, bool],
        hints: Hints,
        rules: Rules,
    ) -> None:
        self.nodes, self.ring, self.hints, self.rules = nodes, self.ring_type(count), hints, rules
        self.variables, self.generators = variables, list[Generator]()
        self.positive, self.point, self.circles = positive, dict[int, fmpq](), dict[int, int]()
        self.signs = Signs(nodes, self.image, positive, hints.signs)
        self.one, self.zero = self.ring.number(1), self.ring.number(0)
        self._images, self._underway = dict[int, Element](), set[int]()
        self._primitives: dict[str, list[int]] = {}
        self.slopes = self.slopes_type(self)

    def walk(self, nodes: Iterable[int]) -> None:
        """Compute the images of ``nodes``, arguments first, so that recursion stays shallow."""
        needed = set(nodes)
        for node in range(max(needed, default=-1), -1, -1):
            if node in needed and node not in self._images:
                inner = self._size(node)
                needed.update(children(self.nodes.all[node]) if inner is None else (inner,))
        for node in sorted(needed):
            self.image(node)

    def _size(self, node: int) -> int | None:
        """Return the node of f if ``node`` is an even power of abs(f); None for any other node."""
        match self.nodes.all[node]:
            case ("Pow", base, exponent) if exponent.q == 1 and exponent.p % 2 == 0:
                name, *inner = self.nodes.all[base]
                return inner[0] if name == "Abs" else None
        return None

    def image(self, node: int) -> Element:
        """Return the image of a node in the ring; raises CertificateError if it has none."""
        if node not in self._images:
            if node in self._underway:
                raise CertificateError("an image must not be defined by itself")
            self._underway.add(node)
            try:
                self._images[node] = self._image(node)
            finally:
                self._underway.remove(node)
        return self._images[node]

    def _image(self, node: int) -> Element:
        match self.nodes.all[node]:
            case ("number", value):
                return self.ring.number(value)
            case ("Add", *terms):
                return self.sum([self.image(term) for term in terms])
            case ("Mul", *factors):
                return self.product(factors)
            case ("Pow", base, exponent) if exponent.q == 1:
                inner = self._size(node)
                if inner is not None:
                    return self.squared(inner) ** (int(exponent.p) // 2)
                return self.image(base) ** int(exponent.p)
            case ("Pow", base, exponent) if exponent.p != 1:
                return self.image_of("Pow", base, fmpq(1, exponent.q)) ** int(exponent.p)
            case (("symbol" | "I" | "pi") as name, *label):
                words = f"the symbol {label[0]}" if label else name
                raise CertificateError(f"there is no generator for {words}")
        return self._function(node)

    def _function(self, node: int) -> Element:
        """Return the image of a root or function: by a generator, a hint, a rule, an axiom."""
        known = self.known(node)
        if known is not None:
            return known
        other = self.renamed(node)
        if other not in (None, node):
            return self.image(other)
        turned = self._turned(node) if other is None else None
        if turned is not None:
            return turned
        name, *arguments = self.nodes.all[node]
        for result in (answer(self, node) for answer in self.rules.tried("image", name)):
            if result is not None:
                return result
        own = FUNCTIONS.get(name)
        if own is None or not own.definition:
            raise CertificateError(f"there is no generator for a {name}")
        return self.read(own.definition, **own.arguments(*arguments))

    def image_of(self, name: str, *arguments: Any) -> Element:
        """Return the image of the node ``(name, *arguments)``."""
        return self.image(self.nodes.add(name, *arguments))

    def read(self, text: str, **letters: int) -> Element:
        """Return the image of an axiom's text, with nodes in place of its letters."""
        return self.image(axiom(self.nodes, text, **letters))

    def sum(self, parts: Sequence[Element]) -> Element:
        """Return the sum of ``parts``; those with equal denominators are added first, for speed."""
        by_denominator: dict[frozenset[tuple[int, int]], Element] = {}
        for part in parts:
            key = frozenset(part.powers.items())
            known = by_denominator.get(key, self.zero)
            by_denominator[key] = replace(part, numerator=part.numerator + known.numerator)
        return total(self.ring, list(by_denominator.values())).cancelled()

    def product(self, factors: Iterable[int]) -> Element:
        """Return the product of the images of ``factors``."""
        return reduce(mul, map(self.image, factors))

    def squared(self, inner: int) -> Element:
        """Return the image of abs(f)**2 = f conj(f) for the node ``inner`` of f."""
        return self.image(inner) * self.image(self.signs.conjugate(inner))

    def equal(self, left: int, right: int) -> bool:
        """Return whether two nodes have the same image."""
        return left == right or (self.image(left) - self.image(right)).is_zero

    def moves(self, node: int) -> bool:
        """Return whether a formula contains a real variable of the statement."""
        real = {v for v in self.variables if self.nodes.all[v][2] == "real"}
        return not real.isdisjoint(self.nodes.below([node]))

    def is_kept(self, name: str, f: int, value: int) -> bool:
        """Return whether continuity shows that ``value`` is ``name(f)``, such as atan(f)."""
        return any(rule(self, name, f, value) for rule in self.rules.tried("continuity", name))

    def derivative(self, element: Element, variable: int) -> Element:
        """Return the derivative of an element, by slopes that follow from the axioms."""
        return self.slopes.derivative(element, variable)

    def primitives(self, name: str) -> list[int]:
        """Return the nodes with the function ``name`` that are registered in generators."""
        return self._primitives.get(name, [])

    def known(self, node: int) -> Element | None:
        """Return the image of ``node`` if the same function of equal arguments has a generator."""
        others = self.primitives(self.nodes.all[node][0])
        return next((self._images[other] for other in others if self._alike(node, other)), None)

    def hinted(self, node: int) -> int | None:
        """Return the hinted value of a node, or of its function at equal arguments; else None."""
        values = self.hints.values
        if node in values:
            return values[node]
        return next((values[other] for other in values if self._alike(node, other)), None)

    def _alike(self, node: int, other: int) -> bool:
        """Return whether two nodes are the same function, with arguments whose images are equal."""
        left, right = self.nodes.all[node], self.nodes.all[other]
        inner, outer = children(left), children(right)
        if left[0] != right[0] or left[len(inner) + 1 :] != right[len(outer) + 1 :]:
            return False
        try:
            return all(self.equal(a, b) for a, b in zip(inner, outer, strict=True))
        except CertificateError:  # a hint for a node that the proof has no generator for
            return False

    def renamed(self, node: int) -> int | None:
        """Return f(w) for a node f(z) with a hint z = w, which is checked; None without a hint."""
        name, *arguments = self.nodes.all[node]
        if name not in FUNCTIONS or FUNCTIONS[name].symmetry in ("", "same"):
            return None
        key = self.nodes.add("jacobi_sn", *arguments) if name in SINES else node
        value = self.hinted(key)
        if value is None or self.nodes.all[value][0] != self.nodes.all[key][0]:
            return None
        rewritten = self.nodes.add(name, *self.nodes.all[value][1:])
        if rewritten != node and not self._alike(key, value):
            raise CertificateError("the sum given for an argument is not equal to it")
        return rewritten

    def _turned(self, node: int) -> Element | None:
        """Return the image of f(z) by symmetry, if f(-z) has a generator or hint; else None."""
        name, *arguments = self.nodes.all[node]
        symmetry = FUNCTIONS[name].symmetry if name in FUNCTIONS else ""
        if not symmetry:
            return None
        place = FUNCTIONS[name].letters.index("z")
        arguments[place] = self.nodes.negative(arguments[place])
        other = self.nodes.add(name, *arguments)
        if self.known(other) is None and self.renamed(other) is None:
            return None
        value = self.image(other)
        return value.inverse() if symmetry == "inverse" else value if symmetry == "even" else -value

    def register(self, node: int) -> None:
        """Register the next generator, a function or symbol; an equal function shares its image."""
        self._enter_circle(node)
        self.walk(children(self.nodes.all[node]) if node not in self.circles.values() else ())
        known = self.known(node)
        if known is not None and node not in self._images:
            self.generators.append(Generator(node, self.ring.context.constant(1), ()))
            self._images[node] = known
        else:
            self.register_forms([node], [((self.nodes.rational(1),), self.nodes.rational(0))])

    def register_forms(self, nodes: Sequence[int], rows: Sequence[Row]) -> None:
        """Register the linear forms ``rows`` of ``nodes``, or a multiple of one root."""
        relations = [self._relation(node) for node in nodes]
        for node in nodes:
            self._divide_by_argument(node)
        places = range(len(self.generators), len(self.generators) + len(rows))
        table = []
        for place, (factors, shift) in zip(places, rows, strict=True):
            if not all(self.signs.is_analytic(node) for node in (*factors, shift)):
                raise CertificateError("a linear form must be analytic on the domain")
            pairs = tuple(zip(factors, nodes, strict=True))
            parts = [p if self.nodes.value(f) == 1 else self.nodes.product(f, p) for f, p in pairs]
            parts += [] if self.nodes.value(shift) == 0 else [shift]
            formula = parts[0] if len(parts) == 1 else self.nodes.add("Add", *parts)
            scale = self.ring.context.constant(1)
            if relations[0] is not None and len(nodes) == 1 and self.nodes.value(shift) == 0:
                scale = self.relate(place, *relations[0], self.image(factors[0]))
            elif any(relations):
                raise CertificateError("a linear form must be a multiple of a root, or have none")
            self.generators.append(Generator(formula, scale, pairs))
            image = self.ring.generator(place) / Element(self.ring, scale) - self.image(shift)
            table.append([*map(self.image, factors), image])
        for node, value in zip(nodes, solved(table), strict=True):
            self._add(node, value)

    def relate(self, place: int, degree: int, value: Element, factor: Element) -> fmpq_mpoly:
        """Enter the relation of g = d * factor * root, where root**degree = value; return d.

        The denominator d makes g**degree a polynomial."""
        if place in value.places and not (factor - self.one).is_zero:
            raise CertificateError("a multiple of a root of unity is no generator")
        value = value * factor**degree
        below, power = value.denominator(), value.numerator
        for _ in range(degree - 1):
            power = self.ring.product(power, below)
        self.ring.relate(place, degree, power)
        return below

    def register_part(self, left: int, right: int) -> None:
        """Register one generator for two formulas that were proved equal."""
        image = self.ring.generator(len(self.generators))
        one = self.nodes.rational(1)
        self.generators.append(Generator(left, self.ring.context.constant(1), ((one, left),)))
        self._add(left, image)
        self._images[right] = image

    def _add(self, node: int, image: Element) -> None:
        if node in self._images:
            raise CertificateError("a generator must be new")
        self._images[node] = image
        self._primitives.setdefault(self.nodes.all[node][0], []).append(node)

    def _enter_circle(self, root: int) -> None:
        """Add ``root`` to ``circles`` if it is sqrt(1 - s**2) of a parameter s without an image."""
        for symbol in self.nodes.below([root]):
            is_symbol = self.nodes.all[symbol][0] == "symbol" and symbol not in self.variables
            of = axiom(self.nodes, "sqrt(1 - z**2)", z=symbol) if is_symbol else None
            if root == of and symbol not in self._images:
                self.circles[symbol] = root

    def _relation(self, node: int) -> tuple[int, Element] | None:
        """Return n and the image of f**n for an algebraic node f; None if f is a free generator."""
        self.need_parameters(node)
        match self.nodes.all[node]:
            case ("Pow", *_) if node in self.circles.values():
                return None
            case ("symbol", *_) if node in self.circles:
                return 2, self.one - self.image(self.circles[node]) ** 2
            case ("symbol" | "pi", *_):
                return None
            case ("I",):
                return 2, -self.one
            case ("Pow", base, exponent) if exponent.p == 1 and exponent.q > 1:
                return int(exponent.q), self.image(base)
            case ("Abs", inner):
                return 2, self.squared(inner)
            case ("conjugate", inner) if self.nodes.all[inner][::2] == ("symbol", "complex"):
                return None
            case (str(name), *arguments) if name in {own for own, _ in SQUARES}:
                for (own, other), text in SQUARES.items():
                    if own == name and self.nodes.add(other, *arguments) in self._images:
                        return 2, self.read(text, **FUNCTIONS[own].arguments(*arguments))
                return None
            case (str(name), *_) if answers := self.rules.tried("relation", name):
                return answers[0](self, node)
            case (str(name), *_) if name in FUNCTIONS and FUNCTIONS[name].free:
                return None
        raise CertificateError(f"{self.nodes.all[node][0]} is no generator")

    def need_parameters(self, node: int) -> None:
        """Check that the parameters of a function are in range, and constant except for a nome."""
        name, arguments = self.nodes.all[node][0], children(self.nodes.all[node])
        if name not in FUNCTIONS or FUNCTIONS[name].letters == "z" or name == "power":
            return
        if name != "theta" and any(map(self.moves, FUNCTIONS[name].parameters(*arguments))):
            raise CertificateError(f"the parameters of {name} must be constant")
        needed = self.signs.needed(name, *arguments)
        if needed:
            raise CertificateError(f"{name} needs {needed}, which is not shown on the domain")

    def _divide_by_argument(self, node: int) -> None:
        """Record the argument of log, bessel_y or bessel_k, if it may be 0, as a divisor."""
        match self.nodes.all[node]:
            case ("log", z) | (("bessel_y" | "bessel_k"), _, z) if not self.signs.positive(z):
                self.image(z).inverse()

    def balls(self, balls: Balls) -> list[acb]:
        """Return balls around the generators' values, from the ``balls`` of nodes at a point."""
        values: list[acb] = []
        for generator in self.generators:
            rest = [*values, *[acb(0)] * (len(self.ring.names) - len(values))]
            values.append(balls.ball(generator.formula) * value_at(generator.scale, rest))
        return values


SINES = ("jacobi_cn", "jacobi_dn", "jacobi_epsilon", "jacobi_zeta")
"""Functions whose argument is rewritten by the hint for jacobi_sn of the same argument."""


def solved(table: list[list[Element]]) -> list[Element]:
    """Solve linear equations; a row of ``table`` has coefficients, then the right-hand side."""
    count = len(table)
    for column in range(count):
        pivot = next((i for i in range(column, count) if not table[i][column].is_zero), None)
        if pivot is None:
            raise CertificateError("linear forms must be independent")
        table[column], table[pivot] = table[pivot], table[column]
        unit = table[column][column].inverse()
        table[column] = [entry * unit for entry in table[column]]
        for i in range(count):
            factor = table[i][column]
            if i != column and not factor.is_zero:
                pairs = zip(table[i], table[column], strict=True)
                table[i] = [entry - factor * other for entry, other in pairs]
    return [row[-1] for row in table]
