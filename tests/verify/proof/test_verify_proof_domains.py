"""Verdicts on whole domains: both signs, branches, cuts; an unknown value is never taken as 0."""

from dataclasses import replace
from pathlib import Path

import pytest
import sympy as sp

from longwave.solutions import CATALOGUE, ClosedForm
from longwave.solutions.functions import jacobi_dn
from longwave.solutions.record import Bound
from longwave.verify.proof import Domain, ProofVerdict, form_domains, prove, prove_equal, prover
from longwave.verify.proof.domains import settled_domains
from longwave.verify.proof.problem import equality_problem
from longwave.verify.proof.prover import find_witness
from longwave.verify.proof.samples import sample
from longwave.verify.verdict import Outcome

x, t, a, b = sp.symbols("x t a b", real=True)
q = sp.Symbol("q", negative=True)
u = sp.Function("u")(x, t)
POSITIVE = sp.Interval.open(0, sp.oo)
TINY = sp.Rational(1, 10**60)


def outcome(equation: sp.Expr, formula: sp.Expr, **domains: sp.Interval) -> Outcome:
    stated = {sp.Symbol(name): interval for name, interval in domains.items()}
    return prove(equation, formula, domains=stated).outcome


def test_a_part_in_ten_to_the_sixty_is_refuted() -> None:
    assert outcome(u.diff(x) - t * u, sp.exp(x * t)) is Outcome.PROVED
    assert outcome(u.diff(x) - (1 + TINY) * t * u, sp.exp(x * t)) is Outcome.REFUTED


def test_the_heat_kernel_is_proved_and_its_branch_point_named() -> None:
    kernel = sp.exp(-(x**2) / (4 * t)) / sp.sqrt(t)
    heat = u.diff(t) - u.diff(x, 2)
    verdict = prove(heat, kernel)
    assert verdict.outcome is Outcome.PROVED
    assert "branch point where t is not positive" in verdict.singularities
    assert any("t is not positive" in line for line in verdict.assumptions)
    assert prove(heat, kernel, domains={t: POSITIVE}).singularities == ()


ABSOLUTE = [sp.sqrt(sp.Symbol("x") ** 2), sp.sqrt(x**2), sp.Abs(x), sp.sqrt(x**4) / sp.Abs(x)]


@pytest.mark.parametrize("size", ABSOLUTE, ids=str)
def test_the_root_of_a_square_is_the_absolute_value(size: sp.Expr) -> None:
    slope = sp.Function("u")(sp.Symbol("x")) if size.has(sp.Symbol("x")) else u
    variable = slope.args[0]
    equation = slope.diff(variable) - 1
    verdict = prove(equation, size)
    assert verdict.outcome is Outcome.REFUTED
    assert verdict.witness is not None
    assert sp.Rational(verdict.witness["x"]) < 0
    assert prove(equation, size, domains={variable: POSITIVE}).outcome is Outcome.PROVED


def test_the_root_of_a_product_is_that_of_its_factors_where_one_is_positive() -> None:
    sides = sp.sqrt(a * b), sp.sqrt(a) * sp.sqrt(b)
    assert prove_equal(*sides, [x]).outcome is Outcome.REFUTED
    assert prove_equal(*sides, [x], domains={a: POSITIVE, b: POSITIVE}).outcome is Outcome.PROVED


def test_a_declared_sign_is_the_sign_of_the_samples() -> None:
    root = sp.sqrt(q**2 - 2 * q**3 + q**4)
    assert prove_equal(root, -q * (1 - q), [x]).outcome is Outcome.PROVED
    wrong = prove_equal(root, q * (1 - q), [x])
    assert wrong.outcome is Outcome.REFUTED
    assert wrong.witness is not None
    assert sp.Rational(wrong.witness["q"]) < 0


