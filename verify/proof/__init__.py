"""Exact proofs of closed forms by differential algebra.

`prove` decides whether a formula solves an equation for all its parameters, and `prove_equal`
whether two formulas are the same function.  `prove_form` decides a closed form of the catalogue
with symbolic lattice constants, `prove_stable` its evaluation form.  `prove_rational` and
`rational_facts` handle rational solutions of any order.  `check_certificate` repeats a proof.
"""

from typing import TYPE_CHECKING

from longwave.support.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from longwave.verify.kernel import CertificateError
    from longwave.verify.proof.catalogue_proofs import (
        check_certificate,
        form_domains,
        prove_form,
        prove_stable,
    )
    from longwave.verify.proof.domains import Domain
    from longwave.verify.proof.prover import prove, prove_equal
    from longwave.verify.proof.rational_proofs import RationalFacts, prove_rational, rational_facts
    from longwave.verify.verdict import ProofVerdict

__all__ = [
    "CertificateError",
    "Domain",
    "ProofVerdict",
    "RationalFacts",
    "check_certificate",
    "form_domains",
    "prove",
    "prove_equal",
    "prove_form",
    "prove_rational",
    "prove_stable",
    "rational_facts",
]

__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "longwave.verify.proof.catalogue_proofs": "check_certificate form_domains "
        "prove_form prove_stable",
        "longwave.verify.kernel": "CertificateError",
        "longwave.verify.proof.domains": "Domain",
        "longwave.verify.proof.prover": "prove prove_equal",
        "longwave.verify.proof.rational_proofs": "RationalFacts prove_rational rational_facts",
        "longwave.verify.verdict": "ProofVerdict",
    },
)
