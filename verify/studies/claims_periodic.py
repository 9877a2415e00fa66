"""The paper's statements about lattice runs from waves on periodic backgrounds."""

import math
from itertools import pairwise

from verify.comparison.trust import USUAL_TOLERANCE, trust_in
from verify.studies.claims_evidence import Evidence
from verify.studies.claims_record import Claim, Measurement, ruling

BREATHER_MODULI = ("0.5", "0.6", "0.7")
TWENTY_PERCENT = 0.2
ROGUE, SOLITON = "rogue_cn_k_0.5", "soliton_dn_k_0.7"


def breather_and_modulus(evidence: Evidence) -> Claim:
    """The dark breather's largest error at the three moduli."""
    tops = {k: evidence.largest_error(f"breather_sn_k_{k}")[0] for k in BREATHER_MODULI}
    falls = all(a.value > b.value for a, b in pairwise(tops.values()))
    return Claim(
        "breather_and_modulus",
        "On the sn background the agreement is better for larger $k$",
        tuple(Measurement(f"$k={k}$, largest", *top) for k, top in tops.items()),
        ruling(falls),
        "$alpha$ (here $K/2$), the time step",
    )


def cn_maximum(evidence: Evidence) -> Claim:
    """The largest strain of lattice and wave on the cn background at the later snapshots."""
    found, below = [], []
    for time in evidence.scenes[ROGUE].snapshots[1:]:
        lattice, wave = evidence.peaks(ROGUE, time)
        below.append(lattice.value + lattice.error < wave)
        found += [
            Measurement(f"$t={time:g}$, lattice", *lattice),
            Measurement(f"$t={time:g}$, wave", wave),
        ]
    return Claim(
        "cn_maximum",
        "On the cn background the lattice's maximum of $y_n/eps$ is always below the wave's",
        tuple(found),
        ruling(*below),
        "the time; at $t_0$ the two are equal",
    )


def dn_fit(evidence: Evidence) -> Claim:
    """The dn soliton's errors, with both denominators."""
    last = evidence.scenes[SOLITON].end
    bare = evidence.relative_error(SOLITON, last)
    far = evidence.relative_error(SOLITON, last, "error_far_field")
    return Claim(
        "dn_fit",
        "The dn soliton fits very well",
        (
            Measurement(f"$t={last:g}$, over the bare wave", *bare),
            Measurement(f"$t={last:g}$, over the far field", *far),
        ),
        ruling(bare.value < TWENTY_PERCENT),
        "$|t| <= 100$; 'very well' is read as below 20 %",
    )


def modulational_instability(evidence: Evidence) -> Claim:
    """By how much the fastest perturbation of each background grows within the time shown."""
    found = []
    for name in (ROGUE, SOLITON, "breather_sn_k_0.7"):
        scene = evidence.scenes[name]
        growth = math.exp(trust_in(scene, USUAL_TOLERANCE).rate * (scene.end - scene.t0))
        found.append(Measurement(f"{name.split('_')[1]} background, growth", growth))
    return Claim(
        "modulational_instability",
        "The deviations on the cn background can result from its modulational instability, the "
        "good fits on sn and dn from their stability",
        tuple(found),
        ruling(found[0].value > 2.0),
        "the time shown, 200 units: read as a growth of the fastest perturbation by more than 2",
    )