SIDES = {
    "log of a product": (sp.log(a * b), sp.log(a) + sp.log(b), {a: POSITIVE, b: POSITIVE}),
    "log of a square": (sp.log(x**2), 2 * sp.log(x), {x: POSITIVE}),
    "hyperbolic root": (sp.sqrt(sp.cosh(x) ** 2 - 1), sp.sinh(x), {x: POSITIVE}),
    "root of a sum": (sp.sqrt(x**2 - 4 * x + 4), x - 2, {x: sp.Interval(3, sp.oo)}),
    "cube root": ((x**3) ** sp.Rational(1, 3), x, {x: POSITIVE}),
    "absolute value": (sp.Abs(x**3 - x), x - x**3, {x: sp.Interval.open(0, 1)}),
    "conjugate": (sp.conjugate(sp.sqrt(x)), sp.sqrt(x), {x: POSITIVE}),
    "sign": (sp.sign(x - 1), -sp.S.One, {x: sp.Interval.open(-3, 1)}),
}


@pytest.mark.parametrize("name", SIDES)
def test_an_identity_holds_on_its_domain_only(name: str) -> None:
    left, right, domains = SIDES[name]
    assert prove_equal(left, right, [x], domains=domains).outcome is Outcome.PROVED
    assert prove_equal(left, right, [x]).outcome is Outcome.REFUTED


def test_a_denominator_that_vanishes_on_half_of_the_domain_is_named() -> None:
    undefined = 1 / (sp.sqrt(x**2) - x)
    verdict = prove_equal(undefined, undefined + 0 * t, [x])
    assert verdict.outcome is not Outcome.REFUTED
    if verdict.outcome is Outcome.PROVED:
        assert any("pole where" in line for line in verdict.singularities)


def test_a_point_on_a_cut_is_no_witness() -> None:
    """The root jumps where its argument crosses the negative axis, at b = 0."""
    root = sp.sqrt(-1 - x**2 + sp.I * b)
    at_cut = {x: sp.S.One, b: sp.S.Zero}
    problem = equality_problem(root, root * sp.sign(b) ** 2, [x])
    assert find_witness(problem, [at_cut]) is None
    assert prover.decide(problem).outcome is not Outcome.REFUTED


def test_bare_symbols_are_real_and_one_name_is_one_symbol() -> None:
    bare = sp.Symbol("y")
    assert prove_equal(sp.conjugate(sp.exp(sp.I * bare)), sp.exp(-sp.I * bare), [bare]).passed
    with pytest.raises(ValueError, match="must differ in name, got two called x"):
        prove_equal(sp.Symbol("x") + x, x, [x])
    with pytest.raises(ValueError, match="must be real, got z"):
        prove_equal(sp.Symbol("z", complex=True), x, [x])


def test_domains_that_are_none_are_refused() -> None:
    for domain, words in (
        (Domain(sp.S.One, sp.S.One), "more than one point"),
        (Domain(sp.I, sp.S.One), "real or infinite"),
        (sp.FiniteSet(1, 2), "must be intervals"),
    ):
        with pytest.raises(ValueError, match=words):
            prove_equal(a, a, [x], domains={a: domain})
    with pytest.raises(ValueError, match="more than one point"):
        prove_equal(q, q, [x], domains={q: POSITIVE})


def test_an_end_may_be_a_real_constant() -> None:
    found = prove_equal(sp.Abs(a), a, [x], domains={a: sp.Interval.open(sp.log(2), sp.sqrt(2))})
    assert found.outcome == "PROVED"
    found = prove_equal(sp.Abs(a), a, [x], domains={a: sp.Interval.open(sp.log(sp.S.Half), 1)})
    assert found.outcome == "REFUTED"


def test_samples_have_both_signs_all_sizes_and_stay_inside() -> None:
    k, n = sp.symbols("k n")
    stated = {k: sp.Interval.open(0, 1), n: Domain(integer=True, nonzero=True)}
    domains = settled_domains([a, b, q, k, n], stated)
    points = sample(domains, 60)
    assert len({(p[a] > 0, p[b] > 0) for p in points[:8]}) == 4
    assert all(p[q] < 0 < p[k] < 1 and p[n].is_Integer and p[n] != 0 for p in points)
    assert max(abs(p[a]) for p in points) > 100 > 1 / 100 > min(abs(p[a]) for p in points)
    assert max(p[k] for p in points) > sp.Rational(99, 100)
    assert points == sample(domains, 60)


