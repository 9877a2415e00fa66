"""Certificates that hold the whole statement: what is changed in the equation is another claim."""

import copy
from typing import Any

import pytest
from verify.proof.checker import CertificateError, check_certificate
from verify.proof.checker.limits import digest

from verify.proof.statement_verdict import StatementVerdict
from verify.proof.text_prover import prove

Data = dict[str, Any]

LADIK = "I*diff(u[n], t) + (u[n+1] + u[n-1])*(1 + abs(u[n])**2)"
STAGGERED = "u[n] = (-1)**n*sinh(b)*sech(b*n)*exp(-2*I*cosh(b)*t)"
ZAKHAROV = (
    "I*u_t + u_xx - u*v ;; v_tt - v_xx - diff(abs(u)**2, x, x)",
    "u = sqrt(2)*b*sech(b*x)*exp(I*b**2*t) ;; v = -2*b**2*sech(b*x)**2",
)


def proved(equation: str, solution: str, **stated: str) -> tuple[Data, ...]:
    verdict = prove(equation, solution, **stated)
    assert isinstance(verdict, StatementVerdict)
    assert verdict.outcome == "PROVED", verdict.detail
    assert not any("SymPy" in line for line in verdict.assumptions)
    return tuple(dict(certificate) for certificate in verdict.certificates)


def changed(certificate: Data, old: list[Any], new: list[Any]) -> Data:
    """The certificate with one node in the place of another, signed again."""
    data = copy.deepcopy(certificate)
    assert data["nodes"].count(old) == 1, data["nodes"]
    data["nodes"][data["nodes"].index(old)] = new
    return data | {"digest": digest(data)}


def place(certificate: Data, node: list[Any]) -> int:
    found: int = certificate["nodes"].index(node)
    return found


def test_the_statement_is_printed_with_its_unknowns_sites_and_conjugates() -> None:
    (certificate,) = proved(LADIK, STAGGERED, parameters="b: b>0")
    words = check_certificate(certificate)
    for part in ("u[n+1, t]", "u[n-1, t]", "diff(u, t)", "Abs(u)^2", "(-1)^(n)", "integer n"):
        assert part in words


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (["unknown", 0, [1, 0]], ["unknown", 0, [2, 0]]),
        (["unknown", 0, [-1, 0]], ["unknown", 0, [0, 0]]),
        (["unknown", 0, [1, 0]], ["unknown", 0, [1, 1]]),
        (["unknown", 0, [1, 0]], ["unknown", 0, [1]]),
        (["unknown", 0, [1, 0]], ["unknown", 1, [1, 0]]),
        (["unknown", 0, [1, 0]], ["unknown", 0, [10**9, 0]]),
        (["symbol", "n", "integer"], ["symbol", "n", "real"]),
    ],
)
def test_another_site_or_symbol_is_another_claim(old: list[Any], new: list[Any]) -> None:
    (certificate,) = proved(LADIK, STAGGERED, parameters="b: b>0")
    with pytest.raises(CertificateError):
        check_certificate(changed(certificate, old, new))


def test_a_conjugate_left_out_is_another_claim() -> None:
    (certificate,) = proved(
        "I*u_t + u_xx + 2*u**2*conjugate(u)", "u = a*sech(a*x)*exp(I*a**2*t)", parameters="a: a>0"
    )
    u = place(certificate, ["unknown", 0, [0, 0]])
    with pytest.raises(CertificateError):
        check_certificate(changed(certificate, ["conjugate", u], ["re", u]))


def test_unknowns_of_a_system_exchanged_are_another_claim() -> None:
    for certificate in proved(*ZAKHAROV, parameters="b: b>0"):
        u, v = (place(certificate, ["unknown", i, [0, 0]]) for i in (0, 1))
        data = copy.deepcopy(certificate)
        data["nodes"][u], data["nodes"][v] = data["nodes"][v], data["nodes"][u]
        with pytest.raises(CertificateError):
            check_certificate(data | {"digest": digest(data)})


def test_derivatives_are_in_real_variables_of_the_statement() -> None:
    (certificate,) = proved("diff(u[n], t) - u[n+1] + u[n]", "u[n] = exp(k*n + (exp(k)-1)*t)")
    u, t = (place(certificate, n) for n in (["unknown", 0, [0, 0]], ["symbol", "t", "real"]))
    own = ["diff", u, t]
    for other in ("n", "k"):
        kind = "integer" if other == "n" else "real"
        wrong = ["diff", u, place(certificate, ["symbol", other, kind])]
        with pytest.raises(CertificateError, match="variables"):
            check_certificate(changed(certificate, own, wrong))


def test_a_hint_has_no_derivative_in_a_parameter() -> None:
    (certificate,) = proved("sin(u_x) - sin(k)", "u = k*x")
    k = place(certificate, ["symbol", "k", "real"])
    data = copy.deepcopy(certificate)
    data["nodes"].append(["diff", k, k])
    with pytest.raises(CertificateError, match="real variables"):
        check_certificate(data | {"digest": digest(data)})


def test_a_formula_is_without_unknowns_and_derivatives() -> None:
    (certificate,) = proved("sin(u_x) - sin(1)", "u = x")
    for kind in ("unknown", "diff"):
        data = copy.deepcopy(certificate)
        node = next(i for i, entry in enumerate(data["nodes"]) if entry[0] == kind)
        data["statement"]["unknowns"][0][1] = node
        with pytest.raises(CertificateError, match="without derivatives and unknowns"):
            check_certificate(data | {"digest": digest(data)})


@pytest.mark.parametrize(
    ("equation", "solution", "stated"),
    [
        # log is not odd, and jumps
        ("u[n+1] - u[n] - log((n+1)/n)", "u[n] = log(n)", {"domain": "n <= -1"}),
        # principal values beyond their ranges
        ("u - v", "u = asin(sin(x)) ;; v = x", {"domain": "0 < x < 1571/1000"}),
        ("u - v", "u = acos(cos(x)) ;; v = x", {"domain": "0 < x < 22/7"}),
        ("u - v", "u = acosh(cosh(x)) ;; v = x", {"domain": "x > -1/1000000"}),
        # (f**a)**b, and a phase under a root
        ("u**b - x**(a*b)", "u = x**a", {"parameters": "a: real; b: real", "domain": "x != 0"}),
        ("sqrt(u**2) - u", "u = exp(I*x)", {"domain": "0 < x < 2"}),
        ("u[n]**2 - u[n]", "u[n] = (-1)**n", {}),
        ("exp(u/3) - (1 + I*sqrt(3))/2", "u = I*pi*(1 + 0*x)", {}),
    ],
)
def test_nothing_false_is_proved(equation: str, solution: str, stated: dict[str, str]) -> None:
    verdict = prove(equation, solution, **stated)
    right = equation.startswith("exp(u/3)")
    assert verdict.outcome != ("REFUTED" if right else "PROVED")
