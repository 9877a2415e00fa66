"""Random points: admissible, exact, reproducible."""

import pytest
import sympy as sp

from longwave.solutions.catalogue import CATALOGUE, closed_form
from longwave.solutions.record import ClosedForm
from longwave.verify.evidence.residual import HALF_WIDTH, sample_points
from longwave.verify.proof.domains import Domain, in_order


@pytest.mark.parametrize("form", CATALOGUE, ids=lambda form: form.name)
def test_points_are_admissible_rationals(form: ClosedForm) -> None:
    names = {parameter.symbol for parameter in form.parameters}
    for point in sample_points(form, 20, seed=3):
        assert all(value.is_Rational for value in point.values())
        form.check({symbol.name: value for symbol, value in point.items() if symbol in names})
        assert abs(point[form.equation.xi]) < HALF_WIDTH > abs(point[form.equation.tau])


def test_the_seed_fixes_the_points() -> None:
    form = closed_form("breather_sn")
    assert sample_points(form, 5, seed=1) == sample_points(form, 5, seed=1)
    assert sample_points(form, 5, seed=1) != sample_points(form, 5, seed=2)


def test_points_differ_from_each_other_in_every_coordinate() -> None:
    points = sample_points(closed_form("breather_sn"), 10, seed=0)
    for symbol in points[0]:
        assert len({point[symbol] for point in points}) > 5


def test_a_parameter_comes_after_those_in_its_bounds() -> None:
    p, q = sp.symbols("p q", positive=True)
    assert in_order({q: Domain(sp.S.Zero, 2 * p), p: Domain(sp.S.Zero)}) == [p, q]


def test_bounds_that_depend_on_each_other_are_refused() -> None:
    p, q = sp.symbols("p q", positive=True)
    with pytest.raises(ValueError, match="must not depend on each other"):
        in_order({p: Domain(q), q: Domain(p)})
