"""A scene on any lattice: which wave, on which lattice, when and where it is compared, how exactly.

A `Scene` is the paper's chain with its mKdV waves; a `LatticeScene` names a lattice, and everything
between that name and the comparison is derived when it is run.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields
from importlib.resources import as_file, files
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any

from longwave.scenes.chain import scene_fields as check
from longwave.scenes.chain.scene_fields import finite, positive, read_document, whole
from longwave.scenes.chain.toml_text import toml_text
from longwave.scenes.lattice_scene_file import (
    document_of,
    lattice_scene_fields,
)
from longwave.scenes.scene_disorder import Stated, disorder_pairs
from longwave.support.user_files import file_stem, shown, shown_path

if TYPE_CHECKING:
    import xarray as xr

    from longwave.lattice.refine import Announce
    from longwave.lattice.trial import Progress
    from longwave.support.request_limits import ExpectedCost

ORDERS = ("leading", "slaved", "corrected")
"""What the data hold: the wave alone; the fields that follow it too; the next order as well."""

PERTURBED_PLANE = "perturbed_plane"
"""The wave of a scene that measures how fast a perturbed plane wave grows."""

PERTURBATION = ("amplitude", "kappa", "share")
"""Its parameters: |A| of the plane wave, and the wavenumber of the perturbation in X, or that in
units of the one that grows fastest, which it is if neither is given."""

Value = int | float | str
"""A number, or a formula in text such as "1/3" or "sqrt(2)"."""

Pairs = tuple[tuple[str, Value], ...]


@dataclass(frozen=True, repr=False)
class LatticeScene:
    """One run of a lattice from a wave of its own equation; checked when the record is made.

    ``lattice`` is a name of the catalogue, or any name if ``declared`` holds the lattice, as the
    JSON of what a lattice file says. ``constants`` are its numbers, as (name, value) pairs or a
    mapping; a value in text may have eps in it: ``"eps/2"`` is small. ``wave`` is the name of a
    closed form, ``parameters`` are its. The run begins at the first of ``slow_times``, T in the
    wave's own time, or of ``times``, in the lattice's. Compared are the cells within ``half_width``
    in X, or within ``compared`` cells, of where the frame is.  ``tolerance`` is the error that is
    accepted of what is compared, in units of eps to the power with which it is small.

    A long wave takes ``amplitude``, ``time`` (powers of eps) and ``background``, the uniform mean
    of the fields, which may be a formula in the constants; what is not given is found. A
    ``carrier``, its wavenumber, makes the wave an envelope, on a ``branch``.  ``disorder``, as
    (name, value) pairs or a mapping with the names of `Disorder`, lets masses or springs deviate.

    With the wave "perturbed_plane" the growth rate of a carrier's plane wave is measured
    (`is_growth`): parameters are `PERTURBATION`, times and region are found, and the ``tolerance``
    is that of the rate, in units of the largest that the envelope equation has.

    Raises ValueError in one line: argument, condition, value, remedy.

    >>> LatticeScene.of(name="short", lattice="toda", constants={"a": 1, "b": 1}, eps=0.1,
    ...                 wave="kdv_soliton", parameters={"kappa": 2}, slow_times=[0, 0.1],
    ...                 half_width=4, tolerance=1e-3)
    <LatticeScene short: kdv_soliton with kappa = 2 on toda, eps = 0.1, leading order, to 0.001>
    """

    name: str
    lattice: str
    wave: str
    eps: float
    tolerance: float
    constants: Pairs = ()
    parameters: Pairs = ()
    order: str = "leading"
    slow_times: tuple[float, ...] = ()
    times: tuple[float, ...] = ()
    half_width: float | None = None
    compared: int | None = None
    amplitude: int | None = None
    time: int | None = None
    background: Value = 0
    carrier: Value = ""
    branch: str | int = "acoustic"
    disorder: Stated = ()
    declared: str = ""
    title: str = ""

    @classmethod
    def of(cls, **given: Any) -> LatticeScene:
        """A scene from keywords; ValueError for one that it does not have, or lacks."""
        names = [field.name for field in fields(cls)]
        check.known_fields(given, names)
        for name in names[:5]:
            if name not in given:
                raise ValueError(f"{name} must be stated, got nothing (state it)")
        return cls(**given)

    @classmethod
    def from_toml(cls, path: str | Path) -> LatticeScene:
        """Read a scene file (`lattice_scene_file.py` says what may stand in it)."""
        return cls.of_document(read_document(Path(path)), Path(path))

    @classmethod
    def of_document(cls, document: Mapping[str, Any], path: Path) -> LatticeScene:
        """The scene that the tables of a file at ``path`` describe."""
        try:
            return cls.of(**{"name": file_stem(path)} | lattice_scene_fields(document, path.parent))
        except ValueError as error:
            raise ValueError(f"{shown_path(path.name)}: {error}") from None

    @classmethod
    def from_json(cls, text: str) -> LatticeScene:
        """The scene that `json` wrote."""
        return cls.of(**json.loads(text))

    def __post_init__(self) -> None:
        for key in ("name", "lattice", "wave", "order", "declared", "title"):
            check.text(key, getattr(self, key))
        self._set("eps", finite("eps", self.eps))
        positive("eps", self.eps)
        if self.eps > LARGEST_EPS:
            raise ValueError(
                f"eps must satisfy eps <= {LARGEST_EPS:g}, got {self.eps:g} (such as 0.05)"
            )
        self._set("tolerance", check.tolerance(self.tolerance))
        check.one_of("order", self.order, ORDERS)
        for key in ("constants", "parameters"):
            self._set(key, _pairs(key, getattr(self, key)))
        self._set("carrier", _value("k", self.carrier))
        self._set("background", _value("background", self.background))
        self._set("disorder", disorder_pairs(self.disorder))
        self._set("declared", _canonical(self.declared))
        if self.is_growth:
            self._check_growth()
        else:
            self._check_moments()
            self._check_region()
        self._check_ansatz()

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    def _check_growth(self) -> None:
        for key, usual in (("slow_times", ()), ("times", ()), ("half_width", None)):
            if not getattr(self, key):
                self._set(key, usual)
        for key in ("slow_times", "times", "half_width", "compared"):
            if getattr(self, key) not in ((), None):
                raise ValueError(
                    f"{key} must not be given with the wave {PERTURBED_PLANE}, got "
                    f"{shown(getattr(self, key))} (when its growth is measured is found)"
                )
        if not self.is_envelope:
            raise ValueError(
                f"k in [envelope] must be given with the wave {PERTURBED_PLANE}, got nothing "
                '(such as k = "pi/2")'
            )
        if self.disorder:
            raise ValueError(
                f"disorder must not be given with the wave {PERTURBED_PLANE}, got "
                f"{shown(dict(self.disorder))} (its waves would be scattered into all others)"
            )
        names = [name for name, _ in self.parameters]
        unknown = [name for name in names if name not in PERTURBATION]
        if unknown or "amplitude" not in names or {"kappa", "share"} <= {*names}:
            raise ValueError(
                f"parameters of {PERTURBED_PLANE} must be amplitude, and kappa or share or "
                f"neither, got {shown(', '.join(names) or 'none')} (such as amplitude = 0.5)"
            )
        if self.order == "corrected":
            raise ValueError(
                f"order must be leading or slaved with the wave {PERTURBED_PLANE}, got corrected "
                "(its theory is the envelope equation alone)"
            )

    def _check_moments(self) -> None:
        for key in ("slow_times", "times"):
            if not getattr(self, key):
                self._set(key, ())
        given = [key for key in ("slow_times", "times") if getattr(self, key)]
        if len(given) != 1:
            got = "both" if given else "neither"
            raise ValueError(
                f"either slow_times or times must be given, got {got} (slow_times = [0, 1] is from "
                "T = 0 to T = 1)"
            )
        values = getattr(self, given[0])
        if not isinstance(values, list | tuple) or not 2 <= len(values) <= MOST_TIMES:
            raise ValueError(
                f"{given[0]} must be a list of 2 to {MOST_TIMES} times, got {shown(values)} "
                "(the first is the start)"
            )
        checked = tuple(finite(given[0], value) for value in values)
        if list(checked) != sorted(set(checked)):
            raise ValueError(f"{given[0]} must increase, got {shown(list(checked))} (sort them)")
        self._set(given[0], checked)

    def _check_region(self) -> None:
        if (self.half_width is None) == (self.compared is None):
            got = "neither" if self.compared is None else "both"
            raise ValueError(
                f"either half_width or compared must be given, got {got} (half_width = 10 is in X, "
                "compared = 200 in cells)"
            )
        if self.compared is not None:
            self._set("compared", whole("compared", self.compared))
        else:
            self._set("half_width", finite("half_width", self.half_width))
            positive("half_width", self.half_width or 0.0)

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

    @property
    def is_envelope(self) -> bool:
        """Whether the wave is the envelope of a carrier."""
        return self.carrier != ""

    @property
    def is_growth(self) -> bool:
        """Whether the growth rate of a plane wave is measured, and no wave compared."""
        return self.wave == PERTURBED_PLANE

    def check_compared(self) -> None:
        """Raise ValueError where no wave is compared but a growth rate measured."""
        if self.is_growth:
            raise ValueError(
                f"wave must be one that a lattice is compared with, got {self.wave}, whose growth "
                "rate is measured (`longwave run`, `sweep` and `plot` take it)"
            )

    def __repr__(self) -> str:
        given = ", ".join(f"{name} = {value}" for name, value in self.parameters)
        wave = f"{self.wave} with {given}" if given else self.wave
        return (
            f"<LatticeScene {self.name}: {wave} on {self.lattice}, eps = {self.eps:g}, "
            f"{self.order} order, to {self.tolerance:g}>"
        )

    def run(self, progress: Progress | None = None, announce: Announce | None = None) -> xr.Dataset:
        """The run of the scene, whether its wave is compared or a growth rate measured."""
        if self.is_growth:
            from longwave.scenes.sideband_growth import measure_growth

            return measure_growth(self, progress, announce).dataset
        from longwave.scenes.lattice_run import run_lattice_scene

        return run_lattice_scene(self, progress, announce).dataset

    def expected_cost(self) -> ExpectedCost:
        """What a run is expected to cost, by the lattice's waves about the rest.

        Raises ValueError as `run` does for what is wrong before anything is run.
        """
        from longwave.scenes.lattice_run import expected_lattice_cost

        return expected_lattice_cost(self)

    @property
    def process_seconds(self) -> float:
        """The part of the expected seconds that a process takes once."""
        from longwave.scenes.ring_cost import BEGIN_SECONDS

        return BEGIN_SECONDS

    def changed(self, **changes: Any) -> LatticeScene:
        """The scene with other values for some keywords of `of`."""
        return LatticeScene.of(**(self._keywords() | changes))

    def json(self) -> str:
        """The keywords of `of` as JSON, sorted."""
        return json.dumps(self._keywords(), sort_keys=True)

    def toml(self) -> str:
        """The scene as a file, with its name and, if it is declared, its lattice."""
        return toml_text(document_of(self._keywords()))

    def _keywords(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}


LARGEST_EPS = 1.0
"""A parameter that is not small is a mistake in its unit."""

LONGEST_FORMULA = 200
"""Characters of a value in text."""

MOST_TIMES = 200
"""Times at which the lattice is kept."""


def _value(name: str, value: object) -> Value:
    """A finite number as it is, or a text."""
    if isinstance(value, str):
        if len(value) > LONGEST_FORMULA:
            raise ValueError(
                f"{name} must be a short formula, got {len(value)} characters (such as 1/3)"
            )
        check.text(name, value)
        return value
    number = finite(name, value)
    return int(value) if isinstance(value, Integral) else number


def _canonical(declared: str) -> str:
    """A declared lattice in one spelling, without its name; ValueError for what is no table."""
    if not declared:
        return ""
    try:
        found = json.loads(declared)
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, Mapping):
        raise ValueError(
            f"declared must be a lattice's tables as JSON, got {shown(declared)} (read_lattice "
            "says what they hold)"
        )
    return json.dumps({key: value for key, value in found.items() if key != "name"})


def _pairs(name: str, given: object) -> Pairs:
    """Pairs of names and values, from a mapping or such pairs."""
    pairs = list(given.items()) if isinstance(given, Mapping) else given
    if not isinstance(pairs, list | tuple) or not all(
        isinstance(pair, list | tuple) and len(pair) == 2 for pair in pairs
    ):
        raise ValueError(
            f'{name} must be pairs of names and values, got {shown(given)} (such as {{"K2": 1}})'
        )
    found = tuple((str(key), _value(str(key), value)) for key, value in pairs)
    check.differing(name, found)
    return found


FOLDER = files("longwave.scenes.shipped")


def shipped_lattice_scenes() -> tuple[str, ...]:
    """Names of the scenes on further lattices that come with the package, sorted.

    >>> "toda_soliton" in shipped_lattice_scenes()
    True
    """
    found = (entry.name for entry in FOLDER.iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in found if name.endswith(".toml")))


def load_lattice_scene(name: str) -> LatticeScene:
    """The shipped scene of that name; ValueError lists them."""
    if name not in shipped_lattice_scenes():
        known = ", ".join(shipped_lattice_scenes())
        raise ValueError(f"scene must be a shipped one, got {shown(name)} (one of {known})")
    with as_file(FOLDER / f"{name}.toml") as path:
        return LatticeScene.from_toml(path)
