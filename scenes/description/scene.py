"""Scene: a wave on a lattice, the times and cells compared, the accuracy and the observables.

The reduced equation is not part of a scene; it is derived when the scene is run.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from longwave.scenes.description import entries, scene_file, scene_rules
from longwave.scenes.description import scene_checks as check
from longwave.scenes.description.bench import BENCH_TABLES, Bench, bench_of, check_bath
from longwave.scenes.description.losses import Losses
from longwave.scenes.description.numerics import NUMERICS, Discretisation, Tolerance, numerics_of
from longwave.scenes.description.scene_checks import CHAIN, CHAIN_CONSTANTS, NOT_GIVEN, Value
from longwave.scenes.description.scene_disorder import Disorder
from longwave.scenes.description.scene_fields import SceneFields
from longwave.scenes.description.stated_tables import StatedTables
from longwave.scenes.observed.observables import OBSERVABLES, observable_named
from longwave.support.html_tables import html_table
from longwave.support.user_files import cut, file_stem, shown, shown_path

if TYPE_CHECKING:
    import xarray as xr

    from longwave.lattice.refine import Announce
    from longwave.lattice.trial import Progress

ALTERNATIVES = (
    (("slow_times",), ("times",), ("t0", "snapshots")),
    (("half_width",), ("compared",)),
)
"""Groups of keywords that state the same thing in different ways; None counts as absent."""

ALTERNATIVE_KEYS = [key for ways in ALTERNATIVES for way in ways for key in way]


@dataclass(frozen=True, repr=False)
class Scene(SceneFields):
    """Complete description of one run; checked on construction.

    ``lattice`` is a name of the catalogue, or any name if ``declared`` holds the tables of the
    lattice's file. ``constants`` are its constants, as (name, value) pairs or a mapping; a value
    may be a formula with eps, such as ``"eps/2"``. ``wave`` is a closed form of the lattice's
    reduced equation, or the name of one; ``parameters`` are the parameters of the wave.

    The run starts at ``t0`` and is stored at the ``snapshots``, in lattice time. Alternatively it
    starts at the first of ``slow_times``, in the wave's time T, and is stored at all of them. The
    compared cells are those within ``half_width`` in X, or within ``compared`` cells, of the
    frame's origin. ``numerics`` is a `Discretisation`, or a `Tolerance` in units of ``eps**power``,
    the size of the compared quantities.

    A long wave takes ``amplitude``, ``time`` (powers of eps) and ``background``, the uniform mean
    of the fields, which may be a formula in the constants; missing values are derived. The wave
    "computed_soliton", of a ``speed`` in X/T, is for equations without a soliton in closed form. A
    ``carrier``, the carrier's wavenumber, makes the wave an envelope, on a ``branch``.
    ``disorder``, a record, a mapping or pairs, lets masses or springs deviate. ``losses``, a record
    or a table (`losses.py`), enter both the lattice and its equation.

    The error curve is sampled at ``curve_points`` equidistant times and at the snapshots. Other
    observables (energy, crest, ...) are sampled at most as often, at times where the run stops
    anyway, or at ``look_points`` equidistant times. For leading data of a wave of the mKdV equation
    on the paper's chain (`has_moving_wave`) there are also windows and the spectral engine, and
    parameters may be multiples of the quarter period ("K/2").

    A ``bench`` is a chain with ends and forces that starts without a wave; `of` also takes the
    tables of `scenes.description.bench` as keywords. The tolerance applies to its observables.

    The wave "perturbed_plane" measures the growth rate of a carrier's perturbed plane wave
    (`is_growth`). Its parameters are `PERTURBATION_PARAMETERS`; times and region are computed. The
    tolerance is that of the rate, in units of the largest rate of the envelope equation.

    Raises ValueError with a one-line message: argument, condition, value, remedy.

    >>> scene = Scene.of(name="short", wave="soliton_sech", parameters={"A": 1}, eps=0.1, t0=0,
    ...                  snapshots=[0, 50], K2=1, K4=1, compared=60, tolerance=1e-4)
    >>> scene
    <Scene short: soliton_sech with A = 1 on fput_strain, eps = 0.1, t = 0 .. 50, ... to 0.0001>
    >>> scene.changed(engine="stencil").numerics
    Tolerance(tolerance=0.0001, engine='stencil', scheme='')
    >>> Scene.of(name="long", lattice="toda", constants={"a": 1, "b": 1}, eps=0.1,
    ...          wave="kdv_soliton", parameters={"kappa": 2}, slow_times=[0, 0.1],
    ...          half_width=4, tolerance=1e-3)
    <Scene long: kdv_soliton with kappa = 2 on toda, eps = 0.1, T = 0 .. 0.1, |X| <= 4 ...>
    """

    @classmethod
    def of(cls, **given: Any) -> Scene:
        """Return a scene from keywords named as in scene files.

        Among them are those of a `Discretisation` (step, domain, sites, scheme) or a `Tolerance`
        (tolerance, engine, scheme). ``lattice`` may be a `derive.Lattice` or the tables of a
        lattice's file. ``K2``, ``K3``, ``K4`` are the constants of the paper's chain. ``times``
        are the snapshots, the first of which is t0.
        """
        known = (*FIELDS, *CHAIN_CONSTANTS, "times", *NUMERICS, *BENCH_TABLES)
        check.refuse_unknown(given, known, what="keywords")
        if not isinstance(given.get("lattice", ""), str):
            given |= scene_file.lattice_keywords(given["lattice"])
        absent = [key for key in ALTERNATIVE_KEYS if given.get(key) is None]
        values = {key: value for key, value in given.items() if key in FIELDS and key not in absent}
        if bench := bench_of(given):
            values = {"wave": "", "eps": 1.0} | values | {"bench": bench, "observables": ()}
        if "compared" in values:
            values["compared"] = check.whole("compared", values["compared"])
        own = {key: given[key] for key in CHAIN_CONSTANTS if key in given}
        if own and values.get("constants"):
            raise ValueError(
                f"constants must not be given with {', '.join(own)}, got both (leave one out)"
            )
        values |= {"constants": tuple(own.items())} if own else {}
        if _is_given(given, "times"):
            for key in ("t0", "snapshots"):
                if _is_given(given, key):
                    raise ValueError(
                        f"{key} must not be given with times, got both (times are t0 and snapshots)"
                    )
            moments = check.times("times", given["times"], 2)
            values |= {"t0": moments[0], "snapshots": moments}
        for key in ("name", "wave", "eps"):
            if key not in values:
                raise ValueError(f"{key} must be stated, got nothing (state it)")
        return cls(numerics=numerics_of(given), **values)

    @classmethod
    def from_toml(cls, path: str | Path) -> Scene:
        """Read a scene file, whose format is described in `scene_file.py`."""
        return cls.of_document(scene_file.read_document(path), Path(path))

    @classmethod
    def of_document(cls, document: Mapping[str, Any], path: Path) -> Scene:
        """Return the scene of a parsed file; files it names are looked up beside ``path``."""
        try:
            fields = scene_file.scene_fields(document, path.parent)
            return cls.of(**{"name": file_stem(path)} | fields)
        except ValueError as error:
            raise ValueError(f"{shown_path(path.name)}: {error}") from None

    @classmethod
    def from_json(cls, text: str) -> Scene:
        """Return the scene that `json` wrote; with a custom wave it can be shown but not run."""
        given = json.loads(text)
        if not isinstance(given, Mapping):
            raise ValueError(
                f"a scene must be an object of JSON, got {shown(given)} (such as Scene.json writes)"
            )
        return cls.of(**given)

    def __post_init__(self) -> None:
        for key in ("name", "lattice", "order", "title"):
            check.text(key, getattr(self, key))
        if isinstance(self.wave, str):
            check.text("wave", self.wave)
        else:
            check.closed_form(self.wave)
        self._set("eps", scene_rules.check_eps(self.eps))
        check.one_of("order", self.order, check.ORDERS)
        for key in ("constants", "parameters"):
            self._set(key, check.pairs(key, getattr(self, key)))
        self._check_constants()
        if self.t0 != NOT_GIVEN:
            self._set("t0", check.finite("t0", self.t0))
        for key, least, start in (("snapshots", 1, self.t0), ("slow_times", 2, -math.inf)):
            is_given = _is_given({key: getattr(self, key)}, key)
            times = check.times(key, getattr(self, key), least, start) if is_given else ()
            self._set(key, times)
        self._set("carrier", check.value("k", self.carrier))
        self._set("background", check.value("background", self.background))
        self._set("disorder", Disorder.of_pairs(self.disorder) if self.disorder else None)
        self._set("declared", _declaration_of(self.declared))
        self._set("losses", Losses.of(self.losses))
        if self.bench is not None:
            self._check_bench(self.bench)
            return
        self._set("curve_points", check.whole("curve_points", self.curve_points))
        if self.look_points is not None:
            self._set("look_points", check.whole("look_points", self.look_points))
        if not isinstance(self.numerics, Discretisation | Tolerance):
            raise ValueError(
                f"numerics must be a Discretisation or a Tolerance, got {shown(self.numerics)} "
                "(such as Tolerance(1e-4))"
            )
        self.start.check(self)
        if not self.is_growth:
            self._check_moments()
            self._check_region()
        self._check_ansatz()
        has_default = self.observables is None
        names = self.start.observables if has_default else self.observables
        self._set("observables", check.names("observables", names, tuple(OBSERVABLES)))
        if self.has_moving_wave:
            scene_rules.check_moving_wave(self)
        else:
            scene_rules.check_any_lattice(self)

    def _check_bench(self, bench: Bench) -> None:
        """Raise ValueError if fields of a wave are given, or numerics other than a tolerance."""
        for key in WAVE_FIELDS:
            if getattr(self, key) != _DEFAULTS[key] and not (key == "wave" and not self.wave):
                raise ValueError(
                    f"{key} must not be given with a chain on a bench, got "
                    f"{shown(getattr(self, key))} (there is no wave to compare with)"
                )
        check_bath(bench, self.losses)
        if not isinstance(self.numerics, Tolerance) or self.numerics.engine:
            raise ValueError(
                "tolerance must be given for a chain on a bench, without an engine, got "
                f"{self.numerics} (it is the error of the observables, in their units)"
            )
        if len({self.t0, *self.snapshots}) < 2:
            raise ValueError("times must be given, the first is the start (such as [0, 40])")

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    def _check_moments(self) -> None:
        is_timed = self.t0 != NOT_GIVEN or bool(self.snapshots)
        stated, got = (self.t0, self.snapshots), "both" if is_timed else "neither"
        if self.slow_times and self.has_moving_wave:
            moments = check.times("snapshots", tuple(T / self.eps**3 for T in self.slow_times), 2)
            self._set("t0", moments[0])
            self._set("snapshots", moments)
            is_timed = is_timed and stated != (moments[0], moments)
        if bool(self.slow_times) == is_timed:
            raise ValueError(
                f"either slow_times or times must be given, got {got} (slow_times = [0, 1] is from "
                "T = 0 to T = 1, times are t0 and snapshots)"
            )
        if is_timed and self.t0 == NOT_GIVEN:
            raise ValueError("t0 must be stated with snapshots, got nothing (state it)")
        if is_timed:
            check.times("snapshots", self.snapshots)

    def _check_region(self) -> None:
        if self.half_width is not None:
            self._set("half_width", check.positive("half_width", self.half_width))
        stated, admitted = self.compared, {0}
        if self.half_width is not None and self.has_moving_wave:
            self._set("compared", check.whole("compared", self.cells_within(1)))
            admitted.add(self.compared)
        if (stated == 0) if self.half_width is None else (stated not in admitted):
            got = "neither" if self.half_width is None else "both"
            raise ValueError(
                f"either half_width or compared must be given, got {got} (half_width = 10 is in X, "
                "compared = 200 in cells)"
            )

    def _check_ansatz(self) -> None:
        for key, most in (("amplitude", 8), ("time", 9)):
            value = getattr(self, key)
            if value is not None and (isinstance(value, bool) or value not in range(most + 1)):
                raise ValueError(
                    f"{key} must be a whole number, 0 <= {key} <= {most}, got {shown(value)} "
                    "(leave it out to have it derived)"
                )
            self._set(key, None if value is None else int(value))
        if self.is_envelope:
            for key, usual in (("amplitude", None), ("time", None), ("background", 0)):
                if getattr(self, key) != usual:
                    raise ValueError(
                        f"{key} must not be given with an envelope, got {shown(getattr(self, key))}"
                        " (it belongs to long waves)"
                    )
        if isinstance(self.branch, bool) or not isinstance(self.branch, int | str):
            raise ValueError(
                f"branch must be acoustic, optical or a number, got {shown(self.branch)} (0 is the "
                "lowest)"
            )
        if self.branch != "acoustic" and not self.is_envelope:
            raise ValueError(
                f"branch must be given with an envelope, got {shown(self.branch)} without (give "
                "the carrier's k)"
            )

    def _check_constants(self) -> None:
        """Check the paper's chain's constants and put K2, K3, K4 first; a missing K3 becomes 0."""
        if self.lattice != CHAIN or self.declared:
            return
        given: dict[str, Value] = {"K3": 0} | dict(self.constants)
        others = [name for name in given if name not in CHAIN_CONSTANTS]
        for name in others if not self.losses else ():
            check.one_of("name in [constants]", name, CHAIN_CONSTANTS)
        for name in CHAIN_CONSTANTS:
            if name not in given:
                raise ValueError(f"{name} in [constants] must be stated, got nothing (state it)")
        constants = tuple((name, given[name]) for name in (*CHAIN_CONSTANTS, *others))
        self._set("constants", constants)

    def __repr__(self) -> str:
        values = ", ".join(
            f"{name} = {value if isinstance(value, str) else f'{value:g}'}"
            for name, value in self.parameters
        )
        wave = f"{self.wave_name} with {values}" if values else self.wave_name
        name, times = "T", self.slow_times
        if not times:
            name, times = "t", (self.t0, *self.snapshots[-1:])
        width = self.half_width
        region = f"{2 * self.compared + 1} sites" if width is None else f"|X| <= {width:g}"
        if self.bench:
            span = f"t = {times[0]:g} .. {times[-1]:g}"
            return f"<Scene {self.name}: {self.lattice} on a bench, {span}, {self.numerics}>"
        comparison = f", {name} = {times[0]:g} .. {times[-1]:g}, {region} compared"
        order = "" if self.order == "leading" else f", {self.order} order"
        return (
            f"<Scene {self.name}: {wave} on {self.lattice}, eps = {self.eps:g}{order}"
            f"{'' if self.is_growth else comparison}, {self.numerics}>"
        )

    def _repr_html_(self) -> str:
        """HTML table for notebooks: entries of the scene's file, equations of motion, formula."""
        document = self.document() | {"lattice": self.lattice}
        rows = [(key, _in_words(value)) for key, value in document.items() if key != "title"]
        with suppress(ValueError):  # unknown lattice
            rows.append(("motion", self.symbolic_lattice._repr_latex_()))
        if not (self.bench or self.is_growth):
            with suppress(ValueError):  # wave without a closed form
                rows.append(("formula", self.form._repr_latex_() or "too long to be read"))
        return html_table(self.title or self.name, rows)

    def run(self, progress: Progress | None = None, announce: Announce | None = None) -> xr.Dataset:
        """Run the scene as `longwave.run` does, and return its data set."""
        return entries.run(self, progress, announce)

    def changed(self, **changes: Any) -> Scene:
        """Return the scene with some keywords of `of` changed; their `ALTERNATIVES` are dropped."""
        given = self._keywords()
        for other in alternatives_of([key for key in changes if _is_given(changes, key)]):
            given.pop(other, None)
        own = {key: changes[key] for key in CHAIN_CONSTANTS if key in changes}
        if own:
            stated = dict(check.pairs("constants", changes.get("constants", self.constants)))
            changes = {key: value for key, value in changes.items() if key not in own}
            changes["constants"] = {**stated, **own}
        return Scene.of(**(given | changes))

    def with_tolerance(self, tolerance: float) -> Scene:
        """Return the scene with a tolerance instead of its step, domain and refinement runs."""
        kinds = {name: observable_named(name).measured_at for name in self.observables}
        names = tuple(name for name, kind in kinds.items() if kind != "refinement")
        stated = dict.fromkeys(NUMERICS) if isinstance(self.numerics, Discretisation) else {}
        return self.changed(**stated | {"tolerance": tolerance, "observables": names})

    def json(self) -> str:
        """Return the keywords of `of` as sorted JSON; a custom wave is marked as not shipped."""
        texts = {
            "disorder": self.disorder and self.disorder.pairs,
            "declared": self.declared and self.declared.json,
            "losses": self.losses and str(self.losses),
            "bench": self.bench and self.bench.stated.json,
        }
        texts = {key: text for key, text in texts.items() if text is not None}
        return json.dumps(self._stated() | texts, sort_keys=True)

    def toml(self) -> str:
        """Return the scene as the text of a file, with its name and any declared lattice."""
        return scene_file.toml_text(self.document())

    def document(self) -> dict[str, Any]:
        """Return the scene as the tables of a scene file."""
        return scene_file.document_of(self._stated())

    def _stated(self) -> dict[str, Any]:
        """Return the keywords of `of`; a custom wave is replaced by a text with its name."""
        if isinstance(self.wave, str):
            return self._keywords()
        return self._keywords() | {"wave": f"{self.wave.name} (a closed form that is not shipped)"}

    def _keywords(self) -> dict[str, Any]:
        """Return the keywords of `of` whose values are not the defaults."""
        given = {key: getattr(self, key) for key in FIELDS} | asdict(self.numerics)
        defaults = _DEFAULTS | {"observables": self.start.observables}
        defaults |= {"eps": 1.0, "wave": ""} if self.bench else {}
        for key in alternatives_of([k for k in ("slow_times", "half_width") if given[k]]):
            given.pop(key, None)
        return {key: value for key, value in given.items() if value != defaults.get(key, "")}


