"""Numerics of a scene: a stated discretisation, or a tolerance."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from longwave.lattice.schemes import Scheme, scheme_named
from longwave.scenes.description import entries
from longwave.scenes.description import scene_checks as check

NUMERICS = ("step", "domain", "sites", "scheme", "tolerance", "engine")
"""Keywords of `Discretisation` and `Tolerance`."""


@dataclass(frozen=True, kw_only=True)
class DomainRules:
    """Rules for scenes that state a domain.

    A domain that ``moves`` with its wave drops cells. It admits only long waves, on lattices with
    equal cells and without losses. ``ends_meet`` marks a ring whose ends are blended into each
    other; only scenes of the paper's waves name it, since rings of other waves always are.
    """

    moves: bool = False
    ends_meet: bool = False


@dataclass(frozen=True, kw_only=True)
class EngineRules:
    """Rules for scenes that name an engine.

    An engine without ``steps_cells`` admits no scheme, stated step, disorder or losses.
    """

    steps_cells: bool = True


@dataclass(frozen=True)
class Discretisation:
    """Stated discretisation of a scene that is computed site by site.

    ``step`` is the largest time step. ``domain`` is a ``window`` that moves with a wave on a
    constant background, a fixed ``ring``, or a ``closed_ring``, whose ends are blended smoothly.
    ``sites`` is its number of cells. Raises ValueError for inadmissible values.
    """

    step: float
    domain: str
    sites: int
    scheme: str = "kahan_li_8"

    def __post_init__(self) -> None:
        for key in ("domain", "scheme"):
            check.text(key, getattr(self, key))
        object.__setattr__(self, "step", check.finite("step", self.step))
        scheme_named(self.scheme)
        object.__setattr__(self, "sites", check.whole("sites", self.sites))
        check.positive("step", self.step)
        check.one_of("domain", self.domain, tuple(entries.table(DomainRules)))

    @property
    def rules(self) -> DomainRules:
        """Rules of the domain, from the entry that ``domain`` names."""
        return entries.table(DomainRules)[self.domain]

    @property
    def table(self) -> Scheme:
        """Coefficients of the scheme that ``scheme`` names."""
        return scheme_named(self.scheme)

    def __str__(self) -> str:
        kind = self.domain.replace("_", " ")
        return f"{self.scheme}, step {self.step:g}, {kind} of {self.sites} sites"


@dataclass(frozen=True)
class Tolerance:
    """Tolerance of a scene for which the program chooses scheme, step and domain.

    ``tolerance`` bounds the sup error of y/eps over the compared sites, relative to the infinite
    lattice started from the same data. ``engine`` and ``scheme`` are optional names. Raises
    ValueError for inadmissible values.
    """

    tolerance: float
    engine: str = ""
    scheme: str = ""

    def __post_init__(self) -> None:
        for key in ("engine", "scheme"):
            check.text(key, getattr(self, key))
        object.__setattr__(self, "tolerance", check.tolerance(self.tolerance))
        if self.engine:
            check.one_of("engine", self.engine, tuple(entries.table(EngineRules)))
        if self.scheme:
            scheme_named(self.scheme)
            if not self.steps_cells:
                raise ValueError(
                    f"scheme must not be given for engine {self.engine!r}, got {self.scheme!r} "
                    "(it has its own)"
                )

    @property
    def steps_cells(self) -> bool:
        """Whether the named engine advances the lattice cell by cell; True if none is named."""
        return not self.engine or entries.table(EngineRules)[self.engine].steps_cells

    def __str__(self) -> str:
        names = ", ".join(text for text in (self.engine, self.scheme) if text)
        return f"to {self.tolerance:g}" + (f" by {names}" if names else "")


def numerics_of(given: Mapping[str, Any]) -> Discretisation | Tolerance:
    """Return the numerics that a scene's keywords state; None and "" count as not stated."""
    values = {key: given[key] for key in NUMERICS if key in given and given[key] not in (None, "")}
    engine, scheme = values.get("engine", ""), values.get("scheme", "")
    if "tolerance" in values:
        for key in ("step", "domain", "sites"):
            if values.get(key):
                raise ValueError(
                    f"{key} must not be given with a tolerance, got {values[key]} "
                    "(the tolerance determines it; leave out one of the two)"
                )
        return Tolerance(values["tolerance"], engine, scheme)
    engines = entries.table(EngineRules)
    if engine and not engines[check.one_of("engine", engine, tuple(engines))].steps_cells:
        raise ValueError(
            f"tolerance must be given for engine {engine!r}, got none (it takes no step)"
        )
    stated = values.get("step", 0.0), values.get("domain", ""), values.get("sites", 0)
    return Discretisation(*stated, scheme) if scheme else Discretisation(*stated)
