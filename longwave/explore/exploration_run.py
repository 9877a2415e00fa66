"""A chosen scene run in a process of its own: the newest choice counts, and none takes long.

`compare` runs a scene and keeps what a page shows; `Explorer` has it done elsewhere, drops what is
asked for no longer, and ends what takes too long.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache, partial
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.trial import Progress
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.methods import expected_cost, record_scene
from longwave.support.command_line import one_line
from longwave.support.processes import (
    Call,
    Job,
    LocalWorkers,
    LostProcess,
    OutOfTime,
    limit_memory,
)
from longwave.support.request_limits import (
    Cancelled,
    ExpectedCost,
    OverBudgetError,
    RequestLimits,
    check_request,
    duration,
    request_limits,
)

if TYPE_CHECKING:
    import xarray as xr


Array = NDArray[np.float64]

USUAL_LIMITS = RequestLimits(memory_bytes=2e9, seconds=10.0)
"""What a run may take unless told; one that is expected to take more is refused."""

DEADLINE = 6.0
"""A run is ended after so many times what it may be expected to take."""

CHEAPER = "take a larger eps, shorter times or a smaller half_width; `longwave run` takes the file"

MOST_CELLS = 100_000
"""Most compared cells: `FRAMES` pictures of them are sent to the page and drawn."""

MAP_COLUMNS = 300
"""Most columns of a space-time map."""


class WaveTexts(NamedTuple):
    """What a wave's record says: title, source, and in LaTeX its equation's normal form and itself.

    ``formula`` is empty where it would fill pages.
    """

    title: str
    reference: str
    normal_form: str
    formula: str


LONGEST_FORMULA = 1500
"""Signs of a formula in LaTeX beyond which nobody reads it on the page."""


@lru_cache(maxsize=64)
def wave_texts(wave: str, parameters: tuple[str, ...]) -> WaveTexts:
    """The texts of a wave with values of these parameters."""
    from longwave.solutions import closed_form

    form = closed_form(wave, parameters)
    formula = form._repr_latex_() or ""
    return WaveTexts(
        form.title,
        str(form.reference),
        form.equation._repr_latex_(),
        formula if len(formula) <= LONGEST_FORMULA else "",
    )


@dataclass(frozen=True)
class Comparison:
    """Lattice and wave on the compared cells at all times, both in units of eps to a power.

    ``X``, ``lattice`` and ``wave`` are (time, cell), X = eps (n - c t); on a lattice of two
    dimensions they are the row through its middle. ``errors`` are the largest differences over all
    compared cells, ``relative`` the same in units of the wave's height above its background;
    ``estimate`` says how far the run itself may be from the infinite lattice. ``lines`` tell what
    was done.
    """

    X: Array
    times: Array
    slow_times: Array
    lattice: Array
    wave: Array
    errors: Array
    relative: Array
    estimate: float
    unit: str
    equation: str
    equation_latex: str
    wave_texts: WaveTexts
    lines: tuple[str, ...]
    field: str = "strain"
    ended: str = ""

    def columns(self, values: Array) -> Array:
        """The values (time, cell) in at most `MAP_COLUMNS` cells, each the largest in modulus.

        >>> texts = WaveTexts("kink", "", "", "")
        >>> shown = Comparison(*[np.zeros((1, 600))] * 7, 0.0, "eps", "", "", texts, ())
        >>> shown.columns(np.arange(1200.0).reshape(2, 600)).shape
        (2, 300)
        """
        width = -(-values.shape[1] // MAP_COLUMNS)
        starts = np.arange(0, values.shape[1], width)
        high = np.maximum.reduceat(values, starts, axis=1)
        low = np.minimum.reduceat(values, starts, axis=1)
        return np.where(np.abs(high) >= np.abs(low), high, low)


def compare(
    scene: Scene, progress: Progress | None = None, limits: RequestLimits = USUAL_LIMITS
) -> Comparison:
    """Run a scene and keep what is shown of it.

    Raises ValueError, in one line, for everything that wave, lattice and scene do not admit, and
    for a scene that is expected to take more than the ``limits``: before it is run, or where its
    search turns out to take longer.
    """

    def announce(seconds: float) -> None:
        try:
            check_request("the run", ExpectedCost(seconds), CHEAPER)
        except OverBudgetError as error:
            raise Cancelled from error  # what catches a ValueError would go on without the run

    _check_cells(scene)
    try:
        with request_limits(limits.memory_bytes, limits.seconds):
            check_request("the run", expected_cost(scene), CHEAPER)
            return _compared(scene, progress, announce)
    except Cancelled as stop:
        raise (stop.__cause__ or stop) from None
    except MemoryError:
        raise ValueError(
            "sites must fit the memory, got a scene that does not (a larger eps or a smaller "
            "half_width take less)"
        ) from None


def _check_cells(scene: Scene) -> None:
    powers = (1, 2)[: scene.symbolic_lattice.dimension]
    cells = math.prod(2 * scene.cells_within(power) + 1 for power in powers)
    if cells > MOST_CELLS:
        raise ValueError(
            f"half_width / eps must ask for at most {MOST_CELLS} cells here, got {cells} for eps = "
            f"{scene.eps:g} (take a smaller half_width or a larger eps)"
        )


def _compared(scene: Scene, progress: Progress | None, announce: Any) -> Comparison:
    from longwave.cli.scene_command import summary_lines
    from longwave.scenes.engines.run_record import error_unit
    from longwave.scenes.starts.lattice_derivation import derivation

    record = record_scene(scene, progress, announce)
    run, told = record.dataset, record.attrs
    if not run.sizes["time"]:
        raise ValueError(f"{told['blow_up']} (no time is reached; take a smaller eps)")
    scale = scene.eps ** told["power"]
    lattice, wave = (_middle_row(run[name].values) for name in ("strain", "analytic"))
    errors = _largest(run.get("strains", run["strain"]) - run.get("analytics", run["analytic"]))
    relative = np.where(np.isnan(run["error"]), errors / np.max(np.abs(wave)), run["error"])
    derived = derivation(scene)
    return Comparison(
        X=_distances(scene.eps, run),
        times=run["time"].values,
        slow_times=run["time"].values * scene.eps**derived.slow,
        lattice=lattice / scale,
        wave=wave / scale,
        errors=errors / scale,
        relative=relative,
        estimate=float(told["error_estimate"]),
        unit=error_unit(told["power"]),
        field=told.get("field_kind", "strain"),
        equation=derived.text(),
        equation_latex=derived.latex(),
        wave_texts=wave_texts(str(scene.wave), tuple(name for name, _ in scene.parameters)),
        lines=tuple(summary_lines(record, scene)),
        ended=told["blow_up"],
    )


def _largest(values: xr.DataArray) -> Array:
    """The largest size at each time."""
    return np.max(np.abs(values.values), axis=tuple(range(1, values.ndim)))


def _distances(eps: float, run: xr.Dataset) -> Array:
    """X = eps (n - c t) of every compared cell at every time."""
    travelled = run.attrs["frame_speed"] * run["time"].values
    places: Array = eps * (run["n"].values - travelled[:, None])
    return places


def _middle_row(values: Array) -> Array:
    return values if values.ndim == 2 else values[:, :, values.shape[2] // 2]


@dataclass(frozen=True)
class Refusal:
    """Why there is nothing to be shown, in one line."""

    line: str


Answer = float | Comparison | Refusal
"""How far a run is, 0 .. 1; what came of it; or why nothing did."""


class Explorer:
    """Compares the scene that was asked for last, in a process of its own.

    The process is started with the first question, and again after one that had to be ended.
    """

    def __init__(self, limits: RequestLimits = USUAL_LIMITS) -> None:
        self.limits = limits
        self._workers = LocalWorkers(1, partial(_prepare, limits))
        self._call: Call | None = None

    def start(self) -> None:
        """Start the process, which imports what it takes."""
        self._workers.start()

    def ask(self, scene: Scene) -> None:
        """Have this scene compared, and no other."""
        deadline = DEADLINE * self.limits.seconds
        job = Job(_answer, (scene, self.limits), tells=True, seconds=deadline, gives_way=True)
        self._call = self._workers.submit(job)

    def drop(self) -> None:
        """Ask for nothing any more; what is being run ends when something is asked again."""
        self._call = None

    def answer(self) -> Answer | None:
        """What is new about what was asked last; None if there is nothing."""
        call, ended = self._call, self._workers.ended(0.0)
        if call is None:
            return None
        if call not in ended:
            share: float | None
            share, call.message = call.message, None
            return share
        self._call = None
        try:
            found: Answer = call.result()
        except LostProcess:
            return Refusal("the run's process ended before the run (too little memory?)")
        except OutOfTime:
            taken = duration(DEADLINE * self.limits.seconds)
            return Refusal(f"the run was ended after {taken} (a larger eps takes less)")
        return found

    def close(self) -> None:
        """End the process."""
        self._workers.stop()
        self._call = None


BEFOREHAND = (
    "longwave.cli.scene_command",
    "longwave.scenes.engines.lattice_run",
    "longwave.derive.reduction",
    "xarray",
)
"""Modules that a process takes whatever is asked."""

ROOM = 5e8
"""Bytes that a process may take to see that a run would not fit a smaller limit, and to say it."""


def _prepare(limits: RequestLimits) -> None:
    """In a new process: import, and hold the limit of memory from then on."""
    for module in BEFOREHAND:
        import_module(module)
    if math.isfinite(limits.memory_bytes):
        limit_memory(int(max(limits.memory_bytes, ROOM)))


def _answer(scene: Scene, limits: RequestLimits, progress: Progress) -> Answer:
    """The comparison, or why there is none."""
    try:
        return compare(scene, progress, limits)
    except (ValueError, OSError, ArithmeticError, RuntimeError) as error:
        return Refusal(one_line(error))
