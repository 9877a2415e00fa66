"""What a maker of statements works with: letters, random formulas, and the way to a statement.

A `Draft` is true by construction.  `Draft.statement` writes it in other words and, for a false
statement, makes one change and keeps it if the judge finds a point at which an equation fails.
"""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction

from searches.texts.ball_judge import BITS, CannotJudge, Judge
from searches.texts.rewordings import mutated, reworded
from searches.texts.text_statement import VARIABLES, Letter, TextPoint, TextStatement, Truth
from searches.texts.trees import (
    ONE,
    Tree,
    as_tree,
    call,
    mapped,
    name,
    put,
    read,
    total,
)

TRIES = 6
"""Points at which a change is looked for."""

NAMES = (
    "a", "b", "c", "k", "q", "r", "w", "h", "U", "lambda", "gamma", "beta", "E", "e", "i", "root",
    "sn", "N", "S", "Q", "O", "zeta", "theta", "A1", "re1", "Im", "T", "X", "mu", "j",
)  # fmt: skip
"""Of parameters: among them some that a prover may take for its own."""

LARGEST = 120
"""Nodes of a statement; longer ones take the prover longer."""

SMALL = (-3, -2, -1, 1, 2, 3)


@dataclass
class Draft:
    """A true statement on its way: equations in jets, a formula for each unknown, ranges."""

    draw: random.Random
    equations: list[Tree] = field(default_factory=list)
    solutions: dict[str, Tree] = field(default_factory=dict)
    letters: dict[str, Letter] = field(default_factory=dict)
    definitions: dict[str, Tree] = field(default_factory=dict)
    counterexample: TextPoint | None = None

    # letters

    def letter(self, text: str) -> Tree:
        """A letter from words such as ``k``, ``k>0``, ``m:0:1``, ``n`` (a site)."""
        made = letter_of(text)
        self.letters[made.name] = made
        return name(made.name)

    def number(self) -> Tree:
        """A small rational number other than 0."""
        return as_tree(Fraction(self.draw.choice(SMALL), self.draw.choice((1, 1, 1, 2, 3))))

    def constant(self, parameters: Sequence[str]) -> Tree:
        """A number, or a parameter times one."""
        if not parameters or self.draw.random() < 0.5:
            return self.number()
        chosen = name(self.draw.choice(parameters))
        return chosen if self.draw.random() < 0.6 else self.number() * chosen

    # the way to a statement

    def statement(self, kind: str, falsehood: float = 0.45) -> TextStatement | None:
        """The statement, true or with one change; None if it is too long or cannot be judged."""
        self._reworded()
        if sum(tree.size() for tree in (*self.equations, *self.solutions.values())) > LARGEST:
            return None
        wanted = self.counterexample is not None or self.draw.random() < falsehood
        if not wanted:
            made = self._written(kind, Truth.TRUE)
            return None if self._label_fails(made) else made
        if self.counterexample is None:
            equations, solutions = mutated(self.draw, self.equations, self.solutions)
            self.equations, self.solutions = list(equations), dict(solutions)
        if not all(has_jet(equation) for equation in self.equations):
            return None
        return shown_false(self._written(kind, Truth.FALSE), self.draw, self.counterexample)

    def _label_fails(self, made: TextStatement) -> bool:
        """Whether a true statement has no value at a point; a residual there is an error."""
        judge = Judge(made)
        for _ in range(2):
            point = made.point(self.draw)
            try:
                if judge.fails_at(point, BITS[:1]):
                    raise AssertionError(f"a true statement fails at {point}:\n{made.script()}")
            except CannotJudge:
                continue
            return False
        return True

    def _reworded(self) -> None:
        draw = self.draw
        for unknown, formula in self.solutions.items():
            self.solutions[unknown] = reworded(formula, draw, draw.choice((0, 0, 1, 2)))
        self.equations = [
            reworded(equation, draw, draw.choice((0, 0, 0, 1))) for equation in self.equations
        ]
        if len(self.equations) > 1 and draw.random() < 0.3:
            first, second = draw.sample(range(len(self.equations)), 2)
            self.equations[first] += self.number() * self.equations[second]

    def _written(self, kind: str, truth: Truth) -> TextStatement:
        used: set[str] = set()
        for tree in (*self.equations, *self.solutions.values(), *self.definitions.values()):
            used |= tree.names()
            jets = [node.jet for node in tree.nodes() if node.head == "jet"]
            used |= {letter for _, steps, _ in jets for letter in steps}
            used |= {"n" for _, _, shift in jets if shift is not None}
            used |= {c for node in tree.nodes() if node.head == "diff" for c in str(node.value)}
        used |= {self.letters[key].under for key in used & self.letters.keys()}
        letters = tuple(made for key, made in self.letters.items() if key in used)
        sited = any(made.name == "n" for made in letters)
        return TextStatement(
            kind,
            truth,
            tuple(self._sides(equation) for equation in self.equations),
            tuple(f"{u}{'[n]' if sited else ''} = {f}" for u, f in self.solutions.items()),
            letters,
            tuple((key, str(tree)) for key, tree in self.definitions.items() if key in used),
            self.counterexample,
        )

    def _sides(self, equation: Tree) -> str:
        """``left = right`` now and then."""
        if equation.head == "+" and len(equation.args) > 1 and self.draw.random() < 0.2:
            place = self.draw.randrange(1, len(equation.args))
            return f"{total(*equation.args[:place])} = {-total(*equation.args[place:])}"
        return str(equation)


