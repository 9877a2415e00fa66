"""A scene: a wave on a lattice, when and where they are compared, how exactly, what is observed.

What lies between the lattice's name and the comparison is derived when the scene is run.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from longwave.scenes.description import entries
from longwave.scenes.description import scene_checks as check
from longwave.scenes.description.bench import BENCH_TABLES, Bench, bench_of, check_bath
from longwave.scenes.description.losses import Losses
from longwave.scenes.description.numerics import NUMERICS, Discretisation, Tolerance, numerics_of
from longwave.scenes.description.scene_checks import CHAIN, CHAIN_CONSTANTS, NOT_GIVEN, Value
from longwave.scenes.description.scene_disorder import Disorder
from longwave.scenes.description.scene_fields import SceneFields
from longwave.scenes.description.scene_file import (
    document_of,
    lattice_keywords,
    read_document,
    scene_fields,
    toml_text,
)
from longwave.scenes.description.scene_rules import (
    check_any_lattice,
    check_eps,
    check_moving_wave,
)
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
"""Keywords that say one thing in several ways; None is as if it were not given."""

SAID_IN_ONE_WAY = [key for ways in ALTERNATIVES for way in ways for key in way]


@dataclass(frozen=True, repr=False)
class Scene(SceneFields):
    """One run, stated in full; checked when the record is made.

    ``lattice`` is a name of the catalogue, or any name if ``declared`` holds the tables of the
    lattice's file. ``constants`` are its numbers, as (name, value) pairs or a
    mapping; a value in text may have eps in it: ``"eps/2"`` is small. ``wave`` is the name of a
    closed form of the lattice's own equation, or a closed form; ``parameters`` are its.

    The run begins at ``t0`` and is kept at the ``snapshots``, in the lattice's time, or begins at
    the first of ``slow_times``, T in the wave's own time, and is kept at all of them. Compared are
    the cells within ``half_width`` in X, or within ``compared`` cells, of where the frame is.
    ``numerics`` says how it is computed: a `Discretisation`, or a `Tolerance`, in units of eps to
    the power with which what is compared is small.

    A long wave takes ``amplitude``, ``time`` (powers of eps) and ``background``, the uniform mean
    of the fields, which may be a formula in the constants; what is not given is found. The wave
    "computed_soliton", of a ``speed`` in X/T, is for equations with none in closed form. A
    ``carrier``, its wavenumber, makes the wave an envelope, on a ``branch``.  ``disorder``, a
    record, or pairs or a mapping with its names, lets masses or springs deviate. ``losses``, a
    record or a table as `losses.py` says it, are in the lattice and in its equation.

    Of ``observables`` the error curve is sampled at ``curve_points`` equidistant times and the
    snapshots; what is only looked at (energy, crest, ...) is seen at most as often, where the run
    stops anyway, or at ``look_points`` equidistant times if that is given. Leading data of a wave
    of the mKdV equation on the paper's chain (`has_moving_wave`) have windows and the spectral
    engine besides, and their parameters may be multiples of the quarter period ("K/2").

    A ``bench`` is a chain with ends and forces that starts without a wave; `of` takes the tables of
    `scenes.description.bench` as keywords, too. What it watches is what has the
    tolerance.

    With the wave "perturbed_plane" the growth rate of a carrier's plane wave is measured
    (`is_growth`): parameters are `PERTURBATION`, times and region are found, and the tolerance is
    that of the rate, in units of the largest that the envelope equation has.

    Raises ValueError in one line: argument, condition, value, remedy.

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
        """A scene from keywords as scene files have them.

        Those of the `Discretisation` (step, domain, sites, scheme) or of the `Tolerance`
        (tolerance, engine, scheme) stand among the others. ``lattice`` may be a `derive.Lattice`
        or the tables of a lattice's file. ``K2``, ``K3``, ``K4`` stand for the constants of the
        paper's chain; ``times`` for t0 and the snapshots, of which it is one.
        """
        known = (*FIELDS, *CHAIN_CONSTANTS, "times", *NUMERICS, *BENCH_TABLES)
        check.refuse_unknown(given, known, what="keywords")
        if not isinstance(given.get("lattice", ""), str):
            given |= lattice_keywords(given["lattice"])
        unsaid = [key for key in SAID_IN_ONE_WAY if given.get(key) is None]
        found = {key: value for key, value in given.items() if key in FIELDS and key not in unsaid}
        if bench := bench_of(given):
            found = {"wave": "", "eps": 1.0} | found | {"bench": bench, "observables": ()}
        if "compared" in found:
            found["compared"] = check.whole("compared", found["compared"])
        own = {key: given[key] for key in CHAIN_CONSTANTS if key in given}
        if own and found.get("constants"):
            raise ValueError(
                f"constants must not be given with {', '.join(own)}, got both (leave one out)"
            )
        found |= {"constants": tuple(own.items())} if own else {}
        if _is_said(given, "times"):
            for key in ("t0", "snapshots"):
                if _is_said(given, key):
                    raise ValueError(
                        f"{key} must not be given with times, got both (times are t0 and snapshots)"
                    )
            moments = check.times("times", given["times"], 2)
            found |= {"t0": moments[0], "snapshots": moments}
        for key in ("name", "wave", "eps"):
            if key not in found:
                raise ValueError(f"{key} must be stated, got nothing (state it)")
        return cls(numerics=numerics_of(given), **found)

    @classmethod
    def from_toml(cls, path: str | Path) -> Scene:
        """Read a scene file (`scene_file.py` says what may stand in it)."""
        return cls.of_document(read_document(path), Path(path))

    @classmethod
    def of_document(cls, document: Mapping[str, Any], path: Path) -> Scene:
        """The scene that the tables of a file at ``path`` describe."""
        try:
            return cls.of(**{"name": file_stem(path)} | scene_fields(document, path.parent))
        except ValueError as error:
            raise ValueError(f"{shown_path(path.name)}: {error}") from None

    @classmethod
    def from_json(cls, text: str) -> Scene:
        """The scene that `json` wrote. One with a wave of your own can be shown, but not run."""
        given = json.loads(text)
        if not isinstance(given, Mapping):
            raise ValueError(f"a scene must be an object of JSON, got {shown(given)}")
        return cls.of(**given)

    def __post_init__(self) -> None:
        for key in ("name", "lattice", "order", "title"):
            check.text(key, getattr(self, key))
        if isinstance(self.wave, str):
            check.text("wave", self.wave)
        else:
            check.closed_form(self.wave)
        self._set("eps", check_eps(self.eps))
        check.one_of("order", self.order, check.ORDERS)
        for key in ("constants", "parameters"):
            self._set(key, check.pairs(key, getattr(self, key)))
        self._check_constants()
        if self.t0 != NOT_GIVEN:
            self._set("t0", check.finite("t0", self.t0))
        for key, least, start in (("snapshots", 1, self.t0), ("slow_times", 2, -math.inf)):
            said = _is_said({key: getattr(self, key)}, key)
            times = check.times(key, getattr(self, key), least, start) if said else ()
            self._set(key, times)
        self._set("carrier", check.value("k", self.carrier))
        self._set("background", check.value("background", self.background))
        self._set("disorder", Disorder.of_pairs(self.disorder) if self.disorder else None)
        self._set("declared", _declared(self.declared))
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
        is_usual = self.observables is None
        asked = self.start.observables if is_usual else self.observables
        self._set("observables", check.names("observables", asked, tuple(OBSERVABLES)))
        if self.has_moving_wave:
            check_moving_wave(self)
        else:
            check_any_lattice(self)

    def _check_bench(self, bench: Bench) -> None:
        """Refuse what belongs to a wave, and what the tables of a bench do not admit."""
        for key in WAVE_ALONE:
            if getattr(self, key) != _USUAL[key] and not (key == "wave" and not self.wave):
                raise ValueError(
                    f"{key} must not be given with a chain on a bench, got "
                    f"{shown(getattr(self, key))} (there is no wave to compare with)"
                )
        check_bath(bench, self.losses)
        if not isinstance(self.numerics, Tolerance) or self.numerics.engine:
            raise ValueError(
                "tolerance must be given for a chain on a bench, without an engine, got "
                f"{self.numerics} (of what is watched, in its own units)"
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
                    "(leave it out and it is found)"
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
                f"branch must be acoustic, optical or a number, got {shown(self.branch)}"
            )
        if self.branch != "acoustic" and not self.is_envelope:
            raise ValueError(
                f"branch must be given with an envelope, got {shown(self.branch)} without (give "
                "the carrier's k)"
            )

    def _check_constants(self) -> None:
        """Put the constants of the paper's chain in order; K3 is 0 where it is not given."""
        if self.lattice != CHAIN or self.declared:
            return
        given: dict[str, Value] = {"K3": 0} | dict(self.constants)
        others = [name for name in given if name not in CHAIN_CONSTANTS]
        for name in others if not self.losses else ():
            check.one_of("name in [constants]", name, CHAIN_CONSTANTS)
        for name in CHAIN_CONSTANTS:
            if name not in given:
                raise ValueError(f"{name} in [constants] must be stated, got nothing (state it)")
        found = tuple((name, given[name]) for name in (*CHAIN_CONSTANTS, *others))
        self._set("constants", found)

    def __repr__(self) -> str:
        values = ", ".join(
            f"{name} = {value if isinstance(value, str) else f'{value:g}'}"
            for name, value in self.parameters
        )
        wave = f"{self.wave_name} with {values}" if values else self.wave_name
        name, times = "T", self.slow_times
        if not times:
            name, times = "t", (self.t0, *self.snapshots[-1:])
        region = f"{2 * self.compared + 1} sites"
        if self.half_width is not None:
            region = f"|X| <= {self.half_width:g}"
        if self.bench:
            seen = f"t = {times[0]:g} .. {times[-1]:g}"
            return f"<Scene {self.name}: {self.lattice} on a bench, {seen}, {self.numerics}>"
        seen = f", {name} = {times[0]:g} .. {times[-1]:g}, {region} compared"
        order = "" if self.order == "leading" else f", {self.order} order"
        return (
            f"<Scene {self.name}: {wave} on {self.lattice}, eps = {self.eps:g}{order}"
            f"{'' if self.is_growth else seen}, {self.numerics}>"
        )

    def _repr_html_(self) -> str:
        """What its file says, and the formula of its wave, as notebooks show it."""
        document = self.document() | {"lattice": self.lattice}
        rows = [(key, _in_words(value)) for key, value in document.items() if key != "title"]
        with suppress(ValueError):  # of a lattice that is not known
            rows.append(("motion", self.symbolic_lattice._repr_latex_()))
        if not (self.bench or self.is_growth):
            with suppress(ValueError):  # of a wave without a closed form
                rows.append(("formula", self.form._repr_latex_() or "too long to be read"))
        return html_table(self.title or self.name, rows)

    def run(self, progress: Progress | None = None, announce: Announce | None = None) -> xr.Dataset:
        """Run the scene as `longwave.run` does, and return its data set."""
        return entries.run(self, progress, announce)

    def changed(self, **changes: Any) -> Scene:
        """The scene with other values for some keywords of `of`.

        What a change says in one way is no longer said in another: slow_times in place of t0.
        """
        given = self._keywords()
        for other in said_otherwise([key for key in changes if _is_said(changes, key)]):
            given.pop(other, None)
        own = {key: changes[key] for key in CHAIN_CONSTANTS if key in changes}
        if own:
            stated = dict(check.pairs("constants", changes.get("constants", self.constants)))
            changes = {key: value for key, value in changes.items() if key not in own}
            changes["constants"] = {**stated, **own}
        return Scene.of(**(given | changes))

    def with_tolerance(self, tolerance: float) -> Scene:
        """The scene with a tolerance in the place of its step, domain and measured refinements."""
        kept = (name for name in self.observables if observable_named(name).seen != "refinement")
        stated = dict.fromkeys(NUMERICS) if isinstance(self.numerics, Discretisation) else {}
        return self.changed(**stated | {"tolerance": tolerance, "observables": tuple(kept)})

    def json(self) -> str:
        """The keywords of `of` as JSON, sorted; a wave of your own is said not to be shipped."""
        return json.dumps(self._stated() | self._texts(), sort_keys=True)

    def toml(self) -> str:
        """The scene as a file, with its name and, if it is declared, its lattice."""
        return toml_text(self.document())

    def document(self) -> dict[str, Any]:
        """The tables of its file."""
        return document_of(self._stated())

    def _stated(self) -> dict[str, Any]:
        """The keywords of `of`, a wave of one's own by a name that is not shipped."""
        if isinstance(self.wave, str):
            return self._keywords()
        return self._keywords() | {"wave": f"{self.wave.name} (a closed form that is not shipped)"}

    def _texts(self) -> dict[str, Any]:
        """The records among the keywords as JSON has them."""
        found = {
            "disorder": self.disorder and self.disorder.pairs,
            "declared": self.declared and self.declared.json,
            "losses": self.losses and str(self.losses),
            "bench": self.bench and self.bench.stated.json,
        }
        return {key: held for key, held in found.items() if held is not None}

    def _keywords(self) -> dict[str, Any]:
        """The keywords of `of`, those apart that say what is usual."""
        given = {key: getattr(self, key) for key in FIELDS} | asdict(self.numerics)
        usual = _USUAL | {"observables": self.start.observables}
        usual |= {"eps": 1.0, "wave": ""} if self.bench else {}
        for key in said_otherwise([k for k in ("slow_times", "half_width") if given[k]]):
            given.pop(key, None)
        return {key: value for key, value in given.items() if value != usual.get(key, "")}


