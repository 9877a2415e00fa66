"""The kernel, an independent checker: a certificate in, the statement that it proves out.

A certificate holds a statement as text, and hints; no slope, relation or image is in it.  The
checker derives those from its axioms (`axioms`) and decides by exact arithmetic of its own (`ring`)
whether the equations hold.  Nothing of the prover is used, and no SymPy.
`docs/trust.md` says what is trusted.
"""

from __future__ import annotations

from .check import check_certificate, opened
from .limits import CertificateError

__all__ = ["CertificateError", "check_certificate", "opened"]
