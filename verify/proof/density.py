"""No denominator of a proof vanishes on a whole piece of the domains.

A proof divides; it holds where no denominator is 0.  If those points are dense, it holds by
continuity wherever the formula is smooth.  A formula without branch points that is not 0 at one
point is not 0 on a dense set; roots with branch points are tried in all their branches, and for
what is left the domain is cut into boxes without branch points.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import sympy as sp
from flint import acb, ctx, fmpq_mpoly

from .algebra import DifferentialField
from .balls import Point
from .branches import Branches, cells
from .compilation import BITS, generator_balls, polynomial_ball, regular_point
from .domain import Domains
from .samples import sample
from .signs import Signs

CONJUGATES = 64
TRIES = 4
SHOWN_TERMS = 8

NO_REGULAR_POINT = "no point was found at which every denominator is shown not to vanish"


class Density:
    """Decides where the denominators of ``field`` are not 0.

    ``parts`` says what the symbols stand for that are neither variables nor parameters.
    """

    def __init__(
        self,
        field: DifferentialField,
        domains: Domains,
        points: Sequence[Point],
        parts: Mapping[sp.Expr, sp.Expr] | None = None,
    ) -> None:
        self.field, self.domains, self.points = field, domains, points
        self.parts = parts or {}
        self.signs = field.translation.rewriting.signs
        self.meanings = [g.meaning.xreplace(dict(self.parts)) for g in field.generators]
        branches = Branches(self.signs)
        self.branched = {i for i, m in enumerate(self.meanings) if not branches.is_free(m)}
        self.relations = {r.generator: r for r in field.ring.relations}

    def point(self) -> Point | None:
        """A point where no denominator vanishes, as balls show; None if none is found."""
        return regular_point(self.field, self.points, self.parts)

    def obstacle(self) -> str | None:
        """A denominator that may vanish on a piece of the domains, in words; None if none does."""
        if not self.branched:
            return None
        for factor in self.field.ring.factors:
            if self._generators(factor) & self.branched and not self._is_dense(factor):
                return (
                    f"{self._words(factor)} is not shown to be different from 0 on every part "
                    "of the domain"
                )
        return None

    def _is_dense(self, factor: fmpq_mpoly) -> bool:
        if len(factor) <= SHOWN_TERMS and self.signs.is_nonzero(self.field.written(factor)):
            return True
        return self._in_all_branches(factor) or self._in_all_cells(factor)

    def _generators(self, polynomial: fmpq_mpoly) -> set[int]:
        """The generators in ``polynomial`` and, of those with branches, in their relations."""
        found: set[int] = set()
        waiting = [polynomial]
        while waiting:
            degrees = waiting.pop().degrees()[::-1]
            new = {i for i, degree in enumerate(degrees) if degree} - found
            found |= new
            waiting += [self.relations[i].value for i in new & self.branched & set(self.relations)]
        return found

    def _in_all_branches(self, factor: fmpq_mpoly) -> bool:
        """Whether the factor is not 0 at a point, whatever branch each root has there."""
        roots = sorted(self._generators(factor) & self.branched)
        if not all(i in self.relations for i in roots):
            return False
        degrees = [self.relations[i].degree for i in roots]
        if sp.Mul(*degrees) > CONJUGATES:
            return False
        return any(self._differs(factor, roots, point) for point in self.points[:TRIES])

    def _differs(self, factor: fmpq_mpoly, roots: Sequence[int], point: Point) -> bool:
        with ctx.workprec(BITS):
            try:
                values = generator_balls(self.field, point, self.parts)
            except ValueError:
                return False
            turns = [range(self.relations[i].degree) for i in roots]
            return all(
                _excludes_zero(polynomial_ball(factor, self._turned(values, roots, choice)))
                for choice in itertools.product(*turns)
            )

    def _turned(
        self, values: Sequence[acb], roots: Sequence[int], choice: Sequence[int]
    ) -> list[acb]:
        """The values with another branch for each of ``roots``, the earlier ones first."""
        found = list(values)
        for i, turn in zip(roots, choice, strict=True):
            relation = self.relations[i]
            unit = (acb(0, 1) * acb.pi() * 2 * turn / relation.degree).exp()
            found[i] = unit * polynomial_ball(relation.value, found).root(relation.degree)
        return found

    def _in_all_cells(self, factor: fmpq_mpoly) -> bool:
        """Whether the factor is not 0 at a point of each of some boxes without branch points."""
        used = [self.meanings[i] for i in sorted(self._generators(factor))]
        boxes = list(cells(self.domains, used))
        return bool(boxes) and all(self._in_cell(factor, used, box) for box in boxes)

    def _in_cell(self, factor: fmpq_mpoly, used: Sequence[sp.Expr], box: Domains) -> bool:
        branches = Branches(Signs(box))
        if not all(map(branches.is_free, used)):
            return False
        with ctx.workprec(BITS):
            for point in sample(box, TRIES):
                try:
                    values = generator_balls(self.field, point, self.parts)
                except ValueError:
                    continue
                if _excludes_zero(polynomial_ball(factor, values)):
                    return True
        return False

    def _words(self, factor: fmpq_mpoly) -> str:
        if len(factor) > SHOWN_TERMS:
            return f"a denominator of {len(factor)} terms"
        return f"the denominator {self.field.written(factor)}"


def _excludes_zero(ball: acb) -> bool:
    return bool(ball.is_finite() and not ball.contains(0))
