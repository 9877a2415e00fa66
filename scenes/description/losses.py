"""Losses of a scene's lattice from the table [losses], for waves and for chains on a bench.

``site`` is the factor g of the force ``-g du/dt`` on each cell, or a table of factors by field.
``bond`` is the factor of a dashpot parallel to each spring, or a list with one for each spring.
Factors are numbers or formulas in the constants, which may introduce new constants. Under a wave
they may contain eps: ``"eps**3*gamma"``.
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

EPS_POWERS = {"site": 3, "bond": 1}
"""Power of eps by which the numbers under each key of [losses] scale under a long wave."""


@dataclass(frozen=True)
class Losses:
    """Losses of a scene's lattice as stated in its table.

    ``site`` is one rate, or pairs of field and rate; ``bond`` is one rate, or one for each spring.
    None means no loss. Raises ValueError for a negative number.

    >>> Losses.of({"site": "eps**3*gamma", "bond": 0.5})
    Losses(site='eps**3*gamma', bond=0.5)
    """

    site: Value | tuple[tuple[str, Value], ...] | None = None
    bond: Value | tuple[Value, ...] | None = None

    @classmethod
    def of(cls, given: object) -> Losses | None:
        """Return the losses of a table, its JSON or a record; None if the table is empty."""
        if isinstance(given, Losses):
            return given
        if isinstance(given, str | None):
            given = json.loads(given or "{}")
        stated = check.as_table("losses", given)
        check.refuse_unknown(stated, EPS_POWERS, " in [losses]")
        return cls.of_rates(stated, _check_rate) if stated else None

    @classmethod
    def of_rates(cls, table: Mapping[str, Any], change: Callable[[str, Any], Value]) -> Losses:
        """Return the losses of a table with each rate replaced by ``change(key, rate)``."""
        losses: dict[str, Any] = {}
        for key, given in table.items():
            if isinstance(given, Mapping) and key == "site":
                losses[key] = tuple((str(name), change(key, rate)) for name, rate in given.items())
            elif isinstance(given, list | tuple) and key == "bond":
                losses[key] = tuple(change(key, rate) for rate in given)
            else:
                losses[key] = change(key, given)
        return cls(**losses)

    @property
    def table(self) -> dict[str, Any]:
        """Losses as the table [losses] of a scene file; rates by field are a nested table."""
        site = dict(self.site) if isinstance(self.site, tuple) else self.site
        bond = [*self.bond] if isinstance(self.bond, tuple) else self.bond
        return {key: rate for key, rate in (("site", site), ("bond", bond)) if rate is not None}

    def __str__(self) -> str:
        return json.dumps(self.table)

    def as_eps_formulas(self, eps: float) -> Losses:
        """Return the losses as formulas in eps that have the stated values at ``eps``.

        A numeric ``site`` rate becomes a multiple of eps**3, a numeric ``bond`` rate a multiple of
        eps.

        >>> Losses(bond=0.5).as_eps_formulas(0.1)
        Losses(site=None, bond='eps**1*(0.5/0.1**1)')
        """

        def formula(key: str, given: Value) -> str:
            if isinstance(given, str):
                return given
            return f"eps**{EPS_POWERS[key]}*({given!r}/{eps!r}**{EPS_POWERS[key]})"

        return self.of_rates(self.table, formula)


def _check_rate(key: str, given: object) -> Value:
    rate = check.value(f"{key} in [losses]", given)
    if not isinstance(rate, str) and rate < 0:
        raise ValueError(f"{key} in [losses] must be 0 or more, got {rate:g} (a loss)")
    return rate


def lossy(lattice: Lattice, losses: Losses | None) -> Lattice:
    """Return the lattice with the losses; ValueError if they do not match its springs or fields."""
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
    """Loss rates of each field and each bond, as numbers."""

    sites: list[float]
    bonds: list[float]

    def on(self, lattice: NumericLattice, cells: int) -> DrivenChain:
        """Return the lattice with these losses on a ring of ``cells`` cells."""
        from longwave.lattice.driving import driven_chain

        return driven_chain(lattice, cells, losses=self.sites, dashpots=self.bonds)


def loss_rates(lattice: Lattice, values: Mapping[str, Expr]) -> LossRates | None:
    """Return a lattice's losses at these values of its constants and eps; None without losses."""
    from longwave.derive.symbols import eps

    if not lattice.has_losses:
        return None
    substitutions = {s: values[str(s)] for s in (*lattice.constants, eps) if str(s) in values}
    rows = []
    for losses in (lattice.site_losses, [bond.loss for bond in lattice.bonds]):
        rates = [loss.xreplace(substitutions) for loss in losses]
        for rate in rates:
            if not rate.is_number:
                raise ValueError(
                    f"losses must be numbers here, got {rate} (state its constants in "
                    "[constants]; only a wave has an eps)"
                )
        rows.append([float(rate) for rate in rates])
    return LossRates(*rows)


def without_losses(
    lattice: Lattice, values: Mapping[str, Expr]
) -> tuple[NumericLattice, LossRates | None]:
    """Return the numeric lattice without its losses, and the losses as numbers."""
    from longwave.lattice.numeric_lattice import numeric_lattice

    bare = lattice.with_losses() if lattice.has_losses else lattice
    loss_constants = {*map(str, lattice.constants)} - {*map(str, bare.constants)}
    known = {name: value for name, value in values.items() if name not in loss_constants}
    return numeric_lattice(bare, known), loss_rates(lattice, values)
