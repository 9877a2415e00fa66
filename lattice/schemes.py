"""Time-stepping schemes as coefficient tables, and their stability limits.

Drift-kick splittings of y'' = f(y) exploit that the kinetic energy is quadratic. They need to
satisfy only the Nystroem conditions, fewer than those of a general composition; their free weights
are chosen for a small error. Long waves are nearly linear, so most of that error is a wrong speed,
which a higher phase-lag order removes. At a sup error of 1e-6 of Y2 the method of order 6 and
phase-lag order 8 evaluates the force half as often as Blanes and Moan's of order 6, and a quarter
as often as Kahan and Li's of order 8 (`benchmarks/same_lattice.py`).

A table's shape and consistency are checked when it is declared, its order by `check_order`. To add
a scheme, add its table to `SCHEMES`.
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields
from fractions import Fraction
from functools import cache, cached_property
from itertools import accumulate, pairwise
from typing import Any

import numpy as np

from longwave.lattice.scheme_order import NystroemTable, nystroem_defect, phase_lag_defect
from longwave.support.known_names import one_of
from longwave.support.real_arrays import Array, Mask
from longwave.support.user_files import shown

Exact = tuple[Fraction, ...]


class Scheme:
    """A time-stepping scheme as a table; `lattice.stepper.advance` runs it.

    ``name`` is its name in a scene, ``order`` its order of convergence in the step, ``reference``
    the source of its coefficients. Tables are values: equal ones have equal hashes.
    """

    name: str
    order: int
    reference: str

    def __reduce__(self) -> tuple[Callable[..., "Scheme"], tuple[object, ...]]:
        if any(scheme is self for scheme in SCHEMES):
            return scheme_named, (self.name,)
        kind: Any = type(self)
        return kind, tuple(getattr(self, entry.name) for entry in fields(kind))

    @property
    def rounding(self) -> float:
        """Tolerance of the order conditions, which depends on the number of digits in the table."""
        return 0.0

    @cached_property
    def stages(self) -> int:
        """Number of force evaluations per step."""
        return len(self.table().weights)

    def table(self) -> NystroemTable:
        """Return the scheme as an explicit Nystroem method."""
        raise NotImplementedError

    @cached_property
    def floats(self) -> tuple[Array, ...]:
        """Coefficients of `table` as arrays of doubles: nodes, inner, outer, weights."""
        return tuple(map(_floats, self.table()))

    def oscillator(self, z: Array) -> Array:
        """Return one step of y'' = -y with each of the steps ``z``, as matrices (len(z), 2, 2)."""
        raise NotImplementedError


class DriftKick(Scheme):
    """Splitting scheme: drifts y += drift h s, first and last, and kicks s += kick h f(y)."""

    @cached_property
    def exact(self) -> tuple[Exact, Exact]:
        """Drifts and kicks in units of the step, as fractions."""
        raise NotImplementedError

    def __post_init__(self) -> None:
        for weights in self.exact:
            defect = float(abs(sum(weights) - 1))
            if defect > self.rounding:
                raise ValueError(
                    f"the weights of {self.name} must sum to 1 to {self.rounding:g}, got a defect "
                    f"of {defect:.1e} (check the digits)"
                )

    @cached_property
    def drifts(self) -> Array:
        """Drift lengths in units of the step."""
        return _floats(self.exact[0])

    @cached_property
    def kicks(self) -> Array:
        """Kick lengths in units of the step."""
        return _floats(self.exact[1])

    def table(self) -> NystroemTable:
        """Return the scheme as an explicit Nystroem method."""
        drifts, kicks = self.exact
        nodes = list(accumulate(drifts))[:-1]
        inner = [
            [b * (c - d) for b, d in zip(kicks[:i], nodes, strict=False)]
            for i, c in enumerate(nodes)
        ]
        outer = [b * (1 - c) for b, c in zip(kicks, nodes, strict=True)]
        return NystroemTable(nodes, inner, outer, kicks)

    def oscillator(self, z: Array) -> Array:
        """Return one step of y'' = -y with each of the steps ``z``, as matrices (len(z), 2, 2)."""
        step = np.tile(np.eye(2)[..., None], len(z))
        for drift, kick in zip(self.drifts, [*self.kicks, 0.0], strict=True):
            step[0] += drift * z * step[1]
            step[1] -= kick * z * step[0]
        return np.moveaxis(step, -1, 0)


@dataclass(frozen=True)
class Composition(DriftKick):
    """A symmetric composition of Stoermer-Verlet steps with the weights ``gammas``.

    ``half`` holds the weights up to the middle one, as decimal literals of 26 digits. Raises
    ValueError if they do not sum to 1.
    """

    name: str
    order: int
    half: tuple[str, ...]
    reference: str
    rounding = 1e-24

    @property
    def gammas(self) -> tuple[str, ...]:
        """All weights, first to last."""
        return self.half + self.half[-2::-1]

    @cached_property
    def exact(self) -> tuple[Exact, Exact]:
        """Drifts and kicks as fractions; half of each kick's weight drifts on either side of it."""
        kicks = tuple(map(Fraction, self.gammas))
        ends = [Fraction(0), *kicks, Fraction(0)]
        return tuple((a + b) / 2 for a, b in pairwise(ends)), kicks


