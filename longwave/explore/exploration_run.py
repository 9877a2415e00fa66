"""Running the explorer's current scene in a worker process, with limits of time and memory.

`compare` runs a scene and returns what the page shows. `Explorer` does this in a worker process,
discards outdated scenes, and stops those that take too long.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache, partial
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.trial import Progress
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.methods import expected_cost, record_scene
from longwave.support import processes
from longwave.support.command_line import one_line
from longwave.support.request_limits import (
    Cancelled,
    ExpectedCost,
    OverBudgetError,
    RequestLimits,
    check_request,
    duration,
    request_limits,
)

Array = NDArray[np.float64]

DEFAULT_LIMITS = RequestLimits(memory_bytes=2e9, seconds=10.0)
"""Default limits of a run; a run that is expected to exceed them is refused."""

DEADLINE_FACTOR = 6.0
"""Multiple of a run's time limit after which the run is stopped."""

CHEAPER_ADVICE = (
    "take a larger eps, shorter times or a smaller half_width; `longwave run` takes the file"
)

MAX_CELLS = 100_000
"""Largest number of compared cells; the page draws `FRAMES` frames of them."""

MAP_COLUMNS = 300
"""Largest number of columns of a space-time map."""


class WaveTexts(NamedTuple):
    """Texts about a wave: title, source, normal form of its equation and its formula, in LaTeX.

    ``formula`` is empty if it is too long to be read.
    """

    title: str
    reference: str
    normal_form: str
    formula: str


MAX_FORMULA_CHARACTERS = 1500
"""Largest length of a formula in LaTeX that the page shows."""


@lru_cache(maxsize=64)
def wave_texts(wave: str, parameters: tuple[str, ...]) -> WaveTexts:
    """Return the texts of the wave called ``wave``, with the parameters of these names."""
    from longwave.solutions import closed_form

    form = closed_form(wave, parameters)
    formula = form._repr_latex_() or ""
    formula = formula if len(formula) <= MAX_FORMULA_CHARACTERS else ""
    return WaveTexts(form.title, str(form.reference), form.equation._repr_latex_(), formula)


@dataclass(frozen=True)
class Comparison:
    """Lattice and wave in the compared cells at all times, in units of a power of eps.

    ``X``, ``lattice`` and ``wave`` have shape (time, cell), with X = eps (n - c t). On a
    two-dimensional lattice they are the row through its middle. ``errors`` are the largest
    differences over all compared cells at each time, and ``relative`` the same in units of the
    wave's height above its background. ``estimate`` is the estimated distance of the run from the
    infinite lattice. ``lines`` summarise the run.
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
        """Reduce values (time, cell) to at most `MAP_COLUMNS` columns, by the largest modulus.

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
    scene: Scene, progress: Progress | None = None, limits: RequestLimits = DEFAULT_LIMITS
) -> Comparison:
    """Run a scene and return its comparison with the wave.

    Raises ValueError in one line if wave, lattice or scene do not admit the values, and if the run
    is expected to exceed the ``limits``, before it starts or after its step has been searched.
    """

    def announce(seconds: float) -> None:
        try:
            check_request("the run", ExpectedCost(seconds), CHEAPER_ADVICE)
        except OverBudgetError as error:
            raise Cancelled from error  # a ValueError would be caught and taken for another fault

    _check_cells(scene)
    try:
        with request_limits(limits.memory_bytes, limits.seconds):
            check_request("the run", expected_cost(scene), CHEAPER_ADVICE)
            return _compare_within_limits(scene, progress, announce)
    except Cancelled as cancelled:
        raise (cancelled.__cause__ or cancelled) from None
    except MemoryError:
        raise ValueError(
            "sites must fit into the memory, got a scene that does not (take a larger eps or a "
            "smaller half_width)"
        ) from None


def _check_cells(scene: Scene) -> None:
    powers = (1, 2)[: scene.symbolic_lattice.dimension]
    cells = math.prod(2 * scene.cells_within(power) + 1 for power in powers)
    if cells > MAX_CELLS:
        got = f"{cells} for eps = {scene.eps:g} (take a smaller half_width or a larger eps)"
        raise ValueError(f"half_width / eps must ask for at most {MAX_CELLS} cells here, got {got}")


