"""Export certificates as scripts of other systems, which repeat the algebra of a proof.

`derivation.written_out` follows the checker through a certificate and records every step; `scripts`
(PARI/GP and Maxima) and `coq` write the steps.  `docs/trust.md` explains what a script checks.
"""
