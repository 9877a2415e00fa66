"""A scene: what to run, and which effects are wanted of it."""

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from importlib.resources import as_file, files
from pathlib import Path

from verify.lattice.constants import Constants
from verify.lattice.observables import NAMES, entry_named
from verify.lattice.scene_toml import read_scene_file
from verify.lattice.scheme import Scheme
from verify.lattice.schemes import scheme_named

OBSERVABLES = NAMES
DOMAINS = ("window", "ring")
FOLDER = files("verify.lattice.scenes")


@dataclass(frozen=True)
class Scene:
    """One run, stated in full; numbers are checked when the record is made.

    Times are in units of the lattice, lengths in sites. ``compared`` is the half-width of the
    compared region about the site nearest to c t; ``sites`` the size of the computed domain:
    a ``window`` that moves with the wave (constant backgrounds) or a fixed ``ring``. ``step`` is
    the largest time step. The error curve is sampled at ``curve_points`` equidistant times and
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
    step: float
    domain: str
    sites: int
    compared: int
    K3: float = 0.0
    parameters: tuple[tuple[str, float | str], ...] = ()
    observables: tuple[str, ...] = ("strain", "error_curve")
    scheme: str = "kahan_li_8"
    curve_points: int = 201
    look_points: int | None = None
    title: str = ""

    @classmethod
    def from_toml(cls, path: str | Path) -> "Scene":
        """Read a scene file (`scene_toml.py` says what may stand in it)."""
        try:
            return cls(**read_scene_file(Path(path)))
        except ValueError as error:
            text = str(error)
            file = Path(path).name
            raise ValueError(text if file in text else f"{file}: {text}") from None

    def __post_init__(self) -> None:
        for key in ("eps", "t0", "K2", "K3", "K4", "step"):
            object.__setattr__(self, key, _finite(key, getattr(self, key)))
        for key in ("sites", "compared", "curve_points"):
            _whole(key, getattr(self, key))
        object.__setattr__(self, "snapshots", _times(self.snapshots, self.t0))
        object.__setattr__(self, "observables", _observables(self.observables))
        object.__setattr__(self, "parameters", _parameters(self.parameters))
        for key in ("eps", "step"):
            if getattr(self, key) <= 0:
                raise ValueError(f"{key} must satisfy {key} > 0, got {getattr(self, key):g}")
        _one_of("domain", self.domain, DOMAINS)
        scheme_named(self.scheme)
        if self.look_points is not None:
            _whole("look_points", self.look_points)
        for name in self.observables:
            if entry_named(name).needs_ring and self.domain != "ring":
                raise ValueError(f"{name} needs domain 'ring', got 'window' (a window drops sites)")
        self.constants.sound_speed()

    @cached_property
    def constants(self) -> Constants:
        """The lattice constants."""
        return Constants(self.K2, self.K3, self.K4)

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


def shipped_scenes() -> tuple[str, ...]:
    """Names of the scenes that come with the package, sorted.

    >>> "rational_2_eps_0.05" in shipped_scenes()
    True
    """
    found = (entry.name for entry in FOLDER.iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in found if name.endswith(".toml")))


def load_scene(name: str) -> Scene:
    """The shipped scene of that name; ValueError lists the known ones."""
    if name not in shipped_scenes():
        raise ValueError(f"scene must be one of {', '.join(shipped_scenes())}, got {name!r}")
    with as_file(FOLDER / f"{name}.toml") as path:
        return Scene.from_toml(path)


def _finite(name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{name} must be a number, got {value!r}")
    if not math.isfinite(value):
        raise ValueError(f"{name} must be finite, got {value}")
    return float(value)


def _whole(name: str, value: object) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise ValueError(f"{name} must be a whole number >= 1, got {value!r}")


def _one_of(name: str, value: object, known: tuple[str, ...]) -> None:
    if value not in known:
        raise ValueError(f"{name} must be one of {', '.join(known)}, got {value!r}")


def _times(values: object, t0: float) -> tuple[float, ...]:
    if not isinstance(values, list | tuple) or not values:
        raise ValueError(f"snapshots must be a list of at least one time, got {values!r}")
    times = tuple(_finite("snapshots", value) for value in values)
    if min(times) < t0:
        raise ValueError(
            f"snapshots must satisfy t >= t0 = {t0:g}, got {min(times):g} (start earlier)"
        )
    if list(times) != sorted(set(times)):
        raise ValueError(f"snapshots must increase, got {list(times)}")
    return times


def _observables(values: object) -> tuple[str, ...]:
    if not isinstance(values, list | tuple):
        raise ValueError(f"observables must be a list of names, got {values!r}")
    for value in values:
        _one_of("observables", value, OBSERVABLES)
    return tuple(values)


def _parameters(
    values: Mapping[str, float | str] | tuple[tuple[str, float | str], ...],
) -> tuple[tuple[str, float | str], ...]:
    pairs = values.items() if isinstance(values, Mapping) else values
    return tuple(
        (str(name), value if isinstance(value, str) else _finite(str(name), value))
        for name, value in pairs
    )
