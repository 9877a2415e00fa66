"""Constants for which a statement holds: known answers, none missed, each case proved."""

import pytest
import sympy as sp

from longwave.verify.proof import check_certificate
from longwave.verify.proof.conditions import ConditionalVerdict, conditional_sentence
from longwave.verify.proof.statement_text import FormulaError, read_statement
from longwave.verify.proof.text_prover import prove

KDV, MKDV = "u_t + 6*u*u_x + u_xxx", "u_t + 6*u**2*u_x + u_xxx"
NLS = "I*u_t + u_xx + 2*abs(u)**2*u"
LADDER = "I*diff(u[n], t) + (1 + abs(u[n])**2)*(u[n+1] + u[n-1]) - 2*u[n]"
TODA = "diff(q[n], t, t) - exp(q[n-1] - q[n]) + exp(q[n] - q[n+1])"
PHASES = "1 + exp(k*x - k**3*t) + exp(l*x - l**3*t) + A*exp(k*x - k**3*t + l*x - l**3*t)"
TANH, ELLIPTIC = "tanh(k*(x - c*t))", "a*jacobi_dn(x - c*t, m) + b*sqrt(m)*jacobi_cn(x - c*t, m)"

BRIGHT = "u = a*sech(k*(x - c*t))*exp(I*(p*x - w*t))"
BURGERS_KDV = "u_t + u*u_x - nu*u_xx + b*u_xxx"
KURAMOTO = "u_t + u*u_x + u_xx + u_xxxx"
CUBE = f"u = a0 + a1*{TANH} + a2*{TANH}**2 + a3*{TANH}**3"


def solved(
    equation: str, solution: str, parameters: str, solve: str, domain: str = ""
) -> ConditionalVerdict:
    found = prove(equation, solution, parameters=parameters, domain=domain, solve=solve)
    assert isinstance(found, ConditionalVerdict)
    return found


def cases(verdict: ConditionalVerdict) -> list[set[str]]:
    """Return the nontrivial cases in words."""
    return [
        {f"{s} = {value}" for s, value in case.values.items()}
        for case in verdict.cases
        if not case.trivial
    ]


