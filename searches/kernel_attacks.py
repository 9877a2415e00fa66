"""Three searches for what the proof kernel reads or accepts wrongly, against a second reader.

reading: a random statement of texts is read by the kernel and evaluated, as nodes or, where it has
derivatives, by the kernel's images, and by the parser of the command line as trees; `TextBalls`
evaluates the texts themselves.  signs: what the
kernel says of signs, bounds, branches and denominators on a random domain is looked at at points of
it.  certificates: forged proofs of statements that are false by balls, and mutated true ones.

    python -m searches.kernel_attacks reading|signs|certificates [--count 10000] [--seed 0]
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from random import Random

from flint import acb, arb, ctx, fmpq

from longwave.verify.kernel import CertificateError, check_certificate
from longwave.verify.kernel.axioms import FUNCTIONS
from longwave.verify.kernel.denominators import Denominators
from longwave.verify.kernel.field import Field, Hints
from longwave.verify.kernel.node_balls import Balls, value_at
from longwave.verify.kernel.nodes import Nodes
from longwave.verify.kernel.reading import Scope, formula
from longwave.verify.kernel.ring import Element
from longwave.verify.kernel.statement import Statement, Substitution, read_statement
from longwave.verify.kernel.table import RULES
from longwave.verify.proof.statement_text import read_statement as typed_statement
from longwave.verify.proof.typed_balls import TypedBalls
from searches.false_certificates import false_certificates
from searches.random_texts import ONE_PLACE, RandomText, condition, points
from searches.text_balls import BITS, CannotJudge, TextBalls, Values, words

Texts = dict[str, list[str]]
Found = Iterator[tuple[str, str]]
"""What was compared, and the failure or nothing."""

ERRORS = (CertificateError, LookupError, TypeError, ValueError, ArithmeticError)
"""What the kernel refuses a certificate for."""

HINTLESS = Hints({}, {})
ATOMS = ("symbol", "I", "pi", "exp", "log", "atan", "Pow", "Abs", "parity", "elliptic_k")
MOST = 60
"""Generators of a field."""

DEGREE_IN_N = 3
"""Sites at which a denominator may be 0 by itself, as n**3 - n is."""

LIKENESSES = ("ux", "u_t", "ubar", "u_bar", "uxx", "ustar", "u_x", "\u0443")


def field_of(
    nodes: Nodes, statement: Statement, roots: Sequence[int], hints: Hints = HINTLESS
) -> Field:
    """Return a field with a generator for whatever may be one below ``roots``."""
    positive = {nodes.gap(a, b): weak for weak, a, b in statement.domain}
    field = Field(nodes, MOST, statement.variables, positive, hints, RULES)
    taken = []
    for node in list(atoms(nodes, [*roots, *statement.variables])):
        if len(field.generators) < MOST and node not in hints.values:
            try:
                field.register(node)
                taken.append(node)
            except ERRORS:
                continue
    exact = Field(nodes, len(taken), statement.variables, positive, hints, RULES)
    for node in taken:
        exact.register(node)
    return exact


def atoms(nodes: Nodes, roots: Sequence[int]) -> Iterator[int]:
    """Yield the functions below ``roots`` that may be generators, and their own arguments."""
    imaginary = nodes.add("I")
    for node in [imaginary, *nodes.below(roots)]:
        name, *inner = nodes.all[node]
        definition = FUNCTIONS[name].definition if name in FUNCTIONS else ""
        if "exp(I*z)" in definition:
            yield nodes.add("exp", nodes.add("Mul", imaginary, inner[0]))
        elif "exp(z)" in definition:
            yield nodes.add("exp", inner[0])
        elif name == "Pow" and inner[1].q > 1:
            yield nodes.add("Pow", inner[0], fmpq(1, inner[1].q))
        elif name == "sign":
            yield nodes.add("Abs", inner[0])
        elif name in ATOMS or name.startswith("jacobi_"):
            yield node


def element_ball(field: Field, element: Element, balls: Balls) -> acb:
    """Return the value of an image at a point."""
    values = field.balls(balls)
    found = value_at(element.numerator, values)
    for place, power in element.powers.items():
        found /= value_at(field.ring.factors[place], values) ** power
    return found


class Reading:
    """A statement as the kernel reads it."""

    def __init__(self, texts: Texts) -> None:
        self.nodes = Nodes()
        self.statement, self.scope = read_statement(self.nodes, texts)
        self.symbols = [node for node in self.nodes.all if node[0] == "symbol"]
        put = Substitution(self.nodes, self.statement.variables, self.statement.formulas)
        self._roots = [put(equation) for equation in self.statement.equations]
        self._field: Field | None = None

    def field(self) -> Field:
        """Return the field of all functions in the statement."""
        if self._field is None:
            self._field = field_of(
                self.nodes, self.statement, [*self._roots, *self.statement.formulas]
            )
        return self._field

    def point(self, values: Values) -> dict[int, fmpq]:
        """Return the values of the statement's symbols."""
        found = {}
        for name, value in values.items():
            node = self.scope.known.get(name)
            if node is not None and self.nodes.all[node][0] == "symbol":
                found[node] = value
        return found

    def values(self, values: Values) -> list[acb]:
        """Return the left-hand sides and the formulas at a point."""
        balls = Balls(self.nodes, self.point(values))
        with ctx.workprec(2 * BITS):
            sides = [self._node(root, balls) for root in self._roots]
            return sides + [balls.ball(node) for node in self.statement.formulas]

    def _node(self, node: int, balls: Balls) -> acb:
        if all(self.nodes.all[inner][0] != "diff" for inner in self.nodes.below([node])):
            return balls.ball(node)
        return element_ball(self.field(), self.field().image(node), balls)


