"""The paper's quantitative and comparative statements, as records. Adding one is one line here."""

from collections.abc import Callable

from verify.studies.claims_evidence import MeasuredRuns
from verify.studies.claims_record import Claim

ABOUT_WAVES: tuple[Callable[[], Claim], ...] = (
    peaks,
    degrees,
    localised_in_space,
    localised_in_time,
    higher_orders,
    rogue_maximum,
)

ABOUT_RUNS: tuple[Callable[[MeasuredRuns], Claim], ...] = (
    second_order_crest,
    peak_of_the_error,
    error_against_order,
    twenty_percent,
    third_order_agreement,
    breather_and_modulus,
    dn_fit,
    cn_maximum,
    modulational_instability,
)


def all_claims(evidence: MeasuredRuns) -> list[Claim]:
    """Every statement with the numbers of these runs."""
    return [claim() for claim in ABOUT_WAVES] + [claim(evidence) for claim in ABOUT_RUNS]