def has_jet(tree: Tree) -> bool:
    """Whether an unknown occurs."""
    return any(node.head == "jet" for node in tree.nodes())


def letter_of(text: str) -> Letter:
    """A letter from words such as ``k``, ``k>0``, ``k<0``, ``m:0:1``; the site is an integer."""
    if ":" in text:
        own, low, high = text.split(":")
        return Letter(own, Fraction(low), Fraction(high), own == "n")
    if ">" in text:
        own, _, low = text.partition(">")
        return Letter(own, Fraction(low), integer=own == "n")
    own, _, high = text.partition("<")
    return Letter(own, None, Fraction(high) if high else None, integer=own == "n")


def shown_false(
    made: TextStatement, draw: random.Random, point: TextPoint | None = None
) -> TextStatement | None:
    """The statement with a point at which an equation fails; None if none is found."""
    judge = Judge(made)
    for attempt in range(TRIES):
        tried = {**made.point(draw), **(point or {})}
        try:
            if judge.fails_at(tried, BITS[: 1 if attempt else 2]):
                return replace(made, counterexample=tried)
        except CannotJudge:
            continue
    return None


# what is done to a true draft


@dataclass(frozen=True)
class Known:
    """A solution from the literature, in text: each letter's range in ``letters``."""

    equations: str
    solutions: str
    letters: str
    weight: float = 1.0

    def draft(self, draw: random.Random) -> Draft:
        """The solution under random symmetries: numbers for parameters, shifts, other names."""
        made = Draft(draw)
        solutions = [part.split("=", 1) for part in self.solutions.split(";;")]
        names = tuple(left.strip() for left, _ in solutions)
        made.solutions = {left.strip(): read(right) for left, right in solutions}
        made.equations = [read(part, names) for part in self.equations.split(";;")]
        for text in self.letters.split():
            made.letter(text)
        return transformed(made)


def transformed(made: Draft) -> Draft:
    """The draft with parameters chosen or put otherwise, variables shifted, unknowns scaled."""
    draw = made.draw
    for letter in list(made.letters.values()):
        if letter.name in VARIABLES:
            _move(made, letter)
        else:
            _choose(made, letter)
    if len(made.solutions) > 1 and draw.random() < 0.25:
        _mix(made)
    elif draw.random() < 0.15:
        _scale(made)
    return renamed(made) if draw.random() < 0.3 else made


def _move(made: Draft, letter: Letter) -> None:
    """A shift of a variable that the equations do not hold, or a smaller range of it."""
    draw = made.draw
    explicit = {own for equation in made.equations for own in equation.names()}
    free = letter.low is None and letter.high is None
    if free and letter.name not in explicit and draw.random() < 0.15:
        step = as_tree(draw.choice(SMALL)) if letter.integer else made.number()
        image = {letter.name: name(letter.name) + step}
        made.solutions = {u: put(f, image) for u, f in made.solutions.items()}
    elif free and draw.random() < 0.15:
        low, high = draw.choice(((0, None), (None, 0), (-1, 2), (1, 3), (None, 5)))
        ends = (
            None if low is None else Fraction(low),
            None if high is None else Fraction(high + 3 * letter.integer),
        )
        made.letters[letter.name] = Letter(letter.name, ends[0], ends[1], letter.integer)


def _choose(made: Draft, letter: Letter) -> None:
    """A number for a parameter, a formula in another, or a smaller range."""
    draw, chance = made.draw, made.draw.random()
    own = name(letter.name)
    if chance < 0.45:
        image: Tree = as_tree(_plain_number(letter, draw))
        del made.letters[letter.name]
    elif chance < 0.6:
        image = _other_formula(letter, own, draw)
        if draw.random() < 0.4:
            fresh = f"{letter.name}0"
            made.definitions[fresh] = image
            image = name(fresh)
    elif chance < 0.7 and letter.low is None and letter.high is None:
        end = Fraction(draw.choice((0, 0, 1)))
        ends = draw.choice(((end, None), (None, end), (end - 1, end + 2)))
        made.letters[letter.name] = Letter(letter.name, ends[0], ends[1])
        return
    elif chance < 0.76 and letter.low == 0 and letter.high is None:
        stay_under(made, letter.name)
        return
    else:
        return
    _put_everywhere(made, {letter.name: image})


def stay_under(made: Draft, own: str) -> Tree:
    """The difference, from now on positive, of a new parameter and a positive one."""
    most = Letter(f"{own}1", Fraction(0))
    rest = {key: letter for key, letter in made.letters.items() if key != own}
    made.letters = {most.name: most, **rest, own: Letter(own, Fraction(0), under=most.name)}
    return name(most.name) - name(own)