WAVE_FIELDS = (
    *("wave", "parameters", "order", "slow_times", "compared", "half_width", "amplitude", "time"),
    *("background", "carrier", "branch", "disorder"),
)
"""Fields that only scenes with a wave may have."""

LONGEST_ENTRY = 200
"""Maximum number of characters that a notebook shows of one entry of a scene."""

FIELDS = tuple(field.name for field in fields(Scene) if field.name != "numerics")
_DEFAULTS = {field.name: field.default for field in fields(Scene)}


def _is_given(given: Mapping[str, Any], key: str) -> bool:
    """Return whether a keyword is given and is neither None nor an empty list."""
    value = given.get(key)
    return value is not None and not (isinstance(value, list | tuple) and not value)


def _in_words(value: object) -> str:
    """Return a value of a scene's file as short text."""
    if isinstance(value, Mapping):
        return cut(", ".join(f"{k} = {_in_words(v)}" for k, v in value.items()), LONGEST_ENTRY)
    if isinstance(value, list | tuple):
        return cut(", ".join(map(_in_words, value)), LONGEST_ENTRY)
    return f"{value:g}" if isinstance(value, float) else str(value)


def alternatives_of(stated: Sequence[str]) -> list[str]:
    """Return the keywords that must be dropped when the given ones are stated (`ALTERNATIVES`).

    >>> alternatives_of(["times", "eps"])
    ['slow_times', 't0', 'snapshots']
    """
    return [
        key
        for ways in ALTERNATIVES
        for way in ways
        for key in way
        if any(k in stated for other in ways for k in other) and not any(k in stated for k in way)
    ]


def _declaration_of(given: object) -> StatedTables | None:
    """Return a declared lattice's tables without its name; ValueError unless it is a table."""
    if not given:
        return None
    if isinstance(given, StatedTables):
        return given
    tables = given
    if isinstance(given, str):
        with suppress(ValueError, RecursionError):
            tables = json.loads(given)
    if not isinstance(tables, Mapping):
        raise ValueError(
            f"declared must be a lattice's tables as JSON, got {shown(given)} (read_lattice "
            "says what they hold)"
        )
    return StatedTables({key: value for key, value in tables.items() if key != "name"}, "lattice")
