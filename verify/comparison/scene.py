"""A scene: what to run, and which effects are wanted of it."""

import json
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path

from lattice.model import Model
from lattice.schemes.catalogue import scheme_named
from lattice.schemes.scheme import Scheme
from verify.comparison import checks as check
from verify.comparison.observables import observable_named
from verify.comparison.scene_file import read_scene_file

DOMAINS = ("window", "ring", "closed_ring")
ENGINES = ("stencil", "spectral")
DEFAULT_SCHEME = "kahan_li_8"


@dataclass(frozen=True)
class Scene:
    """One run, stated in full; numbers are checked when the record is made.

    Times are in units of the lattice, lengths in sites. ``compared`` is the half-width of the
    compared region about the site nearest to c t. How it is computed is stated in one of two ways:

    * ``step`` (the largest time step), ``domain`` (a ``window`` that moves with the wave, for
      constant backgrounds, a fixed ``ring``, or a ``closed_ring``, whose ends pass smoothly into
      each other), its size ``sites``, and ``scheme``;
    * ``tolerance``: the sup error of y/eps over the compared sites, against the infinite lattice
      started from the same data. The program then chooses engine, scheme, step and domain;
      ``engine`` and ``scheme`` may be named.

    The error curve is sampled at ``curve_points`` equidistant times and
    the snapshots; what is only looked at (energy, crest, ...) is seen at most as often, where the
    march stops anyway, or at ``look_points`` equidistant times if that is given. ``parameters`` are
    the wave's, as (name, value) pairs.

    Raises ValueError in one line: argument, condition, value, remedy.
    """

    name: str
    wave: str
    eps: float
    t0: float
    snapshots: tuple[float, ...]
    K2: float
    K4: float
    compared: int
    step: float = 0.0
    domain: str = ""
    sites: int = 0
    K3: float = 0.0
    parameters: tuple[tuple[str, float | str], ...] = ()
    observables: tuple[str, ...] = ("strain", "error_curve")
    scheme: str = ""
    tolerance: float | None = None
    engine: str = ""
    curve_points: int = 201
    look_points: int | None = None
    title: str = ""

    @classmethod
    def from_toml(cls, path: str | Path) -> "Scene":
        """Read a scene file (`scene_file.py` says what may stand in it)."""
        try:
            return cls(**read_scene_file(Path(path)))
        except ValueError as error:
            text = str(error)
            file = Path(path).name
            raise ValueError(text if file in text else f"{file}: {text}") from None

    def __post_init__(self) -> None:
        for key in ("wave", "title", "domain", "scheme", "engine"):
            check.text(key, getattr(self, key))
        for key in ("eps", "t0", "K2", "K3", "K4", "step"):
            object.__setattr__(self, key, check.finite(key, getattr(self, key)))
        for key in ("compared", "curve_points"):
            check.whole(key, getattr(self, key))
        check.positive("eps", self.eps)
        object.__setattr__(self, "snapshots", check.times(self.snapshots, self.t0))
        object.__setattr__(self, "observables", check.observables(self.observables))
        object.__setattr__(self, "parameters", check.parameters(self.parameters))
        if self.look_points is not None:
            check.whole("look_points", self.look_points)
        if self.engine:
            check.one_of("engine", self.engine, ENGINES)
        if self.tolerance is None:
            self._check_stated()
        else:
            self._check_chosen(self.tolerance)
        self.constants.sound_speed()

    def _check_stated(self) -> None:
        """The scene states scheme, step and domain."""
        object.__setattr__(self, "scheme", self.scheme or DEFAULT_SCHEME)
        scheme_named(self.scheme)
        check.whole("sites", self.sites)
        check.positive("step", self.step)
        check.enough_steps(self.step, self.end - self.t0)
        check.one_of("domain", self.domain, DOMAINS)
        if self.engine == "spectral":
            raise ValueError(
                "tolerance must be given for engine 'spectral', got none (it takes no step)"
            )
        for name in self.observables:
            if observable_named(name).needs_ring and self.domain == "window":
                raise ValueError(
                    f"domain must be 'ring' for {name}, got 'window' (a window drops sites)"
                )

    def _check_chosen(self, tolerance: float) -> None:
        """The scene leaves step and domain to the program."""
        check.tolerance(tolerance)
        for key in ("step", "domain", "sites"):
            if getattr(self, key):
                raise ValueError(
                    f"{key} must not be given with a tolerance, got {getattr(self, key)} "
                    "(the tolerance determines it; leave out one of the two)"
                )
        if self.scheme:
            scheme_named(self.scheme)
            if self.engine == "spectral":
                raise ValueError(
                    f"scheme must not be given for engine 'spectral', got {self.scheme!r} "
                    "(it has its own)"
                )
        for name in self.observables:
            if observable_named(name).seen == "refinement":
                raise ValueError(
                    f"observables must have no refinement with a tolerance, got {name} "
                    "(leave it out: the run reports an estimate of its own)"
                )

    @cached_property
    def constants(self) -> Model:
        """The lattice constants."""
        return Model(self.K2, self.K3, self.K4)

    @property
    def scheme_table(self) -> Scheme:
        """The scheme itself."""
        return scheme_named(self.scheme)

    @property
    def end(self) -> float:
        """The last time of the run."""
        return max(self.snapshots)

    def json(self) -> str:
        """The record as JSON, keys sorted."""
        return json.dumps(asdict(self), sort_keys=True)


def with_tolerance(scene: Scene, tolerance: float) -> Scene:
    """The scene with a tolerance in the place of its step, domain and measured refinements."""
    kept = (name for name in scene.observables if observable_named(name).seen != "refinement")
    scheme = scene.scheme if scene.tolerance is not None else ""
    chosen = {"scheme": scheme, "step": 0.0, "domain": "", "sites": 0}
    return replace(scene, tolerance=tolerance, observables=tuple(kept), **chosen)  # type: ignore[arg-type]
