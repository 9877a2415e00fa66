"""Forces of a chain of equal masses as the checker of waves reads them."""

from __future__ import annotations

from sympy import Expr, Symbol, nsimplify

from longwave.derive.algebra.contact import contact
from longwave.derive.algebra.formula_printing import formula_as_text
from longwave.derive.lattice import Bond, Lattice
from longwave.derive.symbols import x
from longwave.waves.kernel.chain_reading import MAX_NEIGHBOUR
from longwave.waves.kernel.force_text import Force, read_force
from longwave.waves.kernel.limits import CertificateError
from longwave.waves.kernel.periodic import Spring


class Refused(ValueError):
    """Error raised for a wave or lattice to which no theorem applies."""


def chain_springs(lattice: Lattice) -> tuple[Spring, ...]:
    """Return the springs of a chain of equal masses, with the forces divided by the mass.

    Raises Refused for any other lattice, and ValueError for constants without a value.

    >>> from longwave.derive import LATTICES
    >>> lattice = LATTICES["fput_strain"].with_values({"K2": 1, "K3": 0, "K4": "1/2"})
    >>> [(spring.neighbour, spring.force.text) for spring in chain_springs(lattice)]
    [(1, 'r**3/2 + r')]
    """
    return _springs(lattice, 1)


def chain_forces(lattice: Lattice) -> tuple[Spring, ...]:
    """Return the springs of a chain of equal masses, and the force on each site as 0-th spring.

    Raises Refused for a lattice not stated in displacements, and otherwise as `chain_springs`.

    >>> from longwave.derive import LATTICES
    >>> lattice = LATTICES["klein_gordon"].with_values({"K2": "1/9", "g1": 1, "g2": 0, "g3": 1})
    >>> [(spring.neighbour, spring.force.text) for spring in chain_forces(lattice)]
    [(0, 'r**3 + r'), (1, 'r/9')]
    """
    if not lattice.has_displacements:
        raise Refused("the field must be a displacement, not a strain (such as fput)")
    return _springs(lattice, 0)


def _springs(lattice: Lattice, least: int) -> tuple[Spring, ...]:
    if lattice.constants:
        names = ", ".join(map(str, lattice.constants))
        raise ValueError(f"constants must have values, got none for {names} (such as K2=1)")
    if len(lattice.fields) != 1:
        raise Refused(f"the lattice must have one field, got {', '.join(lattice.fields)}")
    if lattice.has_losses:
        raise Refused("the lattice must have no losses: with them no wave keeps its form")
    springs: dict[int, Expr] = {}
    for bond in lattice.bonds:
        neighbour = _neighbour(bond, least)
        springs[neighbour] = springs.get(neighbour, 0) + bond.force / lattice.masses[0]
    return tuple(Spring(m, _force(springs[m])) for m in sorted(springs))


def _force_text(force: Expr) -> str:
    closed = force.replace(contact, lambda at: at)
    return formula_as_text(nsimplify(closed, rational=True).xreplace({x: Symbol("r")}))


def _force(force: Expr) -> Force:
    try:
        return read_force(_force_text(force))
    except CertificateError as error:
        raise Refused(str(error)) from error


def _neighbour(bond: Bond, least: int) -> int:
    """Return m for a bond between m-th neighbours, stated for displacements or for strains.

    The force on a site has m = 0, which ``least`` = 1 excludes.
    """
    stretch, action = (
        {entry.shift: entry.weight for entry in entries} for entries in (bond.stretch, bond.action)
    )
    if least == 0 and (stretch, action) == ({(0,): 1}, {(0,): -1}):
        return 0
    for m in range(1, MAX_NEIGHBOUR + 1):
        displacements = {(m,): 1, (0,): -1}, {(0,): 1, (-m,): -1}
        second = {(1,): 1, (0,): -1, (1 - m,): -1, (-m,): 1}
        strains = {(i,): 1 for i in range(m)}, second if m > 1 else {(1,): 1, (0,): -2, (-1,): 1}
        if (stretch, action) in (displacements, strains):
            return m
    raise Refused(
        "every bond must be a spring between m-th neighbours of one chain, "
        f"m <= {MAX_NEIGHBOUR}, got the stretch {stretch}"
    )
