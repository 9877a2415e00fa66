"""A scene: what to run, how exactly or with what discretisation, and which effects are wanted.

The package comes with the paper's scenes, with further ones, and with families of them.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property
from importlib.resources import as_file, files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from longwave.lattice.model import Model
from longwave.lattice.schemes import Scheme, scheme_named
from longwave.scenes.chain import scene_fields as check
from longwave.scenes.chain.observables import OBSERVABLES, observable_named
from longwave.scenes.chain.scene_fields import (
    document_of,
    parse_document,
    read_document,
    scene_fields,
)
from longwave.scenes.chain.toml_text import toml_text
from longwave.support.request_limits import is_too_much
from longwave.support.user_files import file_stem, shown, shown_path

if TYPE_CHECKING:
    import xarray as xr

    from longwave.lattice.refine import Announce
    from longwave.lattice.trial import Progress
    from longwave.scenes.chain.moving_wave import MovingWave
    from longwave.solutions import ClosedForm
    from longwave.support.request_limits import ExpectedCost

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
        """Read a scene file (`scene_fields.py` says what may stand in it)."""
        return cls.of_document(read_document(path), Path(path))

    @classmethod
    def of_document(cls, document: Mapping[str, Any], path: Path) -> "Scene":
        """The scene that the tables of a file at ``path`` describe."""
        try:
            return cls.of(**{"name": file_stem(path)} | scene_fields(document))
        except ValueError as error:
            raise ValueError(f"{shown_path(path.name)}: {error}") from None

    @classmethod
    def from_json(cls, text: str) -> "Scene":
        """The scene that `json` wrote. One with a wave of your own can be shown, but not run."""
        return cls.of(**json.loads(text))

    def __post_init__(self) -> None:
        for key in ("name", "title"):
            check.text(key, getattr(self, key))
        if isinstance(self.wave, str):
            check.text("wave", self.wave)
        else:
            check.closed_form(self.wave)
        for key in ("eps", "t0", "K2", "K3", "K4"):
            object.__setattr__(self, key, check.finite(key, getattr(self, key)))
        for key in ("compared", "curve_points"):
            object.__setattr__(self, key, check.whole(key, getattr(self, key)))
        check.positive("eps", self.eps)
        object.__setattr__(self, "snapshots", check.times(self.snapshots, self.t0))
        asked = check.names("observables", self.observables, tuple(OBSERVABLES))
        object.__setattr__(self, "observables", asked)
        object.__setattr__(self, "parameters", check.parameters(self.parameters))
        if self.look_points is not None:
            object.__setattr__(self, "look_points", check.whole("look_points", self.look_points))
        self._check_numerics()
        check.within_reach(self.constants.sound_speed(), (self.t0, self.end))

    def _check_numerics(self) -> None:
        """Refuse numerics that do not go with times and observables."""
        numerics = self.numerics
        if isinstance(numerics, Discretisation):
            check.enough_steps(numerics.step, self.end - self.t0)
        elif not isinstance(numerics, Tolerance):
            raise ValueError(
                f"numerics must be a Discretisation or a Tolerance, got {shown(numerics)} "
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

    def __getstate__(self) -> dict[str, Any]:
        """The fields alone: the wave and its programs are made again where they are asked for."""
        return {entry.name: getattr(self, entry.name) for entry in fields(self)}

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
        from longwave.solutions import (
            closed_form,  # scenes are read, listed and shown without formulas
        )

        if isinstance(self.wave, str):
            return closed_form(self.wave, dict(self.parameters))
        return self.wave

    @cached_property
    def moving_wave(self) -> "MovingWave":
        """The wave on the lattice; ValueError for parameters and constants that it does not admit.

        What asks for the wave alone finds it in ``moving_wave.wave``.
        """
        from longwave.scenes.chain.moving_wave import MovingWave, build_wave

        wave = build_wave(self.wave, self.constants, dict(self.parameters))
        times = (self.t0, *self.snapshots)
        return MovingWave(wave, self.constants, self.eps, times, self.compared)

    @property
    def end(self) -> float:
        """The last time of the run."""
        return max(self.snapshots)

    def run(
        self, progress: "Progress | None" = None, announce: "Announce | None" = None
    ) -> "xr.Dataset":
        """The run of the scene (`scene_run.run`), with what can be trusted of it."""
        from longwave.scenes.chain.scene_run import record_with_trust

        return record_with_trust(self, progress, announce).dataset

    def expected_cost(self) -> "ExpectedCost":
        """What a run is expected to cost, in a process that has just begun.

        What is known to be beyond the limits from the scene alone is not looked at any further.
        Raises ValueError for what no scene can be run with.
        """
        from longwave.scenes.chain.expected_cost import expected_cost, least_cost

        least = least_cost(self)
        return least if is_too_much(least) else expected_cost(self)

    @property
    def process_seconds(self) -> float:
        """The part of the expected seconds that a process takes once."""
        from longwave.scenes.chain.expected_cost import PROCESS_SECONDS

        return PROCESS_SECONDS

    def changed(self, **changes: Any) -> "Scene":
        """The scene with other values for some keywords of `of`."""
        return Scene.of(**(self._keywords() | changes))

    def json(self) -> str:
        """The keywords of `of` as JSON, sorted; a wave of your own is said not to be shipped."""
        keywords = self._keywords()
        if not isinstance(self.wave, str):
            keywords["wave"] = f"{self.wave.name} (a closed form that is not shipped)"
        return json.dumps(keywords, sort_keys=True)

    def toml(self) -> str:
        """The scene as a file, with its name; a wave of your own is said not to be shipped."""
        return toml_text(document_of(json.loads(self.json())))

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


def scene_of(run: "xr.Dataset") -> Scene:
    """The scene that a run carries, with step and domain where those were chosen.

    Raises KeyError for a data set without one, ValueError for what is no scene.
    """
    text = run.attrs["plan" if "plan" in run.attrs else "scene"]
    return Scene.of_document(parse_document(text.encode(), "a run"), Path("scene"))


def with_tolerance(scene: Scene, tolerance: float) -> Scene:
    """The scene with a tolerance in the place of its step, domain and measured refinements."""
    kept = (name for name in scene.observables if observable_named(name).seen != "refinement")
    numerics = scene.numerics
    to = Tolerance(tolerance)
    if isinstance(numerics, Tolerance):
        to = replace(numerics, tolerance=tolerance)
    return replace(scene, numerics=to, observables=tuple(kept))


FOLDER = files("longwave.scenes.chain.shipped")
FURTHER = files("longwave.scenes.chain.shipped.further")


def shipped_scenes() -> tuple[str, ...]:
    """Names of the paper's scenes, which come with the package, sorted.

    >>> "rational_2_eps_0.05" in shipped_scenes()
    True
    """
    return _names(FOLDER)


def further_scenes() -> tuple[str, ...]:
    """Names of the scenes that come with the package and go beyond the paper, sorted.

    >>> "rogue_cn_k_0.5_long" in further_scenes()
    True
    """
    return _names(FURTHER)


def load_scene(name: str) -> Scene:
    """The shipped scene of that name, the paper's or a further one; ValueError lists them."""
    for folder in (FOLDER, FURTHER):
        if name in _names(folder):
            with as_file(folder / f"{name}.toml") as path:
                return Scene.from_toml(path)
    known = ", ".join((*shipped_scenes(), *further_scenes()))
    raise ValueError(
        f"scene must be a TOML file or a shipped scene, got {shown(name)} (one of {known})"
    )


