"""Every closed form of the catalogue, proved for all parameters at once."""

import json
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import pytest

from longwave.solutions import CATALOGUE, ClosedForm
from longwave.verify.kernel import CertificateError
from longwave.verify.kernel import check_certificate as check_content
from longwave.verify.proof import check_certificate, prove_stable
from longwave.verify.proof.catalogue_proofs import NAMES, prove_named
from longwave.verify.verdict import Outcome, ProofVerdict
from tests.families import WAVES, family
from tests.verify.kernel.test_verify_kernel_alone import alone
from tests.verify.kernel.test_verify_kernel_rules import with_equation


@cache
def proved(name: str) -> ProofVerdict:
    return prove_named(name)


@pytest.mark.parametrize("form", CATALOGUE, ids=lambda form: form.name)
def test_every_form_is_proved_those_of_mkdv_in_lab_variables_with_symbolic_constants(
    form: ClosedForm,
) -> None:
    """Checks also that the proof is rejected for a changed equation."""
    verdict = proved(form.name)
    assert verdict.outcome is Outcome.PROVED, verdict.detail
    certificate = json.loads(json.dumps(verdict.certificate))
    check_certificate(certificate)
    added = f" + 1e-40*{certificate['statement']['variables'][0]}"
    with pytest.raises(CertificateError, match="the residual is not 0"):
        check_content(with_equation(certificate, added))


@pytest.mark.parametrize(
    "names", [WAVES, pytest.param(NAMES, marks=pytest.mark.slow)], ids=["waves", "all"]
)
def test_the_kernel_alone_is_enough_for_the_catalogue(names: Sequence[str], tmp_path: Path) -> None:
    certificates = [proved(name).certificate for name in names]
    done = alone(tmp_path, json.dumps([c for c in certificates if c]))
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("accepted\n") == sum(map(bool, certificates)) > 0.8 * len(names)


@pytest.mark.parametrize("form", family(CATALOGUE, slow=("breather_sn", "rogue_cn")))
def test_the_stable_form_is_the_canonical_form(form: ClosedForm) -> None:
    verdict = prove_stable(form)
    assert verdict.outcome is Outcome.PROVED, verdict.detail
