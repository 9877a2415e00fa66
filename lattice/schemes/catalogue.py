"""The catalogue of schemes. Adding one is one table here; tests check its order conditions."""

from fractions import Fraction

from lattice.schemes.scheme import Composition, RungeKutta, Scheme, Splitting

_0, _HALF, _1 = Fraction(0), Fraction(1, 2), Fraction(1)

RK4 = RungeKutta(
    name="rk4",
    order=4,
    A=(
        (_0, _0, _0, _0),
        (_HALF, _0, _0, _0),
        (_0, _HALF, _0, _0),
        (_0, _0, _1, _0),
    ),
    b=(Fraction(1, 6), Fraction(1, 3), Fraction(1, 3), Fraction(1, 6)),
    reference="Kutta 1901; the paper's scheme",
)

STOERMER_VERLET = Composition(
    name="stoermer_verlet",
    order=2,
    half=("1",),
    reference="Hairer, Lubich, Wanner, Acta Numerica 12 (2003) 399",
)

SUZUKI_UMENO_8 = Composition(
    name="suzuki_umeno_8",
    order=8,
    half=(
        "0.74167036435061295344822780",
        "-0.40910082580003159399730010",
        "0.19075471029623837995387626",
        "-0.57386247111608226665638773",
        "0.29906418130365592384446354",
        "0.33462491824529818378495798",
        "0.31529309239676659663205666",
        "-0.79688793935291635401978884",
    ),
    reference="Suzuki, Umeno 1993, 15 stages; Hairer, Lubich, Wanner, GNI, section V.3.2",
)

KAHAN_LI_8 = Composition(
    name="kahan_li_8",
    order=8,
    half=(
        "0.13020248308889008087881763",
        "0.56116298177510838456196441",
        "-0.38947496264484728640807860",
        "0.15884190655515560089621075",
        "-0.39590389413323757733623154",
        "0.18453964097831570709183254",
        "0.25837438768632204729397911",
        "0.29501172360931029887096624",
        "-0.60550853383003451169892108",
    ),
    reference="Kahan, Li 1997, 17 stages; Hairer, Lubich, Wanner, GNI, section V.3.2",
)

MCLACHLAN_4 = Splitting(
    name="mclachlan_4",
    order=4,
    drift_half=("0.40518861839525227722", "-0.28714404081652408900", "0.38195542242127181178"),
    kick_half=("-3/73", "17/59", "2179/4307"),
    reference="McLachlan, SIAM J. Sci. Comput. 16 (1995) 151, SB3A with 5 stages",
)

BLANES_MOAN_6 = Splitting(
    name="blanes_moan_6",
    order=6,
    drift_half=(
        "0.0378593198406116",
        "0.102635633102435",
        "-0.0258678882665587",
        "0.314241403071447",
        "-0.130144459517415",
        "0.106417700369543",
        "-0.00879424312851058",
        "0.2073050690568954",
    ),
    kick_half=(
        "0.09171915262446165",
        "0.183983170005006",
        "-0.05653436583288827",
        "0.004914688774712854",
        "0.143761127168358",
        "0.328567693746804",
        "-0.19641146648645423",
    ),
    reference="Blanes, Moan, J. Comput. Appl. Math. 142 (2002) 313, SRKN 14a of order 6",
)

REDUCED_PHASE_6 = Splitting(
    name="reduced_phase_6",
    order=6,
    drift_half=(
        "0.02630326121015110780308557102295",
        "0.10734879598149237352174996660561",
        "-0.01049628716496408483660660039303",
        "0.15961110713515186284804499147734",
        "0.16111166525746726061905943498217",
        "0.13881921373214868578404472817905",
        "-0.08269775615144720573937809187409",
    ),
    kick_half=(
        "0.07116838769198220445697717038840",
        "0.27020247705620322093337665924754",
        "-0.12586929830540811456108351644380",
        "0.15212324113167785131370730712159",
        "0.13664354161102701639888393821651",
        "-0.04401448119336451822387092703190",
        "0.07949226401576467936401873700331",
    ),
    reference=(
        "13 stages, solved for here: order 6, phase-lag order 8 (van der Houwen, Sommeijer, "
        "SIAM J. Numer. Anal. 24 (1987) 595), no unstable band at z = pi; the four weights that "
        "are left make the errors on five lattice waves small"
    ),
    phase_order=8,
)

SCHEMES: tuple[Scheme, ...] = (
    RK4,
    STOERMER_VERLET,
    MCLACHLAN_4,
    BLANES_MOAN_6,
    REDUCED_PHASE_6,
    SUZUKI_UMENO_8,
    KAHAN_LI_8,
)


def scheme_named(name: str) -> Scheme:
    """The scheme of that name; ValueError lists the known ones.

    >>> scheme_named("rk4").stages
    4
    """
    for scheme in SCHEMES:
        if scheme.name == name:
            return scheme
    known = ", ".join(scheme.name for scheme in SCHEMES)
    raise ValueError(f"scheme must be a known one, got {name!r} (one of {known})")