@dataclass(frozen=True)
class Splitting(DriftKick):
    """A symmetric splitting, given by decimal literals or fractions up to the middle.

    ``drift_half`` holds the drifts up to the middle, ``kick_half`` the kicks. If there is one drift
    more than kicks, the last drift is the middle of the step; otherwise the last kick is.
    ``phase_order`` is the phase-lag order if it exceeds the order. Raises ValueError if the drifts
    or the kicks do not sum to 1.
    """

    name: str
    order: int
    drift_half: tuple[str, ...]
    kick_half: tuple[str, ...]
    reference: str
    phase_order: int = 0

    def __post_init__(self) -> None:
        if len(self.drift_half) - len(self.kick_half) not in (0, 1):
            raise ValueError(
                f"drift_half must have as many weights as kick_half or one more, got "
                f"{len(self.drift_half)} and {len(self.kick_half)} in {self.name} "
                "(give each up to the middle of the step)"
            )
        super().__post_init__()

    @property
    def rounding(self) -> float:
        """Tolerance of order conditions: 100 units in the last place of the shortest decimal."""
        literals = self.drift_half + self.kick_half
        decimals = [len(literal.partition(".")[2]) for literal in literals if "." in literal]
        return 10.0 ** (2.0 - min(decimals)) if decimals else 0.0

    @cached_property
    def exact(self) -> tuple[Exact, Exact]:
        """Drifts and kicks in units of the step, as fractions."""
        middle_is_kick = len(self.kick_half) == len(self.drift_half)
        drifts = _mirrored(self.drift_half, not middle_is_kick)
        return drifts, _mirrored(self.kick_half, middle_is_kick)


def _mirrored(half: tuple[str, ...], once: bool) -> Exact:
    """Return ``half`` and its reflection; the last entry occurs once if ``once``, else twice."""
    return tuple(map(Fraction, half + half[::-1][once:]))


@dataclass(frozen=True)
class RungeKutta(Scheme):
    """An explicit Runge-Kutta table (A, b), run in its Nystroem form on y'' = D V'(y).

    The Runge-Kutta and the Nystroem form are the same method: y' = s is linear, so its stages can
    be eliminated. Raises ValueError if A is not square and strictly lower triangular or b does not
    sum to 1.
    """

    name: str
    order: int
    A: tuple[tuple[Fraction, ...], ...]
    b: tuple[Fraction, ...]
    reference: str

    def __post_init__(self) -> None:
        if any(len(row) != len(self.b) for row in (*self.A, self.A)):
            raise ValueError(
                f"A must have {len(self.b)} rows and columns, as many as b, got another shape in "
                f"{self.name} (fill the table with zeros)"
            )
        if any(value for i, row in enumerate(self.A) for value in row[i:]):
            raise ValueError(
                f"A must be strictly lower triangular, got another in {self.name} "
                "(only explicit schemes can be run)"
            )
        if sum(self.b) != 1:
            raise ValueError(f"b must sum to 1, got {sum(self.b)} in {self.name} (check the table)")

    def table(self) -> NystroemTable:
        """Return nodes A 1, inner weights A A, position weights b A and velocity weights b."""
        A, b = np.array(self.A, dtype=object), np.array(self.b, dtype=object)
        return NystroemTable(A.sum(axis=1).tolist(), (A @ A).tolist(), (b @ A).tolist(), self.b)

    def oscillator(self, z: Array) -> Array:
        """Return one step of y'' = -y with each of the steps ``z``, as matrices (len(z), 2, 2)."""
        generator = np.array([[0.0, 1.0], [-1.0, 0.0]])
        table, weights = _floats(self.A), _floats(self.b)
        step, power = np.tile(np.eye(2), (len(z), 1, 1)), np.eye(2)
        stage = np.ones(self.stages)
        for degree in range(1, self.stages + 1):
            power = power @ generator
            step += (weights @ stage) * z[:, None, None] ** degree * power
            stage = table @ stage
        return step


def _floats(values: Iterable[object]) -> Array:
    return np.asarray(values, dtype=object).astype(np.float64)


SCANNED_STEPS = np.linspace(0.0, 8.0, 80_001)[1:]
"""Steps, in units of 1/omega, at which stability is checked before bisection."""

SCAN_PIECES = 80
"""Number of pieces of `SCANNED_STEPS`, checked until one has an unstable step; each fits the
cache."""

JURY_SLACK = 1e-12
"""Rounding allowed for an eigenvalue on the unit circle."""


def _stable(scheme: Scheme, z: Array) -> Mask:
    """Return a mask of steps z of y'' = -y with both eigenvalues in the unit disc (Jury's test)."""
    step = scheme.oscillator(z)
    trace = step[:, 0, 0] + step[:, 1, 1]
    determinant = step[:, 0, 0] * step[:, 1, 1] - step[:, 0, 1] * step[:, 1, 0]
    return np.asarray(
        (np.abs(trace) <= 1.0 + determinant + JURY_SLACK) & (determinant <= 1.0 + JURY_SLACK)
    )


