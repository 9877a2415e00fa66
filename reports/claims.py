"""The paper's quantitative statements beside what was measured here."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import sympy as sp

from reports.evidence import RK4_STEP, Evidence, rk4_name
from solutions import closed_form
from solutions.symbols import k, tau, xi

CONFIRMED = "confirmed"
NOT_CONFIRMED = "not confirmed"
DEPENDS = "depends"

TWENTY_PERCENT = 0.2
RATIONAL_ORDERS = (2, 3)
RATIONAL_EPS = ("0.05", "0.075")
BREATHER_MODULI = ("0.5", "0.6", "0.7")


@dataclass(frozen=True)
class Claim:
    """One statement of the paper: LaTeX texts, and a verdict drawn from the numbers."""

    statement: str
    measured: str
    verdict: str
    depends_on: str


def verdict(*holds: bool) -> str:
    """Put truth values into the table's words: all hold, none does, or it depends."""
    if all(holds):
        return CONFIRMED
    return DEPENDS if any(holds) else NOT_CONFIRMED


def peaks_of_the_waves(_: Evidence) -> Claim:
    """Peaks 5 and 7 at the origin, and that of the cn rogue wave, from the expressions."""
    origin = {xi: 0, tau: 0}
    values = [closed_form(f"rational_{j}").expression.subs(origin) for j in RATIONAL_ORDERS]
    rogue = sp.simplify(closed_form("rogue_cn").expression.subs(origin).doit())
    exact = [sp.Integer(2 * j + 1) for j in RATIONAL_ORDERS]
    return Claim(
        "$Y_j$ has the value $2j+1$ at the origin",
        f"$Y_2={values[0]}$, $Y_3={values[1]}$ (exact); cn rogue wave ${sp.latex(rogue)}$ (exact)",
        verdict(values == exact and rogue.free_symbols <= {k}),
        "nothing",
    )


def error_peaks_with_the_wave(evidence: Evidence) -> Claim:
    """The time of the largest error of each rational run."""
    shown, near = [], []
    for j in RATIONAL_ORDERS:
        for eps in RATIONAL_EPS:
            name = f"rational_{j}_eps_{eps}"
            largest, time = evidence.largest_error(name)
            scene = evidence.scenes[name]
            near.append(abs(time) < 0.1 * (scene.end - scene.t0))
            shown.append(rf"$Y_{j}$, $\epsilon={eps}$: {largest.latex()} at $t={time:.0f}$")
    return Claim(
        "The error is largest around the time of the largest amplitude ($t=0$)",
        r"\newline ".join(shown),
        verdict(*near),
        r"$t_0$, $\epsilon$; ``around'' is read as within 10\,\% of the time shown",
    )


def error_grows_with_the_order(evidence: Evidence) -> Claim:
    """Third-order against second-order error, at all times and at their largest."""
    shown, always = [], []
    for eps in RATIONAL_EPS:
        names = [f"rational_{j}_eps_{eps}" for j in RATIONAL_ORDERS]
        second, third = (evidence.runs[name]["error_curve"].values for name in names)
        higher = second < third
        tops = [evidence.largest_error(name)[0] for name in names]
        always += [tops[0].value < tops[1].value, bool(higher.all())]
        shown.append(
            rf"$\epsilon={eps}$: largest {tops[0].latex()} and {tops[1].latex()}; "
            rf"higher at {100 * higher.mean():.0f}\,\% of the times"
        )
    return Claim(
        "The error is higher, the higher the order",
        r"\newline ".join(shown),
        verdict(*always),
        "the time: true of the largest error, not of every moment",
    )


def error_stays_below_20_percent(evidence: Evidence) -> Claim:
    """Third order at eps = 0.05, with an accurate scheme and with RK4's step."""
    numbers = [evidence.largest_error(name)[0] for name in ("rational_3_eps_0.05", rk4_name(3))]
    return Claim(
        r"The error of $Y_3$ does not exceed 20\,\% at $\epsilon=0.05$",
        rf"largest {numbers[0].latex()}\newline RK4, $\Delta t={RK4_STEP}$: {numbers[1].latex()}",
        verdict(*(number.value < TWENTY_PERCENT for number in numbers)),
        "the time step: the paper states none",
    )


