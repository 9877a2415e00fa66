"""Every rule in a true statement that needs it, and the same statement with one thing wrong."""

import copy
import json
import runpy
import sys
from typing import Any

import pytest

from longwave.solutions.forms.rational import rational_tau
from longwave.verify.kernel import CertificateError, check_certificate
from longwave.verify.kernel.__main__ import main
from longwave.verify.kernel.limits import digest
from longwave.verify.proof.rational_proofs import bilinear_certificate, prove_rational
from longwave.verify.proof.statement_verdict import StatementVerdict
from longwave.verify.proof.text_prover import prove

Data = dict[str, Any]

RULES = [
    ("u_t + 6*u*u_x + u_xxx", "u = 2*k**2*sech(k*(x - 4*k**2*t))**2", "k: k>0", ""),
    ("u_tt - u_xx + sin(u)", "u = 4*atan(exp((x - c*t)/sqrt(1 - c**2)))", "c: -1<c<1", ""),
    ("I*u_t + u_xx + 2*abs(u)**2*u", "u = a*sech(a*x)*exp(I*a**2*t)", "a: a>0", ""),
    ("u_t - u_xx", "u = exp(-x**2/(4*t))/sqrt(t)", "", "t > 0"),
    ("u_x - 1/x", "u = log(x)", "", "x > 0"),
    ("u - 2*log(x) - x", "u = log(x**2*exp(x))", "", "x > 0"),
    ("u - v", "u = asinh(sinh(x)) ;; v = x", "", ""),
    ("u - v", "u = acos(cos(x)) ;; v = x", "", "0 < x < 3"),
    ("u_x - 1/sqrt(1 - x**2)", "u = asin(x)", "", "-1 < x < 1"),
    ("u_x + 1/sqrt(1 - x**2)", "u = acos(x)", "", "-1 < x < 1"),
    ("u_x*(1 - x**2) - 1", "u = atanh(x)", "", "-1 < x < 1"),
    ("u_x**2*(x**2 - 1) - 1", "u = acosh(x)", "", "x > 1"),
    ("u - x", "u = abs(x)", "", "x > 0"),
    ("u_x*abs(x) - x", "u = abs(x)", "", ""),
    ("u_x - sign(x)", "u = abs(x)", "", ""),
    ("u - x", "u = sqrt(x**2)", "", "x > 0"),
    ("u - x*y", "u = re((x + I)*(y - I)) - 1", "", ""),
    ("u - y + x", "u = im((x + I)*(y - I)) + 0*x", "", ""),
    ("u - exp(-I*x)", "u = conjugate(exp(I*x))", "", ""),
    ("u - exp(-I*x)", "u = conjugate(sign(exp(I*x)))", "", ""),
    ("x*abs(u)**2 - x", "u = sign(1 + I*x)", "", ""),
    ("u - v", "u = conjugate(sign(x + I*t)) ;; v = sign(x - I*t)", "", ""),
    ("u_x - a*x**a/x", "u = x**a", "a: real", "x > 0"),
    ("u[n+1] + u[n]", "u[n] = (-1)**n*k", "", ""),
    ("u[n+2] - u[n]", "u[n] = (-1)**n*k", "", ""),
    ("diff(u*v, x) - u**2*v - v**3", "u = tan(x) ;; v = sec(x)", "", ""),
    ("u_x + u**2 + 1", "u = cot(x)", "", ""),
    ("u_x + u*coth(x)", "u = csch(x)", "", ""),
    ("u_xx + (1 + m)*u - 2*m*u**3", "u = jacobi_sn(x, m)", "m: 0<m<1", ""),
    ("u - v", "u = jacobi_sn(x + elliptic_k(m), m) ;; v = jacobi_cn(x, m)/jacobi_dn(x, m)",
     "m: 0<m<1", ""),
    ("u_x - jacobi_dn(x, m)**2", "u = jacobi_epsilon(x, m)", "m: 0<m<1", ""),
    ("u - v", "u = jacobi_sn(2*x, m) ;; v = 2*jacobi_sn(x,m)*jacobi_cn(x,m)*jacobi_dn(x,m)"
     "/(1 - m*jacobi_sn(x,m)**4)", "m: 0<m<1", ""),
    ("sqrt(u**2) - u", "u = exp(I*x)", "", "-1 < x < 1"),
    ("u - v", "u = exp(2*I*atan(x)) ;; v = (1 + I*x)/(1 - I*x)", "", ""),
    ("u - v", "u = log(exp(I*x)) ;; v = I*x", "", "-1 < x < 1"),
    ("u - v", "u = cos(pi/6)*x ;; v = sqrt(3)*x/2", "", ""),
    ("u[n] + v[n]", "u[n] = (-1)**(n + 1) ;; v[n] = (-1)**n", "", ""),
    ("u[n] - v[n]", "u[n] = (-1)**(3*n) ;; v[n] = (-1)**n", "", ""),
    ("u - x*elliptic_k(m)", "u = sqrt(elliptic_k(m)**2)*x", "m: 0<m<1", ""),
    ("u - acos(x)", "u = sqrt(acos(x)**2)", "", "-1 < x < 1"),
    ("u - log(x)", "u = conjugate(log(x))", "", "x > 0"),
    ("u - x**a", "u = conjugate(x**a)", "a: real", "x > 0"),
    ("u - x*elliptic_e(m)", "u = conjugate(elliptic_e(m))*x", "m: 0<m<1", ""),
    ("u - exp(I*x)", "u = conjugate(conjugate(exp(I*x)))", "", ""),
    ("u - acosh(x)", "u = conjugate(acosh(x))", "", "x > 1"),
    ("u - atan(x)", "u = conjugate(atan(x))", "", ""),
    ("u*conjugate(u) - abs(u)**2", "u = jacobi_sn(x + I*t, m)", "m: 0<m<1", ""),
    ("u - v", "u = jacobi_zeta(x + elliptic_k(m), m) ;; v = jacobi_zeta(x, m)"
     " - m*jacobi_sn(x, m)*jacobi_cn(x, m)/jacobi_dn(x, m)", "m: 0<m<1", ""),
    ("re(u)**2 + im(u)**2 - abs(u)**2", "u = exp(I*x)*sqrt(x)", "", "x > 0"),
    ("u - v", "u = jacobi_zeta(x, m) ;; v = jacobi_epsilon(x, m) - x*elliptic_e(m)/elliptic_k(m)",
     "m: 0<m<1", ""),
    ("u[n+4] - u[n]", "u[n] = cos(pi*n/2)", "", ""),
    ("u[n] - (-1)**n", "u[n] = cos(3*pi*n)", "", ""),
    ("u[n] - 1", "u[n] = cos(2*pi*n)", "", ""),
]  # fmt: skip