ANSWERS = [
    (KDV, f"u = a*(1 - {TANH}**2)", "k: k>0", "a, c", ["a = 2*k**2; c = 4*k**2"]),
    (
        BURGERS_KDV,
        f"u = a0 + a1*{TANH} + a2*{TANH}**2",
        "b: b>0; nu: nu>0; k: k>0",
        "c, a1, a2, k",
        [
            "c = (25*a0*b - 3*nu**2)/(25*b); a1 = -6*nu**2/(25*b); a2 = -3*nu**2/(25*b); "
            "k = nu/(10*b)"
        ],
    ),
    (
        MKDV,
        f"u = {ELLIPTIC}",
        "m: 0<m<1; a: a>0; b: b!=0",
        "a, b, c",
        ["a = 1/2; b = 1/2; c = (m + 1)/2", "a = 1/2; b = -1/2; c = (m + 1)/2"],
    ),
    pytest.param(
        LADDER,
        "u[n] = a*jacobi_dn(b*n + d, m)*exp(-I*w*t)",
        "m: 0<m<1; b: b>0",
        "a, w",
        [
            f"a = {sign}jacobi_sn(b, m)/jacobi_cn(b, m); "
            "w = 2 - 2*jacobi_dn(b, m)/jacobi_cn(b, m)**2"
            for sign in ("", "-")
        ],
        marks=pytest.mark.slow,
    ),
    (
        LADDER,
        "u[n] = a*sech(b*(n - v*t))*exp(I*(p*n - w*t))",
        "b: b>0; a: a>0",
        "a, w, v",
        ["a = sinh(b); w = -exp(b)*cos(p) + 2 - exp(-b)*cos(p); v = 2*sin(p)*sinh(b)/b"],
    ),
    (
        "u_t - u_xx - u*(1 - u)",
        "u = 1/(1 + a*exp(k*(x - c*t)))**2",
        "a: a>0; k: k>0",
        "k, c",
        ["k = sqrt(6)/6; c = 5*sqrt(6)/6"],
    ),
    pytest.param(
        KDV,
        f"u = 2*diff(log({PHASES}), x, x)",
        "k: k>0; l: l>k",
        "A",
        ["A = (k - l)**2/(k + l)**2"],
        marks=pytest.mark.slow,
    ),
    (
        KDV,
        "u = a0 + a1*exp(l*(x - c*t))/(1 + exp(l*(x - c*t)))"
        " + a2*exp(2*l*(x - c*t))/(1 + exp(l*(x - c*t)))**2",
        "l: l>0",
        "a0, a1, a2",
        ["a0 = (c - l**2)/6; a1 = 2*l**2; a2 = -2*l**2"],
    ),
    (
        "u_tt - u_xx - 3*diff(u**2, x, x) - u_xxxx",
        "u = a*sech(k*(x - c*t))**2",
        "k: k>0; c: c>0",
        "a, c",
        ["a = 2*k**2; c = sqrt(4*k**2 + 1)"],
    ),
    ("u_t + u*u_x - nu*u_xx", f"u = a + b*{TANH}", "k: k>0", "b, c", ["b = -2*k*nu; c = a"]),
    (
        KURAMOTO,
        CUBE,
        "k: k>0",
        "c, a1, a2, a3, k",
        [
            "c = a0; a1 = -135*sqrt(209)/361; a2 = 0; a3 = 165*sqrt(209)/361; k = sqrt(209)/38",
        ],
    ),
    (NLS, BRIGHT, "k: k>0; a: a>0", "a, w, c", ["a = k; w = (-k + p)*(k + p); c = 2*p"]),
    (
        "u_tt - u_xx - u + u**3",
        f"u = a*{TANH}",
        "c: -1<c<1; a: a>0; k: k>0",
        "a, k",
        ["a = 1; k = 1/sqrt(2 - 2*c**2)"],
    ),
    (
        "u_xt + 6*diff(u*u_x, x) + u_xxxx + 3*u_yy",
        "u = a*sech(k*x + l*y - w*t)**2",
        "k: k>0; a: a!=0",
        "a, w",
        ["a = 2*k**2; w = (4*k**4 + 3*l**2)/k"],
    ),
    (
        "u_t + u*u_x + v_x ;; v_t + diff(u*v, x)",
        "u = a*x/t ;; v = b*x**2/t**2",
        "b: b!=0",
        "a, b",
        ["a = 2/3; b = 1/9"],
    ),
    pytest.param(
        TODA,
        "q[n] = log((1 + exp(2*k*(n-1) - 2*b*t))/(1 + exp(2*k*n - 2*b*t)))",
        "k: k>0; b: b>0",
        "b",
        ["b = sinh(k)"],
        marks=pytest.mark.slow,
    ),
    ("u_t - u_xx", "u = t**a*exp(-b*x**2/t)", "b: b>0", "a, b", ["a = -1/2; b = 1/4"]),
    (KDV, "u = 2*diff(log(x**3 + a*t), x, x)", "", "a", ["a = 12"]),
    (
        "u_t + u_xxx/2",
        "u = exp(k*x - w*t)",
        "k: k!=0",
        "w",
        ["w = k**3/2"],
    ),
    (
        "u_tt - u_xx + sin(u)",
        "u = 4*atan(exp(k*(x - c*t)))",
        "c: -1<c<1; k: k>0",
        "k",
        ["k = 1/sqrt(1 - c**2)"],
    ),
]


@pytest.mark.parametrize(("equation", "solution", "parameters", "solve", "expected"), ANSWERS)
def test_the_cases_are_those_of_the_literature_and_proved(
    equation: str, solution: str, parameters: str, solve: str, expected: list[str]
) -> None:
    verdict = solved(equation, solution, parameters, solve)
    assert cases(verdict) == [set(text.split("; ")) for text in expected]
    assert verdict.complete
    assert verdict.outcome == "PROVED"
    assert all(case.proved for case in verdict.cases)
    for certificate in verdict.certificates:
        check_certificate(certificate)


def test_the_condition_may_be_on_a_constant_that_was_not_asked_for() -> None:
    verdict = solved(KDV, "u = a*sech(x - c*t)**2", "a: a>0", "c")
    assert verdict.detail == "holds if and only if c = 4, a = 2"


def test_what_holds_always_or_never_is_said() -> None:
    always = solved("u_t + c*u_x", "u = a*exp(x - c*t) + b*sin(x - c*t)", "", "a, b")
    assert always.detail == "holds for all values of a, b"
    assert (always.outcome, always.complete) == ("PROVED", True)
    never = solved("u_t + u*u_x + u_xxx", "u = x + a*t", "", "a")
    assert never.detail == "holds for no value of a"
    assert never.outcome == "REFUTED"
    assert never.witness


