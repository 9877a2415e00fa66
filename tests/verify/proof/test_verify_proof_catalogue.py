"""Every closed form of the catalogue, proved for all parameters at once."""

import json

import pytest

from longwave.solutions import CATALOGUE, ClosedForm
from longwave.verify.kernel import CertificateError
from longwave.verify.kernel import check_certificate as check_content
from longwave.verify.proof import check_certificate, prove_form, prove_stable
from longwave.verify.verdict import Outcome
from tests.verify.kernel.test_verify_kernel_rules import with_equation

ALL = pytest.mark.parametrize("form", CATALOGUE, ids=lambda form: form.name)


@ALL
def test_every_form_is_proved_those_of_mkdv_in_lab_variables_with_symbolic_constants(
    form: ClosedForm,
) -> None:
    """And the proof is refused for a changed equation."""
    verdict = prove_form(form)
    assert verdict.outcome is Outcome.PROVED, verdict.detail
    certificate = json.loads(json.dumps(verdict.certificate))
    check_certificate(certificate)
    added = f" + 1e-40*{certificate['statement']['variables'][0]}"
    with pytest.raises(CertificateError, match="the residual is not 0"):
        check_content(with_equation(certificate, added))


@ALL
def test_the_stable_form_is_the_canonical_form(form: ClosedForm) -> None:
    verdict = prove_stable(form)
    assert verdict.outcome is Outcome.PROVED, verdict.detail