def random_statement(rng: Random) -> Texts:
    """Return texts of a statement of one unknown, with shifts, derivatives and parameters."""
    variables = rng.choice((["x", "t", "n"], ["x", "n"], ["x", "t"]))
    parameters = ["k: k > 0", "j: integer", *(["z: complex"] if rng.random() < 0.3 else [])]
    names = [*variables, "x", "n" if "n" in variables else "t", "k", "I", "pi", "y", "j"]
    names += ["z"] if len(parameters) > 2 else []
    functions = (*ONE_PLACE, "jacobi", "jacobi")
    inner = RandomText(rng, names, functions)
    if rng.random() < 0.3:
        parameters.append(f"c = {inner.formula(1)}")
        names.append("c")
    solution = inner.formula(rng.randint(1, 3))
    unknowns = ["u"]
    if "n" in variables:
        unknowns += [
            f"u[n{rng.choice('+-')}{rng.randint(1, 3)}]",
            f"u[n + 1 + {rng.randint(0, 8)}]",
        ]
    if rng.random() < 0.3:
        letter = rng.choice([v for v in variables if v != "n"])
        unknowns = ["u", f"u_{letter}", f"diff(u, {letter})", f"diff(u, x, {letter})"]
        unknowns += [f"diff(u**2, {letter})", "diff(x*abs(x)*exp(k*x), x)"]
        solution = RandomText(rng, names, DERIVED).formula(rng.randint(1, 2))
    outer = RandomText(rng, [*names, *unknowns, *unknowns], functions)
    left = f"{rng.choice(unknowns)} {rng.choice('+-*')} {outer.formula(rng.randint(1, 2))}"
    right = f" = {outer.formula(1)}" if rng.random() < 0.2 else ""
    u = "u[n] =" if "n" in variables and rng.random() < 0.3 else "u ="
    return {
        "variables": variables,
        "parameters": parameters,
        "domain": [],
        "equations": [left + right],
        "solutions": [f"{u} {solution}"],
    }


DERIVED = ("exp", "sin", "cosh", "tanh", "sqrt", "abs", "atan", "log", "sign", "re", "jacobi")


def line(*parts: object) -> str:
    """Return one line."""
    return " ".join(" | ".join(map(str, parts)).split())


def reading(rng: Random) -> Found:
    """Compare what the kernel reads with the texts, at six points."""
    texts = random_statement(rng)
    if rng.random() < 0.05:
        name = rng.choice(LIKENESSES)
        texts["parameters"].append(f"{name}: {name} > 0")
        try:
            found = Reading(texts)
        except ERRORS:
            yield "refused names", ""
        else:
            read = any(node[1] == name for node in found.symbols)
            yield "refused names", line("a name is a parameter", name, texts) if read else ""
        return
    try:
        kernel, balls, trees = Reading(texts), TextBalls(texts), trees_of(texts)
    except ERRORS:
        return
    own = [*texts["equations"], *map(" ".join, balls.solutions.values())]
    for point in points(rng, texts, 6):
        real = {k: v if isinstance(v, fmpq) else fmpq(int(v.real), 7) for k, v in point.items()}
        yield from trees_against(trees, balls, texts, real)
        try:
            theirs = kernel.values(real)
        except ERRORS:
            continue
        for text, their in zip(own, theirs, strict=True):
            try:
                mine = balls.value(text, real)
            except CannotJudge:
                continue
            if their.is_finite():
                yield (
                    "derivatives" if "diff" in text or "_x" in text else "values",
                    "" if mine.overlaps(their) else line(mine, their, text, texts, real),
                )