def test_domains_cut_the_cases() -> None:
    kdv = "u = a*sech(x - c*t)**2"
    assert solved(KDV, kdv, "a: a<0; c: c<0", "a, c").detail == "holds for no value of a, c"
    cn = solved(MKDV, "u = a*jacobi_cn(x - c*t, m)", "a: a>0; c: c<0", "m, a, c")
    assert cn.detail == "holds if and only if m = a**2, c = 2*a**2 - 1 where 2*a**2 - 1 < 0"
    whole = solved("u_t - u_xx", "u = exp(x/j + t/j**2)", "j: integer, j>0", "j")
    assert whole.detail == "holds for all values of j"
    squared = solved(KDV, "u = a*sech(k*(x - c*t))**2", "a: a<0; k: k!=0", "a, c")
    assert squared.detail == "holds for no value of a, c"
    sum_ = solved("u_xx + u_yy + c*u", "u = exp(k*x + l*y)", "c: c>0", "c")
    assert sum_.detail == "holds for no value of c"
    empty = solved("u_x - k", "u = m - x", "k: real; m: 0<m<k", "k")
    assert empty.detail == "holds for no value of k"
    third = solved("u_x - 1", "u = 3*j*x", "j: integer", "j")
    assert third.detail == "holds for no value of j"
    real = solved("u_t + 2*u_xx", "u = exp(k*x + t)", "", "k")
    assert real.detail == "holds for no value of k"
    root = solved(KDV, "u = a*sech(k*(x - c*t))**2", "a: a>0", "k, a")
    assert "a = c/2, k = sqrt(c)/2 where c > 0" in root.detail.replace(
        "k = sqrt(c)/2, a = c/2", "a = c/2, k = sqrt(c)/2"
    )


def test_a_sum_of_squares_vanishes_at_its_vertex() -> None:
    u = "u = x + x*((a - b)**2 + (b - 1)**2)"
    assert cases(solved("u_x - 1", u, "a: real; b: real", "a, b")) == [{"a = 1", "b = 1"}]


def test_where_a_quadratic_is_positive_is_an_interval() -> None:
    verdict = solved("u_x - 1", "u = x + x*(a**2 - (1 - k)*(k + 2))", "a: 0<a; k: real", "a")
    (domain,) = verdict.cases[0].statement.domains.values()
    assert domain.text("k") == "-2 < k < 1"


def test_where_arguments_become_constant_is_a_case_of_its_own() -> None:
    verdict = solved("u_t + u_x", "u = a + b*tanh(k*x - w*t)", "", "w")
    assert "w = k" in verdict.detail
    assert "b = 0 (trivial)" in verdict.detail
    laplace = solved("u_xx + u_yy", "u = exp(k*x + l*y)", "", "k, l")
    assert laplace.detail == "holds if and only if k = 0, l = 0 (trivial)"
    fourth = solved("u_xxxx + u_yyyy", "u = exp(k*x + l*y)", "", "k, l")
    assert fourth.detail == laplace.detail
    power = solved("u_xx - u_x", "u = exp(k*x) + exp(l*x)", "", "k, l")
    values = [tuple(map(str, case.values.values())) for case in power.cases]
    assert set(values) == {("0", "0"), ("0", "1"), ("1", "0"), ("1", "1")}


def test_equal_arguments_are_looked_at() -> None:
    """The terms exp(k x - w t) and exp(l x - v t) cancel if they are the same function."""
    verdict = solved("u_t - u", "u = exp(k*x - w*t) - exp(l*x - v*t)", "", "k, l, w, v")
    assert {"k = l", "w = v"} in [
        {f"{s} = {value}" for s, value in case.values.items()} for case in verdict.cases
    ]


def test_elliptic_functions_at_the_ends_of_their_parameter() -> None:
    verdict = solved("u_xx + c*u", "u = jacobi_sn(x, m)", "", "c, m")
    assert {"c = 1", "m = 0"} in cases(verdict)
    equal = "u = a*jacobi_cn(x, m) + b*jacobi_dn(x, m)"
    sech = solved("u_xx - u + 2*u**3", equal, "m: real", "a, b, m")
    assert {"a = 1 - b", "m = 1"} in cases(sech)
    tanh = solved("u_xx + 2*u - 2*u**3", "u = jacobi_sn(x, m)", "m: 0<m<1", "m")
    assert tanh.detail == "holds for no value of m"
    kink = solved("u_xx + 2*u - 2*u**3", "u = jacobi_sn(x, m)", "m: real", "m")
    assert kink.detail == "holds if and only if m = 1"