def _compare_within_limits(scene: Scene, progress: Progress | None, announce: Any) -> Comparison:
    from longwave.cli.scene_command import summary_lines
    from longwave.scenes.engines.run_record import error_unit
    from longwave.scenes.starts.lattice_derivation import derivation

    record = record_scene(scene, progress, announce)
    run, attrs = record.dataset, record.attrs
    if not run.sizes["time"]:
        raise ValueError(f"{attrs['blow_up']} (before the first time; take a smaller eps)")
    scale = scene.eps ** attrs["power"]
    lattice, wave = (_middle_row(run[name].values) for name in ("strain", "analytic"))
    difference = run.get("strains", run["strain"]) - run.get("analytics", run["analytic"])
    sizes = np.abs(difference.values).reshape(difference.shape[0], -1)
    errors = np.max(sizes, axis=1)
    relative = np.where(np.isnan(run["error"]), errors / np.max(np.abs(wave)), run["error"])
    derived, distance = derivation(scene), run.attrs["frame_speed"] * run["time"].values
    return Comparison(
        X=scene.eps * (run["n"].values - distance[:, None]),
        times=run["time"].values,
        slow_times=run["time"].values * scene.eps**derived.slow,
        lattice=lattice / scale,
        wave=wave / scale,
        errors=errors / scale,
        relative=relative,
        estimate=float(attrs["error_estimate"]),
        unit=error_unit(attrs["power"]),
        field=attrs.get("field_kind", "strain"),
        equation=derived.text(),
        equation_latex=derived.latex(),
        wave_texts=wave_texts(str(scene.wave), tuple(name for name, _ in scene.parameters)),
        lines=tuple(summary_lines(record, scene)),
        ended=attrs["blow_up"],
    )


def _middle_row(values: Array) -> Array:
    return values if values.ndim == 2 else values[:, :, values.shape[2] // 2]


@dataclass(frozen=True)
class Refusal:
    """Reason, in one line, why a scene has no comparison."""

    line: str


Answer = float | Comparison | Refusal
"""State of a run: the finished fraction 0 to 1, the `Comparison`, or the `Refusal`."""


class Explorer:
    """Compares the last submitted scene in a worker process, restarted after a run was stopped."""

    def __init__(self, limits: RequestLimits = DEFAULT_LIMITS) -> None:
        self.limits = limits
        self._workers = processes.LocalWorkers(1, partial(_prepare_worker, limits))
        self._call: processes.Call | None = None

    def start(self) -> None:
        """Start the worker, which imports its modules."""
        self._workers.start()

    def submit(self, scene: Scene) -> None:
        """Submit a scene to be run; it replaces the one submitted before."""
        deadline = DEADLINE_FACTOR * self.limits.seconds
        job = processes.Job(
            _compare_in_worker, (scene, self.limits), tells=True, seconds=deadline, gives_way=True
        )
        self._call = self._workers.submit(job)

    def cancel(self) -> None:
        """Discard the submitted scene; its run is stopped when the next one is submitted."""
        self._call = None

    def answer(self) -> Answer | None:
        """Return the latest state of the submitted scene's run; None if there is nothing new."""
        call, finished = self._call, self._workers.ended(0.0)
        if call is None:
            return None
        if call not in finished:
            share: float | None
            share, call.message = call.message, None
            return share
        self._call = None
        try:
            answer: Answer = call.result()
        except processes.LostProcess:
            return Refusal("the worker process ended before its run (too little memory?)")
        except processes.OutOfTime:
            duration_text = duration(DEADLINE_FACTOR * self.limits.seconds)
            return Refusal(f"the run was stopped after {duration_text} (a larger eps is faster)")
        return answer

    def close(self) -> None:
        """Stop the worker."""
        self._workers.stop()
        self._call = None


PRELOADED = (
    "longwave.cli.scene_command",
    "longwave.scenes.engines.lattice_run",
    "longwave.derive.reduction",
    "xarray",
)
"""Modules that the worker imports at its start."""

LEAST_MEMORY = 5e8
"""Bytes that a worker may use even under a smaller limit, so that it can report the excess."""


def _prepare_worker(limits: RequestLimits) -> None:
    """Import modules in a new worker process and set its memory limit."""
    for module in PRELOADED:
        import_module(module)
    if math.isfinite(limits.memory_bytes):
        processes.limit_memory(int(max(limits.memory_bytes, LEAST_MEMORY)))


def _compare_in_worker(scene: Scene, limits: RequestLimits, progress: Progress) -> Answer:
    """Return the comparison of a scene, or a `Refusal` with the reason why there is none."""
    try:
        return compare(scene, progress, limits)
    except (ValueError, OSError, ArithmeticError, RuntimeError) as error:
        return Refusal(one_line(error))
