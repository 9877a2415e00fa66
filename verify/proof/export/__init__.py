"""Certificates as scripts of other systems, which repeat the algebra of a proof.

`derivation.written_out` follows the checker through a certificate and notes every step; `pari`,
`maxima` and `coq` write the steps in their languages.  `docs/trust.md` says what a script checks.
"""
