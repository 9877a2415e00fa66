"""Texts of verdicts and certificates, and errors for wrong arguments in Python."""

from collections.abc import Callable

import pytest
import sympy as sp

from longwave.solutions import closed_form
from longwave.verify.proof import check_certificate, form_domains, prove, prove_equal, prove_form
from longwave.verify.verdict import Outcome

x, t = sp.symbols("x t")
k = sp.Symbol("k", positive=True)
u = sp.Function("u")(x, t)
TRANSPORT = u.diff(t) + u.diff(x)

WRONG: dict[str, Callable[[], object]] = {
    "equation must be a SymPy expression, got 1": lambda: prove(1, 2),
    "expression must be a SymPy expression, got 'x - t'": lambda: prove(TRANSPORT, "x - t"),
    "right must be a SymPy expression, got True": lambda: prove_equal(x, True, [x]),
    "domains must map symbols to intervals, got 3": lambda: prove(TRANSPORT, x, domains=3),  # type: ignore[arg-type]
    "name must be text, got 3": lambda: prove(TRANSPORT, x, name=3),  # type: ignore[arg-type]
    "variables must be a list of symbols, got x": lambda: prove_equal(x, x, x),
    "symbols must be sympy.Symbol, got 'x'": lambda: prove_equal(x, x, ["x"]),
    "form must be a ClosedForm, got 'kink'": lambda: prove_form("kink"),  # type: ignore[arg-type]
    "form must be a ClosedForm, got None": lambda: form_domains(None),  # type: ignore[arg-type]
}


@pytest.mark.parametrize("message", WRONG)
def test_a_wrong_type_is_answered_on_one_line_with_a_remedy(message: str) -> None:
    with pytest.raises(TypeError, match=message) as caught:
        WRONG[message]()
    words = str(caught.value)
    assert "\n" not in words
    assert words.endswith(")"), "the remedy stands in brackets"


def test_a_verdict_and_its_certificate_are_one_helpful_line() -> None:
    verdict = prove_form(closed_form("kink"))
    assert repr(verdict).startswith("<ProofVerdict PROVED: kink, mKdV in X, T, K4 < 0: numerator")
    assert repr(verdict.certificate).startswith("<Certificate of kink: ")
    assert "\n" not in repr(verdict) + repr(verdict.certificate)
    wrong = prove(TRANSPORT, x + t)
    assert wrong.outcome is Outcome.REFUTED
    assert repr(wrong).endswith(" at t = 777/1009, x = 42/1009>")


def test_the_catalogues_statements_are_compared_without_a_search(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Only the statement of a certificate is computed again, not its proof."""
    certificate = prove_form(closed_form("rogue_cn")).certificate

    def search(*_: object, **__: object) -> None:
        pytest.fail("searched for generators")

    monkeypatch.setattr("longwave.verify.proof.certificate.GeneratorSearch", search)
    assert "for all real" in check_certificate(certificate)