@pytest.mark.parametrize("form", CATALOGUE, ids=lambda form: form.name)
def test_the_domains_of_a_form_are_those_of_its_record(form: ClosedForm) -> None:
    domains = settled_domains(form.expression.free_symbols, form_domains(form))
    for point in sample(domains, 12):
        form.check({p.name: point[p.symbol] for p in form.parameters if p.symbol in point})


def test_a_linear_form_of_the_equation_alone_is_no_zero() -> None:
    """The variable t is in the equation and in the slope of exp(x t), not in the formula's sums."""
    verdict: ProofVerdict = prove(u.diff(x) - u - t * (x - x + t - t + 1) * u * TINY, sp.exp(x))
    assert verdict.outcome is Outcome.REFUTED


def test_bad_input_is_an_error_on_one_line() -> None:
    field = sp.Function("u")
    equation = field(x, t).diff(x)
    for wrong in ("x", None, 0.5):
        with pytest.raises(TypeError, match="must be a SymPy expression"):
            prove(equation, wrong)
    for unknown in (field(x + 1, t), field(x, x), field(sp.S.One)):
        with pytest.raises(ValueError, match="function of different symbols"):
            prove(unknown - x, x)
    with pytest.raises(TypeError, match="equation must be"):
        prove(sp.Eq(field(x, t), 1), x)
    assert prove(equation, 3).outcome is Outcome.PROVED


TEXT = {
    "formula": lambda text: prove(u.diff(x), text),
    "equation": lambda text: prove(text, x),
    "side": lambda text: prove_equal(x, text, [x]),
    "variable": lambda text: prove_equal(x, x, [text]),
    "end": lambda text: prove(u.diff(x), t, domains={x: Domain(upper=text)}),
    "domain": lambda text: prove(u.diff(x), t, domains={x: text}),
    "symbol of a domain": lambda text: prove(u.diff(x), t, domains={text: POSITIVE}),
    "bound of a form": lambda text: form_domains(_form_bounded_by(text)),
}


def _form_bounded_by(text: str) -> ClosedForm:
    form = next(form for form in CATALOGUE if form.parameters)
    changed = replace(form.parameters[0], upper=Bound(text, "none"))  # type: ignore[arg-type]
    return replace(form, parameters=(changed,))


@pytest.mark.parametrize("place", TEXT)
def test_text_is_refused_and_never_evaluated(place: str, tmp_path: Path) -> None:
    witness = tmp_path / "evaluated"
    with pytest.raises((TypeError, ValueError), match="must") as caught:
        TEXT[place](f"__import__('pathlib').Path({str(witness)!r}).touch()")
    assert not witness.exists()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("odd", [sp.nan, sp.zoo, sp.Float("0.5") * x, sp.Function("f")(x)], ids=str)
def test_what_is_no_formula_is_undecided(odd: sp.Expr) -> None:
    assert prove_equal(odd, x, [x]).outcome is Outcome.UNDECIDED


def test_a_false_equality_of_constants_is_refuted() -> None:
    verdict = prove_equal(sp.I, -sp.I, [x])
    assert verdict.outcome is Outcome.REFUTED
    assert verdict.witness == {}


def test_an_empty_domain_of_integers_is_refused() -> None:
    n = sp.Symbol("n", integer=True)
    with pytest.raises(ValueError, match="must hold rational points"):
        prove_equal(n, n, [x], domains={n: sp.Interval.open(0, 1)})


DN = jacobi_dn(x, sp.Symbol("m", real=True))
BELOW_ONE = {
    "K is real": (sp.conjugate(sp.elliptic_k(DN.args[1])), sp.elliptic_k(DN.args[1])),
    "dn is positive": (sp.sqrt(sp.expand((DN + DN**3) ** 2)), DN + DN**3),
}


@pytest.mark.parametrize("name", BELOW_ONE)
def test_what_needs_a_parameter_below_one_is_not_proved_just_beyond(name: str) -> None:
    parameter = DN.args[1]
    ends = {parameter: sp.Interval.open(0, 1)}
    assert prove_equal(*BELOW_ONE[name], [x], domains=ends).outcome is Outcome.PROVED
    beyond = {parameter: sp.Interval.open(sp.S.Half, 1 + TINY)}
    assert prove_equal(*BELOW_ONE[name], [x], domains=beyond).outcome is not Outcome.PROVED