WAVE_ALONE = (
    *("wave", "parameters", "order", "slow_times", "compared", "half_width", "amplitude", "time"),
    *("background", "carrier", "branch", "disorder"),
)
"""Fields of a wave that is compared."""

LONGEST_ENTRY = 200
"""Characters that a notebook shows of an entry of a scene."""

FIELDS = tuple(field.name for field in fields(Scene) if field.name != "numerics")
_USUAL = {field.name: field.default for field in fields(Scene)}


def _is_said(given: Mapping[str, Any], key: str) -> bool:
    """Whether a keyword is given, and neither None nor an empty list."""
    value = given.get(key)
    return value is not None and not (isinstance(value, list | tuple) and not value)


def _in_words(value: object) -> str:
    """A value of a scene's file in a few words."""
    if isinstance(value, Mapping):
        return cut(", ".join(f"{k} = {_in_words(v)}" for k, v in value.items()), LONGEST_ENTRY)
    if isinstance(value, list | tuple):
        return cut(", ".join(map(_in_words, value)), LONGEST_ENTRY)
    return f"{value:g}" if isinstance(value, float) else str(value)


def said_otherwise(said: Sequence[str]) -> list[str]:
    """The keywords that say in other ways what the given ones say.

    >>> said_otherwise(["times", "eps"])
    ['slow_times', 't0', 'snapshots']
    """
    return [
        key
        for ways in ALTERNATIVES
        for way in ways
        for key in way
        if any(one in said for other in ways for one in other) and not any(k in said for k in way)
    ]


def _declared(given: object) -> StatedTables | None:
    """A declared lattice without its name; ValueError for what is no table."""
    if not given:
        return None
    if isinstance(given, StatedTables):
        return given
    found = given
    if isinstance(given, str):
        with suppress(ValueError, RecursionError):
            found = json.loads(given)
    if not isinstance(found, Mapping):
        raise ValueError(
            f"declared must be a lattice's tables as JSON, got {shown(given)} (read_lattice "
            "says what they hold)"
        )
    return StatedTables({key: value for key, value in found.items() if key != "name"}, "lattice")
