"""The paper's quantitative and comparative statements, as records. Adding one is one line here."""

from collections.abc import Callable

from verify.studies import claims_constant, claims_periodic, claims_waves
from verify.studies.claims_evidence import Evidence
from verify.studies.claims_record import Claim

ABOUT_WAVES: tuple[Callable[[], Claim], ...] = (
    claims_waves.peaks,
    claims_waves.degrees,
    claims_waves.localised_in_space,
    claims_waves.localised_in_time,
    claims_waves.higher_orders,
    claims_waves.rogue_maximum,
)

ABOUT_RUNS: tuple[Callable[[Evidence], Claim], ...] = (
    claims_constant.second_order_crest,
    claims_constant.peak_of_the_error,
    claims_constant.error_against_order,
    claims_constant.twenty_percent,
    claims_constant.third_order_agreement,
    claims_periodic.breather_and_modulus,
    claims_periodic.dn_fit,
    claims_periodic.cn_maximum,
    claims_periodic.modulational_instability,
)


def all_claims(evidence: Evidence) -> list[Claim]:
    """Every statement with the numbers of these runs."""
    return [claim() for claim in ABOUT_WAVES] + [claim(evidence) for claim in ABOUT_RUNS]