def _put_everywhere(made: Draft, images: Mapping[str, Tree]) -> None:
    made.equations = [put(equation, images) for equation in made.equations]
    made.solutions = {u: put(f, images) for u, f in made.solutions.items()}


def _plain_number(letter: Letter, draw: random.Random) -> Fraction:
    choices = [Fraction(p, q) for p in (1, 2, 3, -1, -2, 4, 5, 0) for q in (1, 2, 3, 5)]
    fitting = [c for c in choices if letter.holds(c) and c != 0]
    return draw.choice(fitting) if fitting else letter.number(draw)


def _other_formula(letter: Letter, own: Tree, draw: random.Random) -> Tree:
    """A formula in the parameter with values in the same range."""
    if letter.low is None and letter.high is None:
        return draw.choice((own - 1, own * 2, -own, own**2 + own))
    if letter.low == 0 and letter.high is None:
        return draw.choice((own**2, own * 2, own / (own + 1), call("sqrt", own), own + 1))
    if letter.low == 0 and letter.high == 1:
        return draw.choice((own**2, ONE - own, own / 2))
    return -own if letter.low is not None and letter.low == -(letter.high or 0) else own


def _scale(made: Draft) -> None:
    """One unknown times a number."""
    unknown = made.draw.choice(sorted(made.solutions))
    factor = made.number()
    made.solutions[unknown] = factor * made.solutions[unknown]
    made.equations = [with_jets(e, {unknown: {unknown: ONE / factor}}) for e in made.equations]


def _mix(made: Draft) -> None:
    """One unknown plus a multiple of another in its place."""
    first, second = made.draw.sample(sorted(made.solutions), 2)
    factor = made.number()
    made.solutions[first] = made.solutions[first] + factor * made.solutions[second]
    images = {first: {first: ONE, second: -factor}}
    made.equations = [with_jets(equation, images) for equation in made.equations]


def with_jets(tree: Tree, images: Mapping[str, Mapping[str, Tree]]) -> Tree:
    """The equation with linear combinations of unknowns in the places of some."""

    def image(node: Tree) -> Tree | None:
        if node.head != "jet" or node.jet[0] not in images:
            return None
        _, steps, shift = node.jet
        parts = images[node.jet[0]].items()
        return total(*(c * Tree("jet", value=(unknown, steps, shift)) for unknown, c in parts))

    return mapped(tree, image)


def renamed(made: Draft) -> Draft:
    """The draft with other names of its parameters."""
    own = [key for key in made.letters if key not in VARIABLES]
    taken = {*made.letters, *made.definitions, *made.solutions}
    taken = {key.lower() for key in taken}
    free = [fresh for fresh in NAMES if fresh.lower() not in taken and fresh not in made.solutions]
    chosen = dict(zip(own, made.draw.sample(free, len(own)), strict=True))
    if len({fresh.lower() for fresh in chosen.values()}) < len(chosen):
        return made
    _put_everywhere(made, {key: name(fresh) for key, fresh in chosen.items()})
    images = {key: name(fresh) for key, fresh in chosen.items()}
    made.definitions = {key: put(tree, images) for key, tree in made.definitions.items()}
    made.letters = {
        chosen.get(key, key): replace(
            letter, name=chosen.get(key, key), under=chosen.get(letter.under, letter.under)
        )
        for key, letter in made.letters.items()
    }
    return made


# random formulas


PIECES = (
    *("exp({0})", "sin({0})", "cos({0})", "tanh({0})", "sech({0})", "sinh({0})", "cosh({0})"),
    *("{0}**2", "{0}", "1/(1 + ({0})**2)", "sqrt(1 + ({0})**2)", "log(1 + ({0})**2)", "atan({0})"),
    *("exp({0})", "sin({0})", "({0})**3", "tan({0})", "log(2 + cos({0}))", "exp(-({0})**2)"),
)


def random_phase(made: Draft, variables: str, parameters: Sequence[str]) -> Tree:
    """A linear formula in some of the variables."""
    draw = made.draw
    chosen = draw.sample(variables, draw.randint(1, len(variables)))
    found = total(*(made.constant(parameters) * name(v) for v in chosen))
    return found + made.constant(parameters) if draw.random() < 0.15 else found


def random_formula(made: Draft, variables: str, parameters: Sequence[str]) -> Tree:
    """One or two functions of phases, added or multiplied."""
    draw = made.draw
    pieces = []
    for _ in range(draw.choice((1, 1, 2))):
        piece = read(draw.choice(PIECES).format("Z"))
        pieces.append(put(piece, {"Z": random_phase(made, variables, parameters)}))
    found = pieces[0]
    for piece in pieces[1:]:
        found = draw.choice((found + made.constant(parameters) * piece, found * piece))
    return found


def random_parameters(made: Draft, most: int = 2) -> list[str]:
    """Up to so many parameters with random ranges."""
    own = made.draw.sample(("a", "b", "c", "k"), made.draw.randint(0, most))
    for key in own:
        made.letter(key + made.draw.choice(("", ">0", "<0", ":-1:1", ":1/2:3")))
    return own
