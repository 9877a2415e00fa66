"""Losses of a scene's lattice, as the table [losses] says them, of waves and of chains on a bench.

``site`` is the factor g of the force ``-g du/dt`` on each cell, or a table of such by field;
``bond`` that of a dashpot beside each spring, or a list with one for each. They are numbers, or
formulas in the constants, new ones among them, and, under a wave, in eps: ``"eps**3*gamma"``.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from longwave.scenes import scene_checks as check
from longwave.support.known_names import one_of
from longwave.support.user_files import shown

if TYPE_CHECKING:
    from sympy import Expr

    from longwave.derive import Lattice
    from longwave.lattice.driving import DrivenChain
    from longwave.lattice.numeric_lattice import NumericLattice

KINDS = {"site": 3, "bond": 1}
"""Keys of the table, and powers of eps with which numbers under a long wave are weighed."""

Table = Mapping[str, Any]


def losses_json(given: object) -> str:
    """The table in one spelling, empty for none; ValueError in one line for what is none.

    >>> losses_json({"site": "eps**3*gamma", "bond": 0.5})
    '{"site": "eps**3*gamma", "bond": 0.5}'
    """
    if isinstance(given, str | None):
        given = json.loads(given or "{}")
    if not isinstance(given, Mapping):
        raise ValueError(f"losses must be a table, got {shown(given)} (write [losses])")
    for key in given:
        if key not in KINDS:
            raise ValueError(
                f"keys in [losses] must be known ones, got {check.plain(key)} "
                f"({one_of(key, KINDS)})"
            )
    found = _each(given, _checked)
    return json.dumps(found) if found else ""


def _each(table: Table, change: Callable[[str, Any], Any]) -> dict[str, Any]:
    """The table with each of its values changed, by its key."""
    found: dict[str, Any] = {}
    for key, given in table.items():
        if isinstance(given, Mapping) and key == "site":
            found[key] = {str(name): change(key, value) for name, value in given.items()}
        elif isinstance(given, list | tuple) and key == "bond":
            found[key] = [change(key, value) for value in given]
        else:
            found[key] = change(key, given)
    return found


def _checked(key: str, given: object) -> str | float:
    found = check.value(f"{key} in [losses]", given)
    if not isinstance(found, str) and found < 0:
        raise ValueError(f"{key} in [losses] must be 0 or more, got {found:g} (a loss)")
    return found


def weighed(losses: str, eps: float) -> str:
    """The table with numbers as what they are at that eps: of cells eps^3, of bonds eps times one.

    >>> weighed('{"bond": 0.5}', 0.1)
    '{"bond": "eps**1*(0.5/0.1**1)"}'
    """

    def formula(key: str, given: str | float) -> str:
        if isinstance(given, str):
            return given
        return f"eps**{KINDS[key]}*({given!r}/{eps!r}**{KINDS[key]})"

    return losses and json.dumps(_each(json.loads(losses), formula))


def lossy(lattice: Lattice, losses: str) -> Lattice:
    """The lattice with the table's losses; ValueError in one line for those that it cannot have."""
    if not losses:
        return lattice
    table = json.loads(losses)
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