def test_what_is_not_known_to_be_independent_is_not_called_complete() -> None:
    verdict = solved("u_x - 1", "u = a*log(exp(x) + 1) - a*log(1 + exp(-x))", "", "a")
    assert cases(verdict) == [{"a = 1"}]
    roots = solved("u_x", "u = a*sqrt(x) + b*sqrt(x + 1)", "", "a, b", domain="x > 0")
    assert not roots.complete
    assert roots.detail == (
        "holds if a = 0, b = 0 (trivial), others are not excluded (sqrt(x), sqrt(x + 1))"
    )


@pytest.mark.parametrize(
    ("equation", "formula", "wanted"),
    [("u_x - abs(k)*u", "exp(k*x)", "k"), ("u_x - sin(a)", "x/2", "a")],
)
def test_what_is_left_out_is_not_refuted(equation: str, formula: str, wanted: str) -> None:
    """The equations hold for k >= 0 and at a = pi/6, which the answer names as left out."""
    verdict = solved(equation, f"u = {formula}", "", wanted)
    assert verdict.outcome == "UNDECIDED"
    assert verdict.detail.startswith(f"no value was found of {wanted}, apart from where ")


@pytest.mark.parametrize(
    ("equation", "formula", "parameters", "answer"),
    [
        ("u[n+1] - b*u[n]", "u[n] = (-2)**n", "", "holds if and only if b = -2"),
        ("u[n+2] - b*u[n]", "u[n] = (-2)**n + 2**n", "", "holds if b = 4, others are not excluded"),
        ("u_t - b*u_xx", "u = jacobi_theta_3(x, exp(-t))", "", "holds if and only if b = 1/4"),
        ("u_x - b**b", "u = x", "b: b>0", "apart from where exp(b*log(b)) - 1 = 0"),
    ],
)
def test_every_function_has_an_answer(
    equation: str, formula: str, parameters: str, answer: str
) -> None:
    """Catches: an error for powers of -1, theta functions and exp(b*log(b))."""
    assert (
        answer
        in solved(equation, formula, parameters, "b", "t>0" if "_t" in equation else "").detail
    )


def test_functions_of_constants_are_left_out_by_name() -> None:
    verdict = solved("u_x - a*sin(b)", "u = x", "", "a")
    assert verdict.detail == "holds if and only if a = 1/sin(b)"
    circle = "u_x - a ;; v_x - b ;; a*u_x + b*v_x - 1"
    turn = solved(circle, "u = x*sin(p) ;; v = x*cos(p)", "", "a, b")
    assert turn.detail.startswith(
        "holds if and only if a = sin(p), b = cos(p), apart from where cos"
    )
    more = solved("u_x - a*sin(b) - c*cos(b)", "u = x", "", "a")
    assert (
        more.detail
        == "holds if and only if a = -(c*cos(b) - 1)/sin(b), apart from where sin(b) = 0"
    )


def test_a_polynomial_without_written_roots_is_a_condition_and_proved() -> None:
    verdict = solved("u_t + u_xxx/2", "u = exp(k*x - w*t)", "w: w!=0", "k")
    assert verdict.detail == "holds if and only if k**3 - 2*w = 0"
    assert verdict.outcome == "PROVED"


def test_the_names_must_be_parameters() -> None:
    for solve, message in [
        ("q", "solve: expected a parameter \\(a, c\\), got 'q'"),
        ("x", "solve: expected a parameter \\(a, c\\), got 'x'"),
        ("a*c", "solve: expected a parameter"),
        ("a, a", "solve: expected each parameter once, got a again"),
    ]:
        with pytest.raises(FormulaError, match=message):
            read_statement(KDV, "u = a*sech(x - c*t)**2", solve=solve)
    x = sp.Symbol("x")
    with pytest.raises(ValueError, match="must be left out with SymPy objects"):
        prove(sp.Function("u")(x).diff(x) - 1, x, solve="a")


def test_the_answer_as_data_and_in_latex() -> None:
    verdict = solved(KDV, "u = a*sech(k*(x - c*t))**2", "k: k>0", "c, a")
    record = verdict.json()
    assert record["solved"] == ["c", "a"]
    assert record["cases"][0]["values"] == {"c": "4*k**2", "a": "2*k**2"}
    assert (record["complete"], record["left_out"]) == (True, [])
    sentence = conditional_sentence(verdict)
    assert sentence.count("We verified") == 2
    assert sentence.endswith("There are no other values of $c, a$ with which it does.")
    assert verdict.lines() == [
        "holds if and only if",
        "c = 4*k**2, a = 2*k**2",
        "a = 0 (trivial)",
    ]
