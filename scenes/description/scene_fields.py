"""Fields of a scene, and properties computed from them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any

from longwave.lattice.model import Model
from longwave.scenes.description import entries
from longwave.scenes.description.bench import Bench
from longwave.scenes.description.losses import Losses, lossy
from longwave.scenes.description.numerics import Discretisation, Tolerance
from longwave.scenes.description.scene_checks import CHAIN, CHAIN_CONSTANTS, NOT_GIVEN, Pairs, Value
from longwave.scenes.description.scene_disorder import Disorder
from longwave.scenes.description.stated_tables import StatedTables
from longwave.support.known_names import one_of
from longwave.support.user_files import shown

if TYPE_CHECKING:
    from longwave.derive import Lattice
    from longwave.solutions import ClosedForm

HALF_WIDTH_ROUNDING = 1e-12
"""Relative excess of a half-width over a whole number of cells that is ignored as rounding."""


@dataclass(frozen=True, kw_only=True)
class StartRules:
    """Rules for all scenes with one kind of start, such as a closed form or a bench.

    ``method`` tells `engines.methods.method_of` which module runs them. ``measured`` names a
    quantity that is measured instead of comparing a wave; times and region are then computed.
    ``observables`` are the default ones. ``check`` raises ValueError for an inadmissible scene.
    """

    method: str = "ring"
    observables: tuple[str, ...] = ("strain",)
    measured: str = ""
    check: Callable[[SceneFields], None] = lambda _: None


BENCH = StartRules(method="bench", observables=())
MOVING_WAVE = StartRules(method="moving_wave", observables=("strain", "error_curve"))
CLOSED_FORM = StartRules()
"""`BENCH`: rules for chains on a bench; `MOVING_WAVE`: for scenes with `has_moving_wave`;
`CLOSED_FORM`: for all other closed forms."""


@dataclass(frozen=True, repr=False)
class SceneFields:
    """Fields of a `Scene`, which explains them, and properties computed from the fields."""

    name: str
    wave: str | ClosedForm
    eps: float
    numerics: Discretisation | Tolerance
    lattice: str = CHAIN
    constants: Pairs = ()
    parameters: Pairs = ()
    order: str = "leading"
    t0: float = NOT_GIVEN
    snapshots: tuple[float, ...] = ()
    slow_times: tuple[float, ...] = ()
    compared: int = 0
    half_width: float | None = None
    amplitude: int | None = None
    time: int | None = None
    background: Value = 0
    carrier: Value = ""
    branch: str | int = "acoustic"
    disorder: Disorder | None = None
    declared: StatedTables | None = None
    losses: Losses | None = None
    bench: Bench | None = None
    observables: tuple[str, ...] = None  # type: ignore[assignment] # those of the start
    curve_points: int = 201
    look_points: int | None = None
    title: str = ""

    @property
    def is_envelope(self) -> bool:
        """Whether the scene's wave is the envelope of a carrier."""
        return self.carrier != ""

    @property
    def named_start(self) -> StartRules | None:
        """Rules registered for a scene whose wave is not a closed form; None for a closed form."""
        return entries.table(StartRules).get(self.wave) if isinstance(self.wave, str) else None

    @property
    def start(self) -> StartRules:
        """Rules that apply to this scene, by the way in which its run starts."""
        if self.bench:
            return BENCH
        return self.named_start or (MOVING_WAVE if self.has_moving_wave else CLOSED_FORM)

    @property
    def is_growth(self) -> bool:
        """Whether a quantity such as a growth rate is measured and no wave is compared."""
        return bool(self.start.measured)

    @property
    def has_moving_wave(self) -> bool:
        """Whether the scene has a leading mKdV long wave on the paper's chain, with K3 = 0."""
        values = dict(self.constants)
        ansatz = (self.order, self.background, self.amplitude, self.time, self.carrier)
        effects = self.declared or self.disorder or self.losses or self.named_start or self.bench
        if self.lattice != CHAIN or effects or ansatz != ("leading", 0, None, None, ""):
            return False
        is_numeric = not any(isinstance(value, str) for value in values.values())
        return is_numeric and values.get("K3", 0) == 0

    @property
    def wave_name(self) -> str:
        """Name of the wave."""
        return self.wave if isinstance(self.wave, str) else self.wave.name

    @property
    def tolerance(self) -> float | None:
        """Tolerance as a number; None if the discretisation is stated instead."""
        return self.numerics.tolerance if isinstance(self.numerics, Tolerance) else None

    @property
    def discretisation(self) -> Discretisation:
        """Stated discretisation; ValueError if there is a tolerance instead."""
        if isinstance(self.numerics, Discretisation):
            return self.numerics
        raise ValueError(
            f"step, domain and sites must be stated for this, got a tolerance in {self.name} "
            "(give Discretisation(step, domain, sites))"
        )

    @property
    def target(self) -> Tolerance:
        """Tolerance as a record; ValueError if the discretisation is stated instead."""
        if isinstance(self.numerics, Tolerance):
            return self.numerics
        raise ValueError(
            f"tolerance must be given for this, got a stated step in {self.name} "
            "(give one: --tolerance, or Scene.with_tolerance)"
        )

    @property
    def own_bench(self) -> Bench:
        """Chain on a bench; ValueError if the scene compares a wave instead."""
        if self.bench is None:
            raise ValueError(
                f"scene must be a chain on a bench, got {self.name}, which compares a wave (state "
                "[chain] and [start])"
            )
        return self.bench

    @cached_property
    def model(self) -> Model:
        """Model of the paper's chain with the scene's K2, K3 and K4; 0 for missing constants."""
        values = dict(self.constants)
        return Model(*(float(values.get(name, 0.0)) for name in CHAIN_CONSTANTS))

    @property
    def form(self) -> ClosedForm:
        """Closed form of the wave; a ValueError for an unknown name lists the known ones."""
        from longwave.solutions import closed_form  # slow, not needed to read or show scenes

        if isinstance(self.wave, str):
            return closed_form(self.wave, dict(self.parameters))
        return self.wave

    @property
    def symbolic_lattice(self) -> Lattice:
        """Lattice in symbols, with its losses; ValueError if its name is unknown."""
        from longwave.derive import LATTICES
        from longwave.derive.lattice_file import lattice_of

        if self.declared:
            return lossy(lattice_of(self.declared.tables, self.lattice), self.losses)
        if self.lattice not in LATTICES:
            raise ValueError(
                f"lattice must be one of the catalogue or a file, got {shown(self.lattice)} "
                f"({one_of(self.lattice, LATTICES)}; or FILE.toml beside the scene)"
            )
        return lossy(LATTICES[self.lattice], self.losses)

    @property
    def end(self) -> float:
        """Last time of the run, in lattice time."""
        return self.snapshots[-1]

    def lattice_times(self, slow: int) -> tuple[float, ...]:
        """Return the start and the snapshots in lattice time t, where ``T = eps**slow t``."""
        if self.slow_times:
            return tuple(T / self.eps**slow for T in self.slow_times)
        return (self.t0, *(t for t in self.snapshots if t > self.t0))

    def cells_within(self, power: int) -> int:
        """Return the number of compared cells on either side, on an axis with X = eps^power n."""
        if self.half_width is None:
            return self.compared
        return max(1, math.ceil(self.half_width / self.eps**power * (1.0 - HALF_WIDTH_ROUNDING)))

    def check_compared(self) -> None:
        """Raise ValueError for a scene that compares no wave: a bench or a growth rate."""
        if self.bench:
            raise ValueError(
                f"scene must have a wave that the lattice is compared with, got {self.name}, a "
                "chain on a bench (`longwave run` and `sweep` take it)"
            )
        if self.is_growth:
            raise ValueError(
                f"wave must be one that a lattice is compared with, got {self.wave}, whose "
                f"{self.start.measured} is measured (`longwave run`, `sweep` and `plot` take it)"
            )

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields without cached properties."""
        return {entry.name: getattr(self, entry.name) for entry in fields(self)}
