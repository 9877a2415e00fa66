"""Every closed form of the catalogue, proved for all parameters at once."""

import json

import pytest

from longwave.solutions import CATALOGUE, ClosedForm
from longwave.verify.proof import check_certificate, form_domains, prove, prove_form, prove_stable
from longwave.verify.verdict import Outcome

ALL = pytest.mark.parametrize("form", CATALOGUE, ids=lambda form: form.name)


@pytest.mark.parametrize("form", CATALOGUE.of("mKdV"), ids=lambda form: form.name)
def test_every_form_is_proved_with_a_certificate(form: ClosedForm) -> None:
    domains = form_domains(form)
    verdict = prove(form.equation, form.expression, name=form.name, domains=domains)
    assert verdict.outcome is Outcome.PROVED, verdict.detail
    assert verdict.certificate is not None
    assert verdict.assumptions


@ALL
def test_every_form_is_proved_those_of_mkdv_in_lab_variables_with_symbolic_constants(
    form: ClosedForm,
) -> None:
    verdict = prove_form(form)
    assert verdict.outcome is Outcome.PROVED, verdict.detail
    assert verdict.certificate is not None
    check_certificate(json.loads(json.dumps(verdict.certificate)))


@ALL
def test_the_stable_form_is_the_canonical_form(form: ClosedForm) -> None:
    verdict = prove_stable(form)
    assert verdict.outcome is Outcome.PROVED, verdict.detail
