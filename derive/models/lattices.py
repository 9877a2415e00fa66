"""Catalogue of lattices. To add one, add an entry here and a line in ``LATTICES``."""

from dataclasses import replace

from sympy import Expr, Integer, Rational, Symbol, exp

from longwave.derive.algebra.contact import contact
from longwave.derive.lattice import Bond, Lattice, Stencil, on_site, spring
from longwave.derive.symbols import K2, K3, K4, x
from longwave.support.known_names import NamedEntries

H2 = Symbol("H2", positive=True)
H3, H4, L2, L3, L4 = (Symbol(name, real=True) for name in ("H3", "H4", "L2", "L3", "L4"))
m1, m2, m3 = (Symbol(name, positive=True) for name in ("m1", "m2", "m3"))
g1 = Symbol("g1", positive=True)
g2, g3 = Symbol("g2", real=True), Symbol("g3", real=True)
A, d, r, E = (Symbol(name, positive=True) for name in ("A", "d", "r", "E"))
a, b = Symbol("a", positive=True), Symbol("b", positive=True)

ONE = Integer(1)


def cubic(*constants: Expr) -> Expr:
    """Return the force ``K2 x + K3 x^2 + ...`` with the ``constants`` K2, K3, ..."""
    return sum((value * x**power for power, value in enumerate(constants, 1)), Integer(0))


FORCE, SECOND = cubic(K2, K3, K4), cubic(H2, H3, H4)

NEAREST = Bond(
    stretch=(Stencil((0,)),), force=FORCE, action=(Stencil((1,)), Stencil((0,), -2), Stencil((-1,)))
)
"""Bond between neighbours of a chain whose variable is the strain."""

NEXT_NEAREST = Bond(
    stretch=(Stencil((0,)), Stencil((1,))),
    force=cubic(L2, L3, L4),
    action=(Stencil((1,)), Stencil((0,), -1), Stencil((-1,), -1), Stencil((-2,))),
)
"""Bond between next-nearest neighbours of a chain whose variable is the strain."""


def degenerate(*further: Expr) -> tuple[Bond, Bond]:
    """Return two springs whose third-order dispersion cancels, so that the fifth order leads.

    ``further`` are K3, K4, L3, L4.
    """
    near, far = cubic(K2, *further[:2]), cubic(-K2 / 16, *further[2:])
    return replace(NEAREST, force=near), replace(NEXT_NEAREST, force=far)


def chain(name: str, title: str, force: Expr, *further: Bond, mass: Expr = ONE) -> Lattice:
    """Return a chain of equal masses in the displacement, with further bonds or on-site forces."""
    bonds = (spring(force, ((0,), 0), ((1,), 0)), *further)
    return Lattice(name, title, ("u",), (mass,), bonds)


def cell(name: str, title: str, masses: tuple[Expr, ...], forces: tuple[Expr, ...]) -> Lattice:
    """Return a chain with several masses in a cell; ``forces[i]`` joins mass i to the next mass."""
    count = len(masses)
    ends = [((0,), field) for field in range(count)] + [((1,), 0)]
    bonds = tuple(spring(force, ends[i], ends[i + 1]) for i, force in enumerate(forces))
    return Lattice(name, title, ("u", "v", "w")[:count], masses, bonds)


def strain(name: str, title: str, *bonds: Bond) -> Lattice:
    """Return a chain of unit masses in the strain."""
    return Lattice(name, title, ("y",), (ONE,), bonds)


FPUT_STRAIN = strain("fput_strain", "FPUT lattice in the strain y_n = u_{n+1} - u_n", NEAREST)
"""The lattice of the paper's eqs. (2) and (3), in the strain: the paper's eq. (4)."""

_ALL = (
    FPUT_STRAIN,
    strain(
        "next_nearest",
        "FPUT lattice with springs between next-nearest neighbours, in the strain",
        *(NEAREST, NEXT_NEAREST),
    ),
    strain(
        "next_nearest_degenerate",
        "FPUT lattice with springs L2 = -K2/16 between next-nearest neighbours, in the strain",
        *degenerate(K3, K4, L3, L4),
    ),
    strain(
        "next_nearest_degenerate_odd",
        "cubic FPUT lattice, next-nearest springs L2 = -K2/16, in the strain",
        *degenerate(Integer(0), K4, Integer(0), L4),
    ),
    chain("fput", "FPUT lattice in the displacement", FORCE),
    chain("alpha_fput", "alpha-FPUT lattice in the displacement", cubic(K2, K3)),
    chain("beta_fput", "beta-FPUT lattice in the displacement", cubic(K2, Integer(0), K4)),
    cell("mass_dimer", "two masses in turn, equal springs", (m1, m2), (FORCE, FORCE)),
    cell("dimer", "two masses and two springs in turn", (m1, m2), (FORCE, SECOND)),
    cell("triatomic", "three masses in turn, equal springs", (m1, m2, m3), (FORCE,) * 3),
    chain(
        "klein_gordon",
        "Klein-Gordon chain: linear springs, each site tied to its place",
        cubic(K2),
        on_site(cubic(g1, g2, g3)),
    ),
    Lattice(
        "local_resonators",
        "chain of local resonators: a mass in each mass",
        ("u", "v"),
        (m1, m2),
        (spring(FORCE, ((0,), 0), ((1,), 0)), spring(SECOND, ((0,), 0), ((0,), 1))),
    ),
    chain("toda", "Toda lattice in the displacement", a * (exp(b * x) - 1)),
    chain(
        "granular",
        "granular chain under precompression d: Hertz contacts, which may open",
        -A * contact(d - x) ** Rational(3, 2),
    ),
    chain(
        "lennard_jones",
        "chain of atoms at the distance r of least energy -E",
        12 * E / r * ((r / (r + x)) ** 7 - (r / (r + x)) ** 13),
    ),
    Lattice(
        "square",
        "square lattice, one displacement a site: springs K along n, H along m",
        ("u",),
        (ONE,),
        (spring(FORCE, ((0, 0), 0), ((1, 0), 0)), spring(SECOND, ((0, 0), 0), ((0, 1), 0))),
    ),
)

LATTICES = NamedEntries("lattice", {lattice.name: lattice for lattice in _ALL})
"""Lattices of the catalogue by name."""