MOVING = x**2 / (1 + x**2)
COMPLETE = [sp.elliptic_k(MOVING), sp.elliptic_e(MOVING), sp.tanh(sp.elliptic_k(x))]


@pytest.mark.parametrize("formula", COMPLETE, ids=str)
def test_an_elliptic_parameter_that_moves_is_not_held_fixed(formula: sp.Expr) -> None:
    half = {x: sp.Interval.open(0, sp.S.Half)}
    verdict = prove(u.diff(x) - sp.diff(formula, x), formula, domains=half)
    assert verdict.outcome is Outcome.UNDECIDED
    assert "constant" in verdict.detail
    assert prove_equal(formula, formula + TINY, [x], domains=half).outcome is Outcome.REFUTED


def test_the_slope_of_dn_in_a_parameter_that_moves_is_not_taken_for_0() -> None:
    assert prove(u.diff(x) - x, jacobi_dn(t, MOVING)).outcome is Outcome.UNDECIDED


def test_a_formula_that_is_nested_too_deeply_is_undecided() -> None:
    deep = x
    for _ in range(120):
        deep = sp.exp(-deep) + t
    verdict = prove_equal(deep, deep + sp.sin(x) ** 2 + sp.cos(x) ** 2 - 1, [x])
    assert verdict.outcome is Outcome.UNDECIDED
    assert "recursion" in verdict.detail


def test_a_function_of_the_same_function_is_told_from_it() -> None:
    """Catches: endless recursion for exp(exp(2 log x) - 1), comparing the inner and outer exp."""
    log = sp.log(x, evaluate=False)
    square = sp.exp(2 * log, evaluate=False)
    nested = sp.exp(square - 1, evaluate=False)
    assert prove_equal(nested, sp.exp(x**2 - 1), [x]).outcome is Outcome.PROVED
    assert prove_equal(nested, sp.exp(x**2 + 1), [x]).outcome is Outcome.REFUTED


def test_a_square_with_a_minus_before_it_has_a_root() -> None:
    root, turned = sp.sqrt(x**2 + x + sp.Rational(1, 4)), sp.sqrt(-(x**2) - x - sp.Rational(1, 4))
    assert prove_equal(root, -sp.I * turned, [x]).outcome is Outcome.PROVED
    assert prove_equal(root, sp.I * turned, [x]).outcome is Outcome.REFUTED


KINDS = {
    "even": lambda n: sp.sin(sp.pi * n / 4) * sp.cos(sp.pi * n / 4),
    "odd": lambda n: sp.cos(sp.pi * n / 4) ** 2 - sp.S.Half,
    "prime": lambda n: sp.sin(sp.pi * (n**2 - 1) * (n - 2) * (n - 3) / 24),
    "extended_positive": lambda s: sp.sqrt(sp.expand((s + 1) ** 2)) - s - 1,
    "positive": lambda s: sp.sqrt(sp.expand((s - 1) ** 2)) + s - 1,
}


@pytest.mark.parametrize("kind", KINDS)
def test_an_assumption_that_no_sample_keeps_is_refused(kind: str) -> None:
    """Catches: sin(pi n/4) cos(pi n/4), which is 0 for even n, refuted at n = -5."""
    symbol = sp.Symbol("n", **{kind: kind != "positive"})
    with pytest.raises(ValueError, match=f"got n with .*{kind[:4]}|got n with composite"):
        prove_equal(x * KINDS[kind](symbol), sp.S.Zero, [x])


@pytest.mark.parametrize("end", [sp.sqrt(t), sp.log(t), sp.elliptic_k(t**2), sp.I * t], ids=str)
def test_an_end_that_is_not_real_throughout_is_refused_on_one_line(end: sp.Expr) -> None:
    with pytest.raises(ValueError, match="ends of domains must be real") as caught:
        prove_equal(sp.Abs(x - 1), x - 1, [x], domains={x: Domain(lower=end)})
    assert "\n" not in str(caught.value)
