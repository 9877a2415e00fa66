"""Places at which typed formulas may jump or have corners, and their mention in verdicts."""

import json

import pytest
import sympy as sp

from longwave.__main__ import main
from longwave.verify.proof.conditions import conditional_sentence, solve_statement
from longwave.verify.proof.seams import left_open, seams, sides
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.statement_verdict import decide_statement, verified_sentence
from longwave.verify.proof.stored_verdict import checked_again, verdict_record
from longwave.verify.proof.text_prover import prove
from longwave.verify.published import chosen

CAMASSA_HOLM = "u_t - u_txx + 3*u*u_x - 2*u_x*u_xx - u*u_xxx"
PEAKON = "u = a*exp(-abs(x - s*t))"
ACROSS = ", nothing said across it"
PEAKONS = {
    "camassa_holm_peakon": "x = c*t",
    "degasperis_procesi_peakon": "x = c*t",
    "degasperis_procesi_shock_peakon": "x = 0",
    "fornberg_whitham_peakon": "x = 4*t/3",
    "novikov_peakon": "x = c*t",
}


def places(
    solution: str, equation: str = "u_x", parameters: str = "", domain: str = ""
) -> list[str]:
    found = seams(read_statement(equation, solution, parameters, domain))
    return [seam.place for seam in found]


@pytest.mark.parametrize(
    ("solution", "expected"),
    [
        (PEAKON, ["x = s*t"]),
        ("u = (1 - sign(x - 3*t))/2", ["x = 3*t"]),
        ("u = sign(2*x - 1)", ["x = 1/2"]),
        ("u = abs(x**2 - 1)", ["x**2 - 1 = 0"]),
        ("u = sqrt((x - t)**2)", ["x = t"]),
        ("u = ((x - t)**4)**(1/4)", ["x = t"]),
        ("u = ((x - t)**2)**c", ["x = t"]),
        ("u = exp(log(x**2)/2)", ["x = 0"]),
        ("u = atan(1/x)", ["x = 0"]),
        ("u = atan(tan(x))", ["cos(x) = 0"]),
        ("u = 1/(1 + exp(1/(x - 2)))", ["x = 2"]),
        ("u = acos(cos(x))", ["cos(x) - 1 = 0", "cos(x) + 1 = 0"]),
        ("u = acosh(cosh(x))", ["cosh(x) - 1 = 0"]),
        ("u = lambert_w(x*exp(x))", ["x*exp(x) + exp(-1) = 0"]),
        ("u = log(1 - 2*exp(I*x))", ["im(1 - 2*exp(I*x)) = 0"]),
        ("u = abs(x) + sign(x)", ["x = 0"]),
        ("u = bessel_k(1/3, x)", ["x = 0"]),
        ("u = abs(x - w*t)", ["x = 2*c*t"]),
    ],
)
def test_a_place_where_a_formula_is_not_smooth_is_found(solution: str, expected: list[str]) -> None:
    parameters = "c: real; w = 2*c" if "w*t" in solution else ""
    assert places(solution, parameters=parameters) == expected


@pytest.mark.parametrize(
    ("solution", "parameters", "domain"),
    [
        ("u = abs(x)", "", "x > 0"),
        ("u = abs(m)*x", "", ""),
        ("u = sqrt(1 + x**2)", "", ""),
        ("u = sign(exp(I*x))**2", "", ""),
        ("u = abs(tanh(x))**2", "", ""),
        ("u = 1/x + tan(x) + log(x**2)", "", ""),
        ("u = atan(exp(x))", "", ""),
        ("u = abs(k*cosh(x))", "k: k!=0", ""),
        ("u = (1 + exp(x))**(-2/q)", "", ""),
        ("u = bessel_j(1, x)", "", ""),
        ("u = lambert_w(exp(x))", "", ""),
    ],
)
def test_smooth_formulas_and_poles_have_no_seams(
    solution: str, parameters: str, domain: str
) -> None:
    assert places(solution, "u_x", parameters, domain) == []


def test_functions_of_an_unknown_are_looked_at() -> None:
    assert places("u = tanh(x)", "u_t - diff(abs(u)*u, x)") == ["tanh(x) = 0"]
    assert places("u = tanh(x)", "u_t - abs(u)**2*u") == []
    assert places("u = log(x**2)", "u_t - exp(u)") == []


def test_sites_are_left_out_one_by_one() -> None:
    found = seams(read_statement("u[n+1] - u[n]", "u[n] = sign(n - 3)**2"))
    assert sides(found) == "apart from n = 3, n = 2, nothing said of them"
    assert places("u[n] = abs(n - 1/2)", "u[n+1] - u[n]") == []


