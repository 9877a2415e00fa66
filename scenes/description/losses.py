"""Losses of a scene's lattice, as the table [losses] says them, of waves and of chains on a bench.

``site`` is the factor g of the force ``-g du/dt`` on each cell, or a table of such by field;
``bond`` that of a dashpot beside each spring, or a list with one for each. They are numbers, or
formulas in the constants, new ones among them, and, under a wave, in eps: ``"eps**3*gamma"``.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from longwave.scenes.description import scene_checks as check
from longwave.scenes.description.scene_checks import Value

if TYPE_CHECKING:
    from sympy import Expr

    from longwave.derive import Lattice
    from longwave.lattice.driving import DrivenChain
    from longwave.lattice.numeric_lattice import NumericLattice

KINDS = {"site": 3, "bond": 1}
"""Keys of the table, and powers of eps with which numbers under a long wave are weighed."""


@dataclass(frozen=True)
class Losses:
    """Losses of a scene's lattice as its table states them.

    ``site`` is one rate or pairs of fields and rates, ``bond`` one rate or one for each spring;
    None where there are none. Raises ValueError in one line for a negative number.

    >>> Losses.of({"site": "eps**3*gamma", "bond": 0.5})
    Losses(site='eps**3*gamma', bond=0.5)
    """

    site: Value | tuple[tuple[str, Value], ...] | None = None
    bond: Value | tuple[Value, ...] | None = None

    @classmethod
    def of(cls, given: object) -> Losses | None:
        """Return the losses of a table, its JSON or a record; None if it states none."""
        if isinstance(given, Losses):
            return given
        if isinstance(given, str | None):
            given = json.loads(given or "{}")
        stated = check.as_table("losses", given)
        check.refuse_unknown(stated, KINDS, " in [losses]")
        return cls.of_rates(stated, _checked) if stated else None

    @classmethod
    def of_rates(cls, table: Mapping[str, Any], change: Callable[[str, Any], Value]) -> Losses:
        """Return the losses of a table with each rate changed, given its key and value."""
        found: dict[str, Any] = {}
        for key, given in table.items():
            if isinstance(given, Mapping) and key == "site":
                found[key] = tuple((str(name), change(key, rate)) for name, rate in given.items())
            elif isinstance(given, list | tuple) and key == "bond":
                found[key] = tuple(change(key, rate) for rate in given)
            else:
                found[key] = change(key, given)
        return cls(**found)

    @property
    def table(self) -> dict[str, Any]:
        """The table, with fields' rates as a table of its own."""
        site = dict(self.site) if isinstance(self.site, tuple) else self.site
        bond = [*self.bond] if isinstance(self.bond, tuple) else self.bond
        return {key: held for key, held in (("site", site), ("bond", bond)) if held is not None}

    def __str__(self) -> str:
        return json.dumps(self.table)

    def weighed(self, eps: float) -> Losses:
        """Return the losses as formulas in eps whose values at that eps are those stated.

        Numbers of cells become eps**3 and those of bonds eps times a number.

        >>> Losses(bond=0.5).weighed(0.1)
        Losses(site=None, bond='eps**1*(0.5/0.1**1)')
        """

        def formula(key: str, given: Value) -> str:
            if isinstance(given, str):
                return given
            return f"eps**{KINDS[key]}*({given!r}/{eps!r}**{KINDS[key]})"

        return self.of_rates(self.table, formula)


def _checked(key: str, given: object) -> Value:
    found = check.value(f"{key} in [losses]", given)
    if not isinstance(found, str) and found < 0:
        raise ValueError(f"{key} in [losses] must be 0 or more, got {found:g} (a loss)")
    return found


def lossy(lattice: Lattice, losses: Losses | None) -> Lattice:
    """Return the lattice with the losses; ValueError in one line for those it cannot have."""
    if losses is None:
        return lattice
    table = losses.table
    if isinstance(bonds := table.get("bond"), list):
        springs = [i for i, bond in enumerate(lattice.bonds, 1) if bond.has_reaction]
        if len(bonds) != len(springs):
            raise ValueError(
                f"bond in [losses] must be a loss for each of {len(springs)} springs of "
                f"{lattice.name}, got {len(bonds)} (or one value for all)"
            )
        table["bond"] = dict(zip(springs, bonds, strict=True))
    return lattice.with_losses(**table)


class LossRates(NamedTuple):
    """Losses with numbers in, of each field and each bond."""

    sites: list[float]
    bonds: list[float]

    def on(self, lattice: NumericLattice, cells: int) -> DrivenChain:
        """The lattice with the losses, on a ring of so many cells."""
        from longwave.lattice.driving import driven_chain

        return driven_chain(lattice, cells, losses=self.sites, dashpots=self.bonds)


def loss_rates(lattice: Lattice, values: Mapping[str, Expr]) -> LossRates | None:
    """The losses of a lattice at these values of its constants, and of eps; None without any."""
    from longwave.derive.symbols import eps

    if not lattice.has_losses:
        return None
    at = {s: values[str(s)] for s in (*lattice.constants, eps) if str(s) in values}
    found = []
    for losses in (lattice.site_losses, [bond.loss for bond in lattice.bonds]):
        rates = [loss.xreplace(at) for loss in losses]
        for rate in rates:
            if not rate.is_number:
                raise ValueError(
                    f"losses must be numbers here, got {rate} (a constant is stated in "
                    "[constants]; eps is that of a wave)"
                )
        found.append([float(rate) for rate in rates])
    return LossRates(*found)


def without_losses(
    lattice: Lattice, values: Mapping[str, Expr]
) -> tuple[NumericLattice, LossRates | None]:
    """The lattice with numbers, and the losses that it has, with numbers too."""
    from longwave.lattice.numeric_lattice import numeric_lattice

    bare = lattice.with_losses() if lattice.has_losses else lattice
    lost = {*map(str, lattice.constants)} - {*map(str, bare.constants)}
    known = {name: value for name, value in values.items() if name not in lost}
    return numeric_lattice(bare, known), loss_rates(lattice, values)