def _names(folder: Traversable) -> tuple[str, ...]:
    found = (entry.name for entry in folder.iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in found if name.endswith(".toml")))


ORDERS = (2, 3, 4, 5)
EPS = (0.1, 0.05, 0.025, 0.0125, 0.00625)

SLOW_START = -1.25
"""T = eps^3 t at the beginning: t = -10000 at eps = 0.05, as in the paper's scene."""

SLOW_SNAPSHOTS = (-0.625, 0.0, 0.625)
"""Slow times of the snapshots: those of the paper's scene."""

HALF_WIDTH = 75.0
"""Half-width of the compared region in X, 1500 sites at eps = 0.05."""


def rational_family_scenes(
    orders: Sequence[int] = ORDERS, eps: Sequence[float] = EPS, tolerance: float = 1e-4
) -> dict[str, Scene]:
    """The scenes Y_j at each eps by name, same slow times and same range of X.

    >>> scene = rational_family_scenes()["Y5_eps_0.025"]
    >>> scene.wave, scene.t0, scene.compared
    ('rational_5', -80000.0, 3000)
    """
    scenes = [_member(order, value, tolerance) for order in orders for value in eps]
    return {scene.name: scene for scene in scenes}


def _member(order: int, eps: float, tolerance: float) -> Scene:
    return Scene.of(
        name=f"Y{order}_eps_{eps:g}",
        title=f"Rational solution of order {order}, eps = {eps:g}",
        wave=f"rational_{order}",
        eps=eps,
        t0=_time(SLOW_START, eps),
        snapshots=tuple(_time(T, eps) for T in SLOW_SNAPSHOTS),
        K2=4.0,
        K4=1.0,
        compared=round(HALF_WIDTH / eps),
        tolerance=tolerance,
        observables=("strain",),
    )


def _time(T: float, eps: float) -> float:
    """The lattice time of a slow time, rounded to whole units."""
    return float(round(T / eps**3))
