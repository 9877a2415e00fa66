"""Certificates state the whole statement: a changed equation is a different claim."""

import copy
from typing import Any

import pytest

from longwave.verify.kernel import CertificateError, check_certificate
from longwave.verify.kernel.limits import digest
from longwave.verify.proof.statement_verdict import StatementVerdict
from longwave.verify.proof.text_prover import prove

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


def changed(certificate: Data, part: str, old: str, new: str) -> Data:
    """Return the certificate with another text in a part of the statement and a new digest."""
    data = copy.deepcopy(certificate)
    texts = data["statement"][part]
    assert any(old in text for text in texts), texts
    data["statement"][part] = [text.replace(old, new) for text in texts]
    return data | {"digest": digest(data)}


def test_the_statement_is_printed_with_its_unknowns_sites_and_conjugates() -> None:
    (certificate,) = proved(LADIK, STAGGERED, parameters="b: b>0")
    words = check_certificate(certificate)
    for part in ("u[n+1]", "u[n-1]", "diff(u[n], t)", "abs(u[n])**2", "(-1)**n", "integer n"):
        assert part in words


@pytest.mark.parametrize(
    ("part", "old", "new"),
    [
        ("equations", "u[n+1]", "u[n+2]"),
        ("equations", "u[n-1]", "u[n]"),
        ("equations", "u[n+1]", "u[n+1, t+1]"),
        ("equations", "u[n+1]", "u[n+1"),
        ("equations", "u[n+1]", "v[n+1]"),
        ("equations", "u[n+1]", "u[n+1000000000]"),
        ("equations", "diff(u[n], t)", "diff(u[n], n)"),
        ("equations", "diff(u[n], t)", "diff(u[n], b)"),
        ("variables", "n", "m"),
    ],
)
def test_another_site_or_symbol_is_another_claim(part: str, old: str, new: str) -> None:
    (certificate,) = proved(LADIK, STAGGERED, parameters="b: b>0")
    with pytest.raises(CertificateError):
        check_certificate(changed(certificate, part, old, new))


def test_a_conjugate_left_out_is_another_claim() -> None:
    (certificate,) = proved(
        "I*u_t + u_xx + 2*u**2*conjugate(u)", "u = a*sech(a*x)*exp(I*a**2*t)", parameters="a: a>0"
    )
    with pytest.raises(CertificateError):
        check_certificate(changed(certificate, "equations", "conjugate(", "re("))


def test_unknowns_of_a_system_exchanged_are_another_claim() -> None:
    for certificate in proved(*ZAKHAROV, parameters="b: b>0"):
        data = changed(certificate, "solutions", "u = ", "w = ")
        data = changed(changed(data, "solutions", "v = ", "u = "), "solutions", "w = ", "v = ")
        with pytest.raises(CertificateError):
            check_certificate(data)


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