@cache
def stability_limit(scheme: Scheme) -> float:
    """Return the largest z = omega h below which y'' = -omega^2 y stays bounded.

    Scanned in steps of 1e-4 up to 8, the largest value returned, then refined by bisection.

    >>> from longwave.lattice.schemes import scheme_named
    >>> round(stability_limit(scheme_named("stoermer_verlet")), 6)
    2.0
    >>> round(stability_limit(scheme_named("rk4")) ** 2, 6)
    8.0
    """
    pieces = np.split(SCANNED_STEPS, SCAN_PIECES)
    unstable_steps = (piece[~_stable(scheme, piece)] for piece in pieces)
    high = next((float(unstable[0]) for unstable in unstable_steps if unstable.size), None)
    if high is None:
        return float(SCANNED_STEPS[-1])
    low = high - float(SCANNED_STEPS[0])
    for _ in range(40):
        middle = 0.5 * (low + high)
        if _stable(scheme, np.array([middle]))[0]:
            low = middle
        else:
            high = middle
    return low


def check_step(step: float, scheme: Scheme, highest_frequency: float) -> float:
    """Return the largest stable step for a frequency; raise ValueError if ``step`` exceeds it."""
    limit = stability_limit(scheme) / highest_frequency
    if step > limit:
        raise ValueError(
            f"step must satisfy step <= {limit:.7g}, got {step:.9g} "
            f"(linear stability limit of {scheme.name} at the zone boundary k = pi; "
            "take a smaller step)"
        )
    return limit


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


def check_order(scheme: Scheme) -> None:
    """Raise ValueError unless the scheme has its order, and its phase-lag order if it states one.

    The conditions are those for y'' = f(y) only, evaluated exactly; the tolerance allows for the
    digits of the table.

    >>> check_order(Composition("verlet", 2, ("1",), ""))
    >>> check_order(Composition("verlet", 4, ("1",), ""))
    Traceback (most recent call last):
    ValueError: verlet must satisfy the conditions of order 4 to 1e-24, got a defect of 1.7e-01 ...
    """
    checks = [("order", scheme.order, nystroem_defect(scheme.table(), scheme.order))]
    if isinstance(scheme, Splitting) and scheme.phase_order:
        defect = phase_lag_defect(*scheme.exact, scheme.phase_order)
        checks.append(("phase-lag order", scheme.phase_order, defect))
    for kind, order, defect in checks:
        if defect > scheme.rounding:
            raise ValueError(
                f"{scheme.name} must satisfy the conditions of {kind} {order} to "
                f"{scheme.rounding:g}, got a defect of {defect:.1e} (check the digits)"
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
    """Return the scheme with this name, or the one that the text ``name`` defines.

    A symmetric splitting of your own is defined by its weights up to the middle of the step, as in
    `Splitting`, and checked against the conditions of its order. Raises ValueError, listing the
    known names, for any other text.

    >>> scheme_named("rk4").stages
    4
    >>> scheme_named("mine, order 2: drifts 1/6 2/3, kicks 1/2").stages
    2
    """
    for scheme in SCHEMES:
        if scheme.name == name:
            return scheme
    if ":" in name:
        return _user_defined(name)
    known = one_of(name, [scheme.name for scheme in SCHEMES])
    raise ValueError(f"scheme must be a known one, got {shown(name)} ({known}; or {EXAMPLE})")


EXAMPLE = "'mine, order 2: drifts 1/6 2/3, kicks 1/2'"
"""Example of a text that defines a scheme."""

USER_DEFINED = re.compile(r"([A-Za-z]\w{,39}), order (\d{1,2}): drifts ([^,]+), kicks ([^,]+)")

WEIGHT = re.compile(r"-?\d{1,9}(\.\d{1,60}|/[1-9]\d{,9})?")

HIGHEST_ORDER, MOST_WEIGHTS = 10, 20
"""Highest order and largest number of weights of a user-defined scheme (high orders have many
conditions)."""


@cache
def _user_defined(text: str) -> Scheme:
    """Parse a user-defined scheme. Raises ValueError if its text or order is wrong."""
    parts = USER_DEFINED.fullmatch(text)
    if parts is None:
        raise ValueError(f"scheme must be defined as {EXAMPLE}, got {shown(text)}")
    order, drifts, kicks = int(parts[2]), *(tuple(parts[group].split()) for group in (3, 4))
    for weight in (*drifts, *kicks):
        if not WEIGHT.fullmatch(weight):
            raise ValueError(
                f"weights of a scheme must be decimals or fractions, got {shown(weight)} (such as "
                "0.5 or 1/2)"
            )
    for name, size, most in (
        ("order", order, HIGHEST_ORDER),
        ("weights", len(drifts), MOST_WEIGHTS),
    ):
        if not 1 <= size <= most:
            raise ValueError(f"{name} of a scheme must be 1 to {most}, got {size} (change it)")
    scheme = Splitting(text, order, drifts, kicks, "stated")
    check_order(scheme)
    return scheme