def test_a_travelling_corner_is_proved_on_its_sides_alone(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Pointwise every speed s is a solution, but only s = a is a peakon."""
    statement = read_statement(CAMASSA_HOLM, PEAKON)
    verdict = decide_statement(statement)
    front = f"on each side of x = s*t{ACROSS}"
    assert verdict.outcome == "PROVED"
    assert repr(verdict).startswith(f"<StatementVerdict PROVED {front}: ")
    assert verdict._repr_html_().count("on each side of x = s*t") == 1
    assert verdict.singularities == ()
    assert not any("jump or corner" in line for line in verdict.assumptions)
    sentence = verified_sentence(statement, verdict)
    assert sentence.index("on each side of x = s*t, with nothing said") < sentence.index(r"\[")
    assert verdict.json()["sides"] == front
    assert main(["prove", "--equation", CAMASSA_HOLM, "--solution", PEAKON]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert printed.startswith(f"PROVED {front}: ")
    assert printed.count("x = s*t") == 1
    assert main(["prove", "--json", "--equation", CAMASSA_HOLM, "--solution", PEAKON]) == 0
    assert json.loads(capsys.readouterr().out)[0]["sides"] == front


def test_the_words_stand_before_an_answer_of_constants() -> None:
    statement = read_statement("u_t + 2*u_x", "u = exp(-abs(x - s*t))", solve="s")
    verdict = solve_statement(statement)
    assert verdict.detail == f"on each side of x = s*t{ACROSS}: holds if and only if s = 2"
    assert verdict.lines() == ["holds if and only if s = 2"]
    assert verdict.json()["reason"] == verdict.words()
    assert "on each side of x = 2*t" in conditional_sentence(verdict)


def test_seams_are_found_again_on_resumption() -> None:
    statement = read_statement(CAMASSA_HOLM, PEAKON)
    record = verdict_record(decide_statement(statement)) | {"sides": "everywhere"}
    verdict = checked_again(statement, record)
    assert verdict is not None
    assert verdict.restriction == f"on each side of x = s*t{ACROSS}"


def test_a_refutation_has_no_sides() -> None:
    verdict = prove("u_x - 1", "u = abs(x)")
    assert verdict.outcome == "REFUTED"
    assert repr(verdict).startswith("<StatementVerdict REFUTED: ")
    assert verdict.json()["sides"] == ""


def test_sympy_formulas_have_seams_too() -> None:
    x, t = sp.symbols("x t")
    u = sp.Function("u")(x, t)
    verdict = prove(u.diff(t) + u.diff(x), sp.Abs(x - t))
    assert repr(verdict).startswith("<ProofVerdict PROVED on each side of ")
    assert prove(u.diff(t) + u.diff(x), sp.tanh(x - t)).sides == ""


@pytest.mark.parametrize("name", PEAKONS)
def test_the_peakons_of_the_library_have_seams(name: str) -> None:
    (text,) = chosen([name])
    verdict = decide_statement(text.problem().statement)
    assert verdict.outcome == "PROVED"
    assert verdict.restriction == f"on each side of {PEAKONS[name]}{ACROSS}"


def test_a_product_is_0_where_a_factor_is() -> None:
    """Catches: "each side of n*t = 0" for a lattice, without the site n = 0."""
    statement = read_statement("u[n+1] + u[n]", "u = (-1)**n*abs(sign(n*t))**2", "", "t < 0")
    verdict = decide_statement(statement)
    assert verdict.sides == "apart from n = 0, n = -1, nothing said of them"
    places = [seam.place for seam in seams(read_statement("u_xx", "u = sign((x - 1)*sign(x*t))"))]
    assert places == ["x = 1", "x = 0", "t = 0"]


@pytest.mark.parametrize(
    ("solution", "parameters", "line", "sentence"),
    [
        (
            "-x*sign(f(m))**2",
            "f: function",
            "where f(m) = 0",
            r"nothing is said at $f\left(m\right) = 0$.",
        ),
        ("-x*sign(k - 3)**2", "k: integer", "at k = 3", "nothing is said at $k = 3$."),
        ("-x*sign(m**2 - 3)**2", "", "where m**2 - 3 = 0", "nothing is said at $m^{2} - 3 = 0$."),
    ],
)
def test_values_of_parameters_at_which_a_formula_jumps_are_named(
    solution: str, parameters: str, line: str, sentence: str
) -> None:
    """Catches: the LaTeX sentence "for all real m", and "the site k = 3" for a parameter."""
    statement = read_statement("u_x + 1", f"u = {solution}", parameters)
    verdict = decide_statement(statement)
    assert verdict.singularities == (f"jump or corner {line}",)
    assert verified_sentence(statement, verdict).endswith(sentence)


LEFT_OPEN = [
    ("u = sign(m*(x - t))**2", ["x = t"], ["jump or corner where m = 0"]),
    ("u = sign(m*(1 + I*x))**2", [], ["jump or corner where m = 0"]),
    ("u = sign(x**(-1))**2", ["x = 0"], ["pole where x = 0"]),
    ("u = sign(x/t)**2", ["x = 0", "t = 0"], ["pole where t = 0"]),
    ("u = sign(1 + I*(x - 2))**2", [], []),
    ("u = sign((1 + m**2)*x)**2 + abs(0*t)", ["x = 0", "t = 0"], []),
    ("u = sign(diff(f(x), x)*f(m))**2", ["diff(f(x), x) = 0"], ["jump or corner where f(m) = 0"]),
]


@pytest.mark.parametrize(("solution", "places", "lines"), LEFT_OPEN)
def test_a_product_is_0_where_a_factor_without_variables_is(
    solution: str, places: list[str], lines: list[str]
) -> None:
    """Catches: m = 0 hidden by x = t, where u = 0; places at which no factor can be 0."""
    functions = "f: function" if "f(" in solution else ""
    found, left = left_open(read_statement("u - 1", solution, functions))
    assert ([seam.place for seam in found], list(left)) == (places, lines)
