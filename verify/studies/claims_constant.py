"""The paper's statements about lattice runs from the rational waves."""

from verify.studies.claims_evidence import PARTS, RK4_STEP, SPLIT, MeasuredRuns, rk4_name
from verify.studies.claims_record import Claim, Measurement, ruling

TWENTY_PERCENT = 0.2
RUN_ORDERS = (2, 3)
EPSILONS = ("0.05", "0.075")


def peak_of_the_error(evidence: MeasuredRuns) -> Claim:
    """The time of the largest error of each rational run, and what it is at the peak of one."""
    found, near = [], []
    for j in RUN_ORDERS:
        for eps in EPSILONS:
            name = f"rational_{j}_eps_{eps}"
            largest, time = evidence.largest_error(name)
            scene = evidence.scenes[name]
            near.append(abs(time) < 0.1 * (scene.end - scene.t0))
            found.append(Measurement(f"$Y_{j}$, $eps={eps}$, at $t={time:.0f}$", *largest))
    found += _split(evidence)
    return Claim(
        "peak_of_the_error",
        "The error is largest around the time of the largest amplitude ($t=0$)",
        tuple(found),
        ruling(*near),
        "$t_0$, $eps$; 'around' is read as within 10 % of the time shown",
    )


def _split(evidence: MeasuredRuns) -> list[Measurement]:
    """The error of one run at its peak, taken apart: where the lattice's crest is, and the rest."""
    parts = evidence.split(SPLIT, 0.0)
    words = "$Y_2$, $eps=0.05$, $t=0$, the lattice's wave is shifted by sites"
    shares = (Measurement(f"there, part by {name}", *parts[name]) for name in PARTS)
    return [Measurement(words, *parts["shift"]), *shares]


def error_against_order(evidence: MeasuredRuns) -> Claim:
    """Third-order against second-order error, at all times and at their largest."""
    found, always = [], []
    for eps in EPSILONS:
        names = [f"rational_{j}_eps_{eps}" for j in RUN_ORDERS]
        second, third = (evidence.runs[name]["error_curve"].values for name in names)
        higher = second < third
        tops = [evidence.largest_error(name)[0] for name in names]
        always += [tops[0].value < tops[1].value, bool(higher.all())]
        found += [
            Measurement(f"$eps={eps}$, $Y_{j}$, largest", *top)
            for j, top in zip(RUN_ORDERS, tops, strict=True)
        ]
        share = 100 * float(higher.mean())
        found.append(Measurement(f"$eps={eps}$, % of the times at which $Y_3$ is higher", share))
    return Claim(
        "error_against_order",
        "The error is higher, the higher the order",
        tuple(found),
        ruling(*always),
        "the time: it may hold for the largest error and not at every moment",
    )


def twenty_percent(evidence: MeasuredRuns) -> Claim:
    """Third order at eps = 0.05, with an accurate scheme and with RK4's step."""
    names = {"": "rational_3_eps_0.05", f"RK4, $dt={RK4_STEP}$, ": rk4_name(3)}
    tops = {words: evidence.largest_error(name)[0] for words, name in names.items()}
    return Claim(
        "twenty_percent",
        "The error of $Y_3$ does not exceed 20 % at $eps=0.05$",
        tuple(Measurement(f"{words}largest", *top) for words, top in tops.items()),
        ruling(*(top.value < TWENTY_PERCENT for top in tops.values())),
        "the time step, of which the paper states none",
    )


def second_order_crest(evidence: MeasuredRuns) -> Claim:
    """Second order at t = 0, with an accurate scheme and with RK4's step."""
    names = {"": "rational_2_eps_0.05", f"RK4, $dt={RK4_STEP}$, ": rk4_name(2)}
    tops = {words: evidence.relative_error(name, 0.0) for words, name in names.items()}
    return Claim(
        "second_order_crest",
        "$Y_2$ fits reasonably well at $eps=0.05$",
        tuple(Measurement(f"{words}$t=0$", *top) for words, top in tops.items()),
        ruling(tops[""].value < TWENTY_PERCENT),
        "the time step, the crest's place in its cell (here on site 0); 'reasonably' is read as "
        "below 20 %",
    )


def third_order_agreement(evidence: MeasuredRuns) -> Claim:
    """Third order at both eps."""
    found, good = [], []
    for eps in EPSILONS:
        largest, time = evidence.largest_error(f"rational_3_eps_{eps}")
        found.append(Measurement(f"$eps={eps}$, largest, at $t={time:.0f}$", *largest))
        good.append(largest.value < TWENTY_PERCENT)
    return Claim(
        "third_order_agreement",
        "Very good agreement of $Y_3$, at $eps=0.05$ and also at $0.075$",
        tuple(found),
        ruling(*good),
        "$eps$, and what 'very good' means; here read as below 20 %",
    )
