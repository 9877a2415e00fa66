"""How a scene is computed: with a stated discretisation, or to a tolerance."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from longwave.lattice.schemes import Scheme, scheme_named
from longwave.scenes.description import entries
from longwave.scenes.description import scene_checks as check

NUMERICS = ("step", "domain", "sites", "scheme", "tolerance", "engine")
"""The keywords of both records."""


@dataclass(frozen=True, kw_only=True)
class DomainRules(entries.Entry):
    """Rules for scenes that state a domain.

    One that ``moves`` with its wave drops cells, so it takes long waves on a lattice that is the
    same in all cells and loses nothing. That its ``ends_meet`` is stated for the paper's waves
    alone: those of others always do.
    """

    moves: bool = False
    ends_meet: bool = False


@dataclass(frozen=True, kw_only=True)
class EngineRules(entries.Entry):
    """Rules for scenes that name an engine.

    One that does not step cells takes no scheme, no stated step and no disorder or losses.
    """

    steps_cells: bool = True


@dataclass(frozen=True)
class Discretisation:
    """A scene computed site by site, with everything stated.

    ``step`` is the largest time step. ``domain`` is a ``window`` that moves with the wave, for
    constant backgrounds, a fixed ``ring``, or a ``closed_ring``, whose ends pass smoothly into each
    other; it has so many ``sites``. Raises ValueError in one line.
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
        """The entry of its domain."""
        return entries.table(DomainRules)[self.domain]

    @property
    def table(self) -> Scheme:
        """The scheme itself."""
        return scheme_named(self.scheme)

    def __str__(self) -> str:
        kind = self.domain.replace("_", " ")
        return f"{self.scheme}, step {self.step:g}, {kind} of {self.sites} sites"


@dataclass(frozen=True)
class Tolerance:
    """A scene computed to ``tolerance``, the program choosing scheme, step and domain.

    It is the sup error of y/eps over the compared sites, against the infinite lattice started from
    the same data. ``engine`` and ``scheme`` may be named. Raises ValueError in one line.
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
        """Whether the engine steps cells, as the usual one does."""
        return not self.engine or entries.table(EngineRules)[self.engine].steps_cells

    def __str__(self) -> str:
        named = ", ".join(text for text in (self.engine, self.scheme) if text)
        return f"to {self.tolerance:g}" + (f" by {named}" if named else "")


def numerics_of(given: Mapping[str, Any]) -> Discretisation | Tolerance:
    """The record among keywords; older files leave what does not apply empty."""
    found = {key: given[key] for key in NUMERICS if key in given and given[key] not in (None, "")}
    engine, scheme = found.get("engine", ""), found.get("scheme", "")
    if "tolerance" in found:
        for key in ("step", "domain", "sites"):
            if found.get(key):
                raise ValueError(
                    f"{key} must not be given with a tolerance, got {found[key]} "
                    "(the tolerance determines it; leave out one of the two)"
                )
        return Tolerance(found["tolerance"], engine, scheme)
    engines = entries.table(EngineRules)
    if engine and not engines[check.one_of("engine", engine, tuple(engines))].steps_cells:
        raise ValueError(
            f"tolerance must be given for engine {engine!r}, got none (it takes no step)"
        )
    stated = found.get("step", 0.0), found.get("domain", ""), found.get("sites", 0)
    return Discretisation(*stated, scheme) if scheme else Discretisation(*stated)