def trees_of(texts: Texts) -> TypedBalls | None:
    """Return the statement as the command line reads it; None where its grammar is narrower."""
    used = {word for part in ("equations", "solutions") for t in texts[part] for word in words(t)}
    declared = [text for text in texts["parameters"] if words(text)[0] in used]
    try:
        trees = typed_statement(texts["equations"], texts["solutions"], "; ".join(declared)).trees
    except ERRORS:
        return None
    return None if trees is None else TypedBalls(trees, {"j"})


def trees_against(trees: TypedBalls | None, balls: TextBalls, texts: Texts, point: Values) -> Found:
    """Compare the left-hand sides of the trees with those of the words at a point."""
    if trees is None:
        return
    exact = {name: Fraction(int(value.p), int(value.q)) for name, value in point.items()}
    try:
        mine = [balls.value(text, point) for text in texts["equations"]]
        theirs = list(trees.residuals(exact, BITS))
    except (*ERRORS, CannotJudge):
        return
    for text, own, other in zip(texts["equations"], mine, theirs, strict=True):
        yield "trees", "" if own.overlaps(other) else line(own, other, text, texts, point)


def signs(rng: Random) -> Found:
    """Compare what the kernel says on a domain with values in it."""
    names = ["x", "y", "n", "k"]
    draft = RandomText(rng, [*names, "x", "I"], (*ONE_PLACE, "jacobi"))
    draft.formula(3)
    parts = sorted({part for part in draft.parts if len(part) < 90})
    texts: Texts = {
        "variables": ["x", "n"],
        "parameters": ["k: 0 < k < 1", "y: real"],
        "domain": [condition(rng, names) for _ in range(rng.randint(0, 3))],
        "equations": ["u"],
        "solutions": ["u = 0"],
    }
    inside = list(points(rng, texts, 8, parts))
    if not inside:
        return
    balls, nodes = TextBalls(texts), Nodes()
    try:
        statement, scope = read_statement(nodes, texts)
    except ERRORS:
        return
    claims = [claim for part in parts for claim in sign_claims(nodes, statement, scope, part)]
    for _ in range(4):
        claims += branch_claims(rng, nodes, statement, scope, rng.choice(parts))
    for kind, text, test in claims:
        for point in inside:
            try:
                value = balls.value(text, point)
            except CannotJudge:
                continue
            yield kind, "" if test(value) else line(kind, text, value, texts["domain"], point)
    yield from denominators(rng, nodes, statement, scope, parts, (balls, inside))


Claim = tuple[str, str, Callable[[acb], bool]]


def sign_claims(nodes: Nodes, statement: Statement, scope: Scope, text: str) -> list[Claim]:
    """Check the kernel's claims on the values of a formula."""
    try:
        node = formula(scope, text)
        kernel = field_of(nodes, statement, [node]).signs
        if not kernel.is_real(node):
            return []
        bounds = kernel.interval(node)
    except ERRORS:
        return []
    claims: list[Claim] = [("real", text, lambda v: v.imag.contains(0))]
    if bounds.is_positive:
        claims.append(("sign", text, lambda v: not v.real <= 0))
    if (-bounds).is_positive:
        claims.append(("sign", text, lambda v: not v.real >= 0))
    if bounds.low is not None:
        low = bounds.low
        claims.append(("bound", text, lambda v: not v.real < arb(low)))
    if bounds.high is not None:
        high = bounds.high
        claims.append(("bound", text, lambda v: not v.real > arb(high)))
    return claims


