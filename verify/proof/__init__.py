"""Exact proofs of closed forms by differential algebra.

`prove` decides whether a formula solves an equation for all its parameters, `prove_equal` whether
two formulas are one function; `prove_form` takes a closed form of the catalogue with its lattice
constants symbolic, `prove_stable` its evaluation form; `prove_rational`, `prove_bilinear` and
`rational_facts` take the rational solutions of any order.  A proof's certificate is repeated by
`check_certificate`.
"""

from verify.verdict import ProofVerdict

from .catalogue_proofs import check_certificate, form_domains, prove_form, prove_stable
from .checker import CertificateError
from .domains import Domain
from .prover import prove, prove_equal
from .rational_proofs import RationalFacts, prove_bilinear, prove_rational, rational_facts

__all__ = [
    "CertificateError",
    "Domain",
    "ProofVerdict",
    "RationalFacts",
    "check_certificate",
    "form_domains",
    "prove",
    "prove_bilinear",
    "prove_equal",
    "prove_form",
    "prove_rational",
    "prove_stable",
    "rational_facts",
]
