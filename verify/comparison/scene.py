"""A scene: what to run, how exactly or with what discretisation, and which effects are wanted."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lattice.model import Model
from lattice.schemes.catalogue import scheme_named
from lattice.schemes.scheme import Scheme
from verify.comparison import checks as check
from verify.comparison.observables import NAMES, observable_named
from verify.comparison.scene_file import read_scene_file

if TYPE_CHECKING:
    from solutions import ClosedForm
    from verify.comparison.moving_wave import MovingWave

DOMAINS = ("window", "ring", "closed_ring")
ENGINES = ("stencil", "spectral")


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
        check.one_of("domain", self.domain, DOMAINS)

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
            check.one_of("engine", self.engine, ENGINES)
        if self.scheme:
            scheme_named(self.scheme)
            if self.engine == "spectral":
                raise ValueError(
                    f"scheme must not be given for engine 'spectral', got {self.scheme!r} "
                    "(it has its own)"
                )

    def __str__(self) -> str:
        named = ", ".join(text for text in (self.engine, self.scheme) if text)
        return f"to {self.tolerance:g}" + (f" by {named}" if named else "")


@dataclass(frozen=True, repr=False)
class Scene:
    """One run, stated in full; numbers are checked when the record is made.

    Times are in units of the lattice, lengths in sites. ``wave`` is the name of a closed form of
    the catalogue, or one of your own; ``parameters`` are its, as (name, value) pairs or a mapping.
    ``compared`` is the half-width of the compared region about the site nearest to c t.
    ``numerics`` says how it is computed: a `Discretisation`, or a `Tolerance`.

    The error curve is sampled at ``curve_points`` equidistant times and
    the snapshots; what is only looked at (energy, crest, ...) is seen at most as often, where the
    run stops anyway, or at ``look_points`` equidistant times if that is given.

    Raises ValueError in one line: argument, condition, value, remedy.

    >>> scene = Scene.of(name="short", wave="soliton_sech", parameters={"A": 1}, eps=0.1, t0=0,
    ...                  snapshots=[0, 50], K2=1, K4=1, compared=60, tolerance=1e-4)
    >>> scene
    <Scene short: soliton_sech with A = 1, eps = 0.1, t = 0 .. 50, 121 sites compared, to 0.0001>
    >>> scene.changed(engine="stencil").numerics
    Tolerance(tolerance=0.0001, engine='stencil', scheme='')
    """

    name: str
    wave: "str | ClosedForm"
    eps: float
    t0: float
    snapshots: tuple[float, ...]
    K2: float
    K4: float
    compared: int
    numerics: Discretisation | Tolerance
    K3: float = 0.0
    parameters: tuple[tuple[str, float | str], ...] = ()
    observables: tuple[str, ...] = ("strain", "error_curve")
    curve_points: int = 201
    look_points: int | None = None
    title: str = ""

    @classmethod
    def of(cls, **given: Any) -> "Scene":
        """A scene from keywords as scene files have them.

        Those of the `Discretisation` (step, domain, sites, scheme) or of the `Tolerance`
        (tolerance, engine, scheme) stand among the others.
        """
        check.known_fields(given, (*PHYSICS, *NUMERICS))
        physics = {key: value for key, value in given.items() if key in PHYSICS}
        return cls(numerics=_numerics(given), **physics)

    @classmethod
    def from_toml(cls, path: str | Path) -> "Scene":
        """Read a scene file (`scene_file.py` says what may stand in it)."""
        try:
            return cls.of(**read_scene_file(Path(path)))
        except ValueError as error:
            text = str(error)
            file = Path(path).name
            raise ValueError(text if file in text else f"{file}: {text}") from None

    @classmethod
    def from_json(cls, text: str) -> "Scene":
        """The scene that `json` wrote. One with a wave of your own can be shown, but not run."""
        return cls.of(**json.loads(text))

    def __post_init__(self) -> None:
        for key in ("name", "title"):
            check.text(key, getattr(self, key))
        if not isinstance(self.wave, str):
            check.closed_form(self.wave)
        for key in ("eps", "t0", "K2", "K3", "K4"):
            object.__setattr__(self, key, check.finite(key, getattr(self, key)))
        for key in ("compared", "curve_points"):
            object.__setattr__(self, key, check.whole(key, getattr(self, key)))
        check.positive("eps", self.eps)
        object.__setattr__(self, "snapshots", check.times(self.snapshots, self.t0))
        object.__setattr__(self, "observables", check.names("observables", self.observables, NAMES))
        object.__setattr__(self, "parameters", check.parameters(self.parameters))
        if self.look_points is not None:
            object.__setattr__(self, "look_points", check.whole("look_points", self.look_points))
        self._check_numerics()
        self.constants.sound_speed()

    def _check_numerics(self) -> None:
        """Refuse numerics that do not go with times and observables."""
        numerics = self.numerics
        if isinstance(numerics, Discretisation):
            check.enough_steps(numerics.step, self.end - self.t0)
        elif not isinstance(numerics, Tolerance):
            raise ValueError(
                f"numerics must be a Discretisation or a Tolerance, got {check.shown(numerics)} "
                "(such as Tolerance(1e-4))"
            )
        for name in self.observables:
            asked = observable_named(name)
            if isinstance(numerics, Tolerance) and asked.seen == "refinement":
                raise ValueError(
                    f"observables must have no refinement with a tolerance, got {name} "
                    "(leave it out: the run reports an estimate of its own)"
                )
            if asked.needs_ring and getattr(numerics, "domain", "") == "window":
                raise ValueError(
                    f"domain must be 'ring' for {name}, got 'window' (a window drops sites)"
                )

    def __repr__(self) -> str:
        values = ", ".join(
            f"{name} = {value if isinstance(value, str) else f'{value:g}'}"
            for name, value in self.parameters
        )
        wave = f"{self.wave_name} with {values}" if values else self.wave_name
        return (
            f"<Scene {self.name}: {wave}, eps = {self.eps:g}, t = {self.t0:g} .. {self.end:g}, "
            f"{2 * self.compared + 1} sites compared, {self.numerics}>"
        )

    @property
    def wave_name(self) -> str:
        """The wave's name."""
        return self.wave if isinstance(self.wave, str) else self.wave.name

    @property
    def tolerance(self) -> float | None:
        """The tolerance; None if the discretisation is stated."""
        return self.numerics.tolerance if isinstance(self.numerics, Tolerance) else None

    @property
    def discretisation(self) -> Discretisation:
        """The stated discretisation; ValueError if there is a tolerance instead."""
        if isinstance(self.numerics, Discretisation):
            return self.numerics
        raise ValueError(
            f"step, domain and sites must be stated for this, got a tolerance in {self.name} "
            "(give Discretisation(step, domain, sites))"
        )

    @property
    def target(self) -> Tolerance:
        """The tolerance as a record; ValueError if the discretisation is stated instead."""
        if isinstance(self.numerics, Tolerance):
            return self.numerics
        raise ValueError(
            f"tolerance must be given for this, got a stated step in {self.name} "
            "(see with_tolerance)"
        )

    @cached_property
    def constants(self) -> Model:
        """The lattice constants."""
        return Model(self.K2, self.K3, self.K4)

    @property
    def form(self) -> "ClosedForm":
        """The closed form that is named or given; a ValueError lists the known names."""
        from solutions import closed_form  # scenes are read, listed and shown without formulas

        if isinstance(self.wave, str):
            return closed_form(self.wave, dict(self.parameters))
        return self.wave

    @cached_property
    def moving_wave(self) -> "MovingWave":
        """The wave on the lattice; ValueError for parameters and constants that it does not admit.

        What asks for the wave alone finds it in ``moving_wave.wave``.
        """
        from verify.comparison.moving_wave import MovingWave, build_wave

        wave = build_wave(self.form, self.constants, dict(self.parameters))
        times = (self.t0, *self.snapshots)
        return MovingWave(wave, self.constants, self.eps, times, self.compared)

    @property
    def end(self) -> float:
        """The last time of the run."""
        return max(self.snapshots)

    def changed(self, **changes: Any) -> "Scene":
        """The scene with other values for some keywords of `of`."""
        return Scene.of(**(self._keywords() | changes))

    def json(self) -> str:
        """The keywords of `of` as JSON, sorted; a wave of your own is said not to be shipped."""
        shown = self._keywords()
        if not isinstance(self.wave, str):
            shown["wave"] = f"{self.wave.name} (a closed form that is not shipped)"
        return json.dumps(shown, sort_keys=True)

    def _keywords(self) -> dict[str, Any]:
        return {key: getattr(self, key) for key in PHYSICS} | asdict(self.numerics)


NUMERICS = ("step", "domain", "sites", "scheme", "tolerance", "engine")
PHYSICS = tuple(field.name for field in fields(Scene) if field.name != "numerics")


def _numerics(given: Mapping[str, Any]) -> Discretisation | Tolerance:
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
    if engine:
        check.one_of("engine", engine, ENGINES)
    if engine == "spectral":
        raise ValueError(
            "tolerance must be given for engine 'spectral', got none (it takes no step)"
        )
    stated = found.get("step", 0.0), found.get("domain", ""), found.get("sites", 0)
    return Discretisation(*stated, scheme) if scheme else Discretisation(*stated)


def with_tolerance(scene: Scene, tolerance: float) -> Scene:
    """The scene with a tolerance in the place of its step, domain and measured refinements."""
    kept = (name for name in scene.observables if observable_named(name).seen != "refinement")
    numerics = scene.numerics
    to = Tolerance(tolerance)
    if isinstance(numerics, Tolerance):
        to = replace(numerics, tolerance=tolerance)
    return replace(scene, numerics=to, observables=tuple(kept))
