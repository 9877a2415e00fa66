"""Expected seconds of a derivation: symbols grow with the order, the fields and the constants.

Measured in processor time on a 3 GHz server, over the catalogue and chains of 2 to 10 different
masses or springs. The laws are orders of magnitude: for 20 derivations with several fields that
took more than 0.3 s they gave 0.2 to 7 times the measured time.
"""

from longwave.derive.lattice import Lattice, Stencil

SECONDS_PER_BOND = 0.15
"""Seconds for each bond of a lattice with one field, at any allowed order."""

THIRD_ORDER_SECONDS, THIRD_ORDER_CONSTANTS, THIRD_ORDER_EXPONENT = 0.12, 6.0, 5.0
"""For a lattice with several fields: seconds of the third order beyond the reduced equation with
``THIRD_ORDER_CONSTANTS`` constants, and the power of their number with which the seconds grow."""

PI_SECONDS, PI_FACTOR_PER_CONSTANT, PI_FACTOR_PER_FIELD = 0.06, 2.8, 6.0
"""Seconds of the envelope at k = pi with two fields and five constants; factor for each further
constant; factor for each further field."""

NUMERIC_SECONDS, NUMERIC_FACTOR_PER_FIELD = 0.3, 2.0
"""Seconds of the envelope at other wavenumbers with two fields and numbers for all constants; a
factor for each further field."""

SYMBOLIC_SECONDS, SYMBOLIC_FACTOR_PER_CONSTANT, MAX_SYMBOLIC_SECONDS = 1.0, 6.0, 5.0
"""Seconds that five symbolic constants add at wavenumbers other than pi; factor for each further
constant; most seconds that are added, because `carrier_envelope` refuses larger formulas."""

FACTOR_PER_CELL = 30.0
"""Factor of an envelope's seconds for each further cell that a bond spans (one field, k not pi)."""

CHEAPER_ORDER = "take a lower --order, or a FILE.toml with numbers instead of constants"
CHEAPER_CARRIER = "take --envelope k=pi, or give constants by --set"


def reduction_seconds(lattice: Lattice, further: int) -> float:
    """Return the seconds to derive ``further`` orders beyond the reduced equation.

    >>> from longwave.derive import LATTICES
    >>> [f"{reduction_seconds(LATTICES['dimer'], further):.2g}" for further in (2, 4, 5, 8)]
    ['0.37', '3.8', '25', '8.5e+03']
    """
    plain = SECONDS_PER_BOND * len(lattice.bonds)
    if len(lattice.fields) == 1:
        return plain
    constants = max(3, len(lattice.constants))
    third_order = THIRD_ORDER_SECONDS * (constants / THIRD_ORDER_CONSTANTS) ** THIRD_ORDER_EXPONENT
    return plain + third_order * (constants - 1.0) ** (further - 3)


def envelope_seconds(lattice: Lattice, at_pi: bool, given: int = 0) -> float:
    """Return the seconds to derive a carrier's envelope at wavenumber pi (``at_pi``), else at any.

    ``given`` is the number of constants with values.

    >>> from longwave.derive import LATTICES
    >>> [f"{envelope_seconds(LATTICES['mass_dimer'], at_pi):.2g}" for at_pi in (True, False)]
    ['0.06', '1.3']
    """
    if len(lattice.fields) == 1:
        return PI_SECONDS * (1.0 if at_pi else FACTOR_PER_CELL ** min(_range(lattice) - 1, 6))
    constants, further = max(0, len(lattice.constants) - given), len(lattice.fields) - 2
    if at_pi:
        return PI_SECONDS * PI_FACTOR_PER_CONSTANT ** (constants - 5) * PI_FACTOR_PER_FIELD**further
    growth = SYMBOLIC_FACTOR_PER_CONSTANT ** (constants - 5)
    added = min(SYMBOLIC_SECONDS * growth, MAX_SYMBOLIC_SECONDS) if constants else 0.0
    numeric = NUMERIC_SECONDS * NUMERIC_FACTOR_PER_FIELD**further
    return numeric + added * PI_FACTOR_PER_FIELD**further


def _range(lattice: Lattice) -> int:
    """Return the number of cells that the longest bond spans."""

    def span(entries: tuple[Stencil, ...]) -> int:
        shifts = [entry.shift[0] for entry in entries]
        return max(shifts) - min(shifts)

    return max(1, *((span(bond.stretch) + span(bond.action)) // 2 for bond in lattice.bonds))
