"""Exact proofs of closed forms by differential algebra.

`prove` decides whether a formula solves an equation for all its parameters, `prove_equal` whether
two formulas are one function; `prove_form` takes a closed form of the catalogue with its lattice
constants symbolic, `prove_stable` its evaluation form; `prove_rational`, `prove_bilinear` and
`rational_facts` take the rational solutions of any order.  A proof's certificate is repeated by
`check_certificate`.  A new function is one entry in `table.TABLE`.
"""

from .bilinear import prove_bilinear
from .checker import CertificateError
from .closed_forms import check_certificate, prove_form, prove_stable
from .domain import Domain, form_domains
from .facts import RationalFacts, rational_facts
from .proof import prove, prove_equal
from .rational_orders import prove_rational
from .verdict import ProofVerdict

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
