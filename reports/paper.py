r"""Numbers of the paper's equations, figures and sections by label; sources of the closed forms.

The numbers are those that LaTeX gives the paper's source, with equations numbered consecutively.
"""

from longwave.support.known_names import one_of

EQUATIONS = (
    "standard mKdV", "FPUT lattice in displacement", "(3)", "FPUT in strain",
    "ldr of the FPUT lattice", "positive branch ldr", "multi-scale variables",
    "asympototic results", "Eq.1 first-order", "eq: relation to construct IC for sn",
    "IC for sn", "mKdV 2-order soln", "(13)", "nece coefficients", "(15)",
    "eq: def of L_inf loss", "third-order soln of mKdV", "(18)", "Jacobi's theta funcs", "(20)",
    "dark breather on snoidal-wave", "coefficients of a and b",
    "alg-decaying solitons on dn-wave background", "(24)", "def. of theta",
    "rogue-wave on cn-wave", "(27)", "defn. of theta_cn", "Defn of five para",
)  # fmt: skip
"""LaTeX labels of the paper's numbered equations in order; "(3)" is one without a label."""

UNNUMBERED = {"Eq.2 first-order": "Eq.1 first-order"}
"""Labels of equation lines without a number -> the label of the line whose number they share."""

FIGURES = (
    "Second-order solns comparison", "Third-order solns comparison", "L_inf loss plot",
    "dark-breather on dn-background", "DB error plot",
    "soliton solution on the dn-wave background", "rogue-wave on cn-background comparison",
)  # fmt: skip
"""LaTeX labels of the paper's figures in order."""

SECTIONS = {
    "Sec: Local waves on constant back": "IV",
    "subsec: Dark breathers on snoidal waves": "V~A",
}
"""LaTeX label of each cited section of the paper -> its number."""

SOURCES = {
    "ablowitz1981solitons": r"M.~J.~Ablowitz and H.~Segur, \emph{Solitons and the Inverse "
    r"Scattering Transform}, SIAM (1981).",
    "hirota1972exact": r"R.~Hirota, Exact solution of the modified Korteweg--de Vries equation "
    r"for multiple collisions of solitons, J. Phys. Soc. Jpn. \textbf{33} (1972) 1456.",
    "wadati1982multiple": r"M.~Wadati and K.~Ohkuma, Multiple-pole solutions of the modified "
    r"Korteweg--de Vries equation, J. Phys. Soc. Jpn. \textbf{51} (1982) 2029.",
    "clarke2000generation": r"S.~Clarke, R.~Grimshaw, P.~Miller, E.~Pelinovsky and T.~Talipova, "
    r"On the generation of solitons and breathers in the modified Korteweg--de Vries equation, "
    r"Chaos \textbf{10} (2000) 383.",
    "el2017dispersive": r"G.~A.~El, M.~A.~Hoefer and M.~Shearer, Dispersive and "
    r"diffusive-dispersive shock waves for nonconvex conservation laws, SIAM Rev. \textbf{59} "
    r"(2017) 3.",
    "ankiewicz2018rogue": r"A.~Ankiewicz and N.~Akhmediev, Rogue wave-type solutions of the mKdV "
    r"equation and their relation to known NLSE rogue wave solutions, Nonlinear Dyn. \textbf{91} "
    r"(2018) 1931.",
    "chen2018rogue": r"J.~Chen and D.~E.~Pelinovsky, Rogue periodic waves of the modified KdV "
    r"equation, Nonlinearity \textbf{31} (2018) 1955.",
    "mucalica2024dark": r"A.~Mucalica and D.~E.~Pelinovsky, Dark breathers on a snoidal wave "
    r"background in the defocusing mKdV equation, Lett. Math. Phys. \textbf{114} (2024) 100.",
}
"""Citation key in a closed form's record -> bibliography entry in LaTeX."""


def cited(label: str) -> str:
    """Return the paper's number for a label: equation, figure or section.

    >>> cited("third-order soln of mKdV"), cited("DB error plot")
    ('eq.~(17)', 'fig.~5')

    Raises ValueError for a label that the paper does not have.
    """
    numbered = UNNUMBERED.get(label, label)
    if numbered in EQUATIONS:
        return f"eq.~({EQUATIONS.index(numbered) + 1})"
    if label in FIGURES:
        return f"fig.~{FIGURES.index(label) + 1}"
    if label in SECTIONS:
        return f"sec.~{SECTIONS[label]}"
    known = one_of(label, (*EQUATIONS, *UNNUMBERED, *FIGURES, *SECTIONS))
    raise ValueError(f"label must be one of the paper's, got {label!r} ({known})")