def error_of_the_second_order_crest(evidence: Evidence) -> Claim:
    """Second order at t = 0, with an accurate scheme and with RK4's step."""
    accurate = evidence.relative_error("rational_2_eps_0.05", 0.0)
    rk4 = evidence.relative_error(rk4_name(2), 0.0)
    return Claim(
        r"$Y_2$ fits reasonably well at $\epsilon=0.05$",
        rf"$t=0$: {accurate.latex()}\newline RK4, $\Delta t={RK4_STEP}$, $t=0$: {rk4.latex()}",
        verdict(accurate.value < TWENTY_PERCENT),
        r"the time step, the crest's place in its cell (here on site 0); ``reasonably'' is read "
        r"as below 20\,\%",
    )


def third_order_at_the_larger_eps(evidence: Evidence) -> Claim:
    """Third order at eps = 0.075."""
    largest, time = evidence.largest_error("rational_3_eps_0.075")
    return Claim(
        r"Very good agreement of $Y_3$, also at $\epsilon=0.075$",
        rf"largest {largest.latex()} at $t={time:.0f}$",
        verdict(largest.value < TWENTY_PERCENT),
        r"what ``very good'' means; here read as below 20\,\%",
    )


def breather_error_falls_with_k(evidence: Evidence) -> Claim:
    """The dark breather's largest error at the three moduli."""
    tops = [evidence.largest_error(f"breather_sn_k_{modulus}")[0] for modulus in BREATHER_MODULI]
    falls = all(a.value > b.value for a, b in pairwise(tops))
    shown = [f"$k={m}$: {top.latex()}" for m, top in zip(BREATHER_MODULI, tops, strict=True)]
    return Claim(
        "On the sn background the agreement is better for larger $k$",
        r"\newline ".join(shown),
        verdict(falls),
        r"$\alpha$ (here $K/2$), the time step",
    )


def cn_lattice_stays_below_the_wave(evidence: Evidence) -> Claim:
    """The largest strain of lattice and wave on the cn background at the later snapshots."""
    name = "rogue_cn_k_0.5"
    shown, below = [], []
    for time in evidence.scenes[name].snapshots[1:]:
        lattice, wave = evidence.peaks(name, time)
        below.append(lattice.value + lattice.error < wave)
        shown.append(rf"$t={time:g}$: {lattice.latex()} against ${wave:.5f}$")
    return Claim(
        r"On the cn background the lattice's maximum $y_n/\epsilon$ is always below the wave's",
        r"\newline ".join(shown),
        verdict(*below),
        r"the time; at $t_0$ the two are equal",
    )


def dn_soliton_fits(evidence: Evidence) -> Claim:
    """The dn soliton's errors, with both denominators."""
    name = "soliton_dn_k_0.7"
    last = evidence.scenes[name].end
    bare = evidence.relative_error(name, last)
    far = evidence.relative_error(name, last, "error_far_field")
    return Claim(
        "The dn soliton fits very well",
        rf"$t={last:g}$: {bare.latex()} over the bare wave\newline "
        rf"{far.latex()} over the far field",
        verdict(bare.value < TWENTY_PERCENT),
        r"$|t|\le 100$; ``very well'' is read as below 20\,\%",
    )


CLAIMS: tuple[Callable[[Evidence], Claim], ...] = (
    peaks_of_the_waves,
    error_of_the_second_order_crest,
    error_peaks_with_the_wave,
    error_grows_with_the_order,
    error_stays_below_20_percent,
    third_order_at_the_larger_eps,
    breather_error_falls_with_k,
    dn_soliton_fits,
    cn_lattice_stays_below_the_wave,
)


def all_claims(evidence: Evidence) -> list[Claim]:
    """Return every claim with the numbers of these runs."""
    return [claim(evidence) for claim in CLAIMS]