BRANCHES = {
    "(({f})**2)**(1/2)": ("{f}", "-{f}", "abs({f})"),
    "((-1)*({f})**2)**(1/2)": ("I*{f}", "-I*{f}"),
    "(({f})**3)**(1/3)": ("{f}", "({f})*(-1/2 + I*3**(1/2)/2)"),
    "abs({f})": ("{f}", "-{f}", "I*{f}"),
    "abs(({f})**2)": ("({f})**2", "-({f})**2"),
    "atan(tan({f}))": ("{f}",),
    "asin(sin({f}))": ("{f}", "-{f}"),
    "acos(cos({f}))": ("{f}", "-{f}"),
    "acosh(cosh({f}))": ("{f}", "-{f}"),
    "asinh(sinh({f}))": ("{f}",),
    "atanh(tanh({f}))": ("{f}",),
    "(exp({f})**2)**(1/2)": ("exp({f})", "-exp({f})"),
    "(2*4**(1/2)*({f})**4)**(1/2)": ("2*({f})**2", "2*(-1)**3*({f})**2"),
    "({f})**(1/2)*0 + ((({f})**(1/2))**2)**(1/2)": ("({f})**(1/2)", "-({f})**(1/2)"),
}
"""Formulas with a branch, and what they may be said to be."""


def branch_claims(
    rng: Random, nodes: Nodes, statement: Statement, scope: Scope, part: str
) -> list[Claim]:
    """Check values that the kernel accepts for roots, absolute values and inverse functions."""
    pattern = rng.choice(list(BRANCHES))
    whole, value = (p.format(f=part) for p in (pattern, rng.choice(BRANCHES[pattern])))
    argument = whole.partition(" + ")[2] or whole
    try:
        node, other = formula(scope, argument), formula(scope, value)
        field = field_of(nodes, statement, [other], Hints({node: other}, {}))
        if not field.equal(node, other):
            return []
    except ERRORS:
        return []
    return [("branch", f"{argument} - ({value})", lambda v: v.contains(0))]


def denominators(
    rng: Random,
    nodes: Nodes,
    statement: Statement,
    scope: Scope,
    parts: Sequence[str],
    inside: tuple[TextBalls, Sequence[Values]],
) -> Found:
    """Check that a denominator which the kernel admits differs from 0 at some of any few points."""
    f, g = rng.choice(parts), rng.choice(parts)
    below = rng.choice(
        (f"({f} - abs({f}))", f"({f} - ({f}**2)**(1/2))", f"({f} - {g})", "(1 + (-1)**(n*1))",
         f"(1 - sign({f}))", f"(abs({f}*{g}) + {f}*{g})",
         f"(log({f}**2) - 2*log({f}) + abs({f}) - {f})",
         f"(({f})**(1/2) + abs({f})**(1/2))", f"({f} - {f}*(-1)**n)", f"(re({f}) - abs(re({f})))")
    )  # fmt: skip
    balls, points_inside = inside
    try:
        node = formula(scope, below)
        field = field_of(nodes, statement, [node])
        field.image(node).inverse()
        kernel_point = {scope.known[k]: v for k, v in points_inside[0].items() if k in scope.known}
        check = Denominators(field, statement, kernel_point)
        for factor in field.ring.factors:
            if not factor.is_constant():
                check.check(factor)
    except ERRORS:
        return
    of_sites, zeros = "n" in words(below), set[object]()
    for point in points_inside:
        try:
            if balls.value(below, point).contains(0):
                zeros.add(point["n"] if of_sites else tuple(point.values()))
        except CannotJudge:
            continue
        failed = len(zeros) > (DEGREE_IN_N if of_sites else 2)
        yield "denominator", line(below, statement.domain, point) if failed else ""


def certificates(rng: Random) -> Found:
    """Check that no proof of a false statement is accepted."""
    for kind, data in false_certificates(rng):
        try:
            check_certificate(data)
        except CertificateError:
            yield kind, ""
        else:
            yield kind, line(kind, data["statement"], data["proof"])


SEARCHES: Mapping[str, Callable[[Random], Found]] = {
    "reading": reading,
    "signs": signs,
    "certificates": certificates,
}


def search(name: str, count: int, seed: int) -> tuple[Counter[str], list[str], int]:
    """Return comparisons of each kind, failures, and the number of inputs."""
    counts, failures, number = Counter[str](), list[str](), 0
    while counts.total() < count:
        for kind, failure in SEARCHES[name](Random(f"{name} {seed} {number}")):
            counts[kind] += 1
            if failure:
                failures.append(line(f"{name} {seed} {number}", failure))
                break
        number += 1
    return counts, failures, number


def main() -> int:
    """Print the counts and every failure; 1 if there is any."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("search", choices=SEARCHES)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    counts, failures, inputs = search(options.search, options.count, options.seed)
    print(f"{counts.total()} comparisons of {inputs} inputs, {len(failures)} failures:")
    print(", ".join(f"{kind} {n}" for kind, n in sorted(counts.items())))
    print("\n".join(failures))
    return int(bool(failures))


if __name__ == "__main__":
    sys.exit(main())
