"""Random statements whose truth is known by construction, to find wrong verdicts with.

`statement` makes the one of a seed and an index; `verify.studies.verdicts` asks the prover.
"""

from verify.studies.statements.library import KINDS, statement
from verify.studies.statements.statement import Range, Statement, Truth

__all__ = ["KINDS", "Range", "Statement", "Truth", "statement"]