def proved(equation: str, solution: str, parameters: str, domain: str) -> list[Data]:
    verdict = prove(equation, solution, parameters=parameters, domain=domain)
    assert isinstance(verdict, StatementVerdict)
    assert verdict.outcome == "PROVED", verdict.detail
    return [json.loads(json.dumps(certificate)) for certificate in verdict.certificates]


def with_equation(data: Data, added: str) -> Data:
    """The certificate with something added to its equation, signed again."""
    changed = copy.deepcopy(data)
    changed["statement"]["equations"][0] += added
    return changed | {"digest": digest(changed)}


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule[1][:40])
def test_a_rule_proves_what_is_true_and_nothing_beside_it(rule: tuple[str, ...]) -> None:
    for data in proved(*rule):
        assert data["statement"]["solutions"][0] in check_certificate(data)
        unknown = data["statement"]["solutions"][0].split(" = ")[0]
        variable = data["statement"]["variables"][0]
        for added in (f" + 1e-40*{variable}", f" + 1e-40*{unknown}*{variable}"):
            with pytest.raises(CertificateError, match="the residual is not 0"):
                check_certificate(with_equation(data, added))


def test_a_long_quotient_is_put_in_at_more_values_than_its_degree() -> None:
    certificate = prove_rational(5).certificate
    assert certificate is not None
    data = json.loads(json.dumps(certificate))
    assert "U = " in check_certificate(data)
    for old, new in (("6*U**2", "6000001/1000000*U**2"), ("diff(U, tau)", "2*diff(U, tau)")):
        wrong = copy.deepcopy(data)
        (text,) = wrong["statement"]["equations"]
        wrong["statement"]["equations"] = [text.replace(old, new)]
        with pytest.raises(CertificateError, match="the residual is not 0"):
            check_certificate(wrong | {"digest": digest(wrong)})
    tau = rational_tau(2)
    assert "A = " in check_certificate(bilinear_certificate("rational_2", tau.A, tau.B))


def test_the_command_prints_what_it_accepts(
    tmp_path: Any, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "c.json"
    (data,) = proved("u_x - 1", "u = x", "", "")
    for content, status, words in (
        (json.dumps(data), 0, "accepted"),
        (json.dumps([data, with_equation(data, " + x")]), 1, "rejected"),
        (" " * 8_000_001, 1, "at most"),
        ("[", 1, "no JSON"),
    ):
        path.write_text(content, encoding="utf-8")
        assert main([str(path)]) == status
        assert words in "".join(capsys.readouterr())
    assert main([]) == 2
    monkeypatch.setattr(sys, "argv", ["kernel"])
    with pytest.warns(RuntimeWarning, match="found in sys.modules"), pytest.raises(SystemExit):
        runpy.run_module("longwave.verify.kernel", run_name="__main__")
    assert main([str(tmp_path / "none")]) == 2
    assert "FILE must be readable: No such file" in capsys.readouterr().err
