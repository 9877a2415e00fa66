"""The paper's statements with measured numbers, verdicts and what they depend on."""

from reports.claims import all_claims
from reports.tables import table
from verify.study.claims_evidence import Evidence


def claim_table(evidence: Evidence) -> str:
    """One row a statement."""
    rows = [
        [claim.statement, claim.measured, claim.verdict, claim.depends_on]
        for claim in all_claims(evidence)
    ]
    head = ["the paper says", "measured here", "verdict", "depends on"]
    return table("L{42mm}L{60mm}L{18mm}L{28mm}", head, rows, gap="1ex")
