"""Fits of a bench scene's constants and losses to the records of its sensors.

Each evaluation runs the lattice with exact derivatives by the fitted constants
(`lattice.sensitivities`). The step is the one with which the chain meets the scene's tolerance.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import optimize, stats
from sympy import Expr

from longwave.derive.algebra.exact_numbers import exact
from longwave.derive.lattice_file import document_of_lattice
from longwave.derive.symbols import number_value
from longwave.lattice.driving import DrivenChain
from longwave.lattice.force_program import program_of
from longwave.lattice.integration import integrate
from longwave.lattice.sensitivities import FreeParameter, Sensor, VariedChain
from longwave.scenes.description.bench import FORCE_TABLES
from longwave.scenes.description.losses import Losses, lossy, without_losses
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.scenes.fits import least_squares
from longwave.scenes.fits.sensor_records import SensorRecord, read_record
from longwave.scenes.starts.bench_chain import chain_on_bench, start_on_bench
from longwave.support.known_names import one_of
from longwave.support.real_arrays import Array
from longwave.support.user_files import shown

FITTED_TABLES = ("chain", "start", *FORCE_TABLES, "observables")
"""Tables of a bench that are allowed in a fit: those for which derivatives of readings exist."""

LOSS_NAMES = {"siteloss": "losses.site", "bondloss": "losses.bond"}
"""Name of each fitted loss, by the name of the symbol that replaces it in the equations."""

MAX_RUNS, CONVERGED_CHANGE = 200, 1e-10
"""Maximum number of runs, and relative change of constants or chi^2 that ends a fit."""

STEP_FRACTION = 0.9
"""If the fitted constants need a time step shorter than this fraction of the step of the fit, the
fit is continued with the shorter step."""

MAX_LAG = 5
"""Largest lag, in readings, at which the correlation of residuals is tested."""

TINY_SQUARES = 1e-300
"""Lower bound of a sum of squares used as a divisor; avoids division by 0."""

TOLERANCE_FRACTION = 0.1
"""Largest tolerance of the scene that causes no doubt, as a fraction of a reading's deviation."""


class SceneModel:
    """Model of a scene's sensor readings as a function of its free constants and losses.

    Raises ValueError for tables other than `FITTED_TABLES` and unknown names in ``free``.
    """

    def __init__(self, scene: Scene, free: Sequence[str]) -> None:
        self.scene, self.free, self._bench = scene, tuple(free), scene.own_bench
        for table in self._bench.stated.tables:
            if table not in FITTED_TABLES:
                raise ValueError(
                    f"tables of a scene to fit must be among {', '.join(FITTED_TABLES)}, got "
                    f"[{table}] (leave it out)"
                )
        stated = {name: float(number_value(name, value)) for name, value in scene.constants}
        losses = {"site": 0, "bond": 0} | (scene.losses.table if scene.losses else {})
        for key, value in losses.items():
            if isinstance(value, int | float):
                stated[f"losses.{key}"] = float(value)
                losses[key] = f"{key}loss"
        self._lattice = lossy(scene.symbolic_lattice.with_losses(), Losses.of(losses))
        self._symbols = {LOSS_NAMES.get(str(s), str(s)): s for s in self._lattice.constants}
        self.stated = stated
        for name in self.free:
            if name not in self.stated or self.free.count(name) > 1:
                raise ValueError(
                    f"free must name constants of the scene, each once, got {shown(name)} "
                    f"({one_of(name, self.stated)})"
                )
        if not self.free:
            raise ValueError("free must name the constants to fit, got nothing (such as K4)")
        self.start = np.array([self.stated[name] for name in self.free])
        loss_names = LOSS_NAMES.values()
        positive = [name in loss_names or self._symbols[name].is_positive for name in self.free]
        self.least = np.where(positive, 0.0, -math.inf)

    def at(self, values: ArrayLike) -> dict[str, float]:
        """Return all constants and numeric losses by name, with ``values`` for the free ones."""
        return self.stated | dict(zip(self.free, np.asarray(values).tolist(), strict=True))

    def chain(self, values: ArrayLike) -> DrivenChain:
        """Return the chain on its bench; ``values`` are those of the free constants."""
        numbers = self.at(values)
        constants = {str(s): exact(name, numbers[name]) for name, s in self._symbols.items()}
        lattice, losses = without_losses(self._lattice, constants)
        span = self.scene.t0, self.scene.end
        return chain_on_bench(self._bench, lattice, span, losses)

    def step(self, values: ArrayLike, times: Array) -> float:
        """Return the time step with which fields and velocities meet the scene's tolerance."""
        chain, tolerance = self.chain(values), self.scene.target.tolerance
        start = start_on_bench(self._bench, chain, self.scene.t0)
        return integrate(chain, start, times, tolerance, judged=lambda f, v, _: [f, v]).step

    def readings(
        self, values: ArrayLike, times: Array, sensors: Sequence[Sensor], step: float
    ) -> Array:
        """Return the sensor readings and their derivatives, shape (times, sensors, 1 + free)."""
        chain = self.chain(values)
        start = start_on_bench(self._bench, chain, self.scene.t0)
        with np.errstate(all="ignore"):
            varied = VariedChain(chain, [self._parameter(name, values) for name in self.free])
            return varied.readings(start, times, step, sensors)

    def _parameter(self, name: str, values: ArrayLike) -> FreeParameter:
        lattice, numbers, symbol = self._lattice, self.at(values), self._symbols[name]
        at = {other: numbers[key] for key, other in self._symbols.items()}

        def slopes(expressions: Iterable[Expr]) -> tuple[float, ...]:
            return tuple(float(one.diff(symbol).subs(at)) for one in expressions)

        forces = [bond.force.diff(symbol).subs(at) for bond in lattice.bonds]
        return FreeParameter(
            tuple(program_of(force) if force else None for force in forces),
            slopes(lattice.masses),
            slopes(lattice.site_losses),
            slopes(bond.loss for bond in lattice.bonds),
        )


@dataclass(frozen=True, repr=False)
class SceneFit(least_squares.LeastSquares):
    """Result of fitting a scene's constants and losses to sensor records.

    ``values`` and ``covariance`` are those of ``model.free``. ``left`` holds the weighted residuals
    of each record, (times, sensors). ``noise`` is the deviation estimated from residuals; None if
    deviations were recorded. ``at_bounds`` names the constants at their lower bound.
    """

    model: SceneModel
    records: tuple[SensorRecord, ...]
    values: Array
    covariance: Array
    left: tuple[Array, ...]
    step: float
    noise: float | None = None
    at_bounds: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the fitted constants and losses."""
        return self.model.free

    @property
    def has_deviations(self) -> bool:
        """Whether the records contain standard deviations."""
        return self.noise is None

    @property
    def residuals(self) -> Array:
        """Recorded minus fitted readings, over their deviations, as a flat array."""
        return np.concatenate([part.ravel() for part in self.left])

    @cached_property
    def serial_p_value(self) -> float:
        """p-value of the residuals' correlation in time, by a test like Box and Pierce's.

        For each lag from 1 to `MAX_LAG` readings, the products of residuals are summed over all
        sensors; the squared sums over their variances add up to a chi^2 of `MAX_LAG` degrees. The
        variances are estimated from the products, because theoretical variances would give
        p < 0.01 in 3 of 100 cases for sensors with 10 readings.
        """
        total = 0.0
        for lag in range(1, MAX_LAG + 1):
            products = np.concatenate([(part[lag:] * part[:-lag]).ravel() for part in self.left])
            total += float(products.sum()) ** 2 / max(float(products @ products), TINY_SQUARES)
        return float(stats.chi2.sf(total, MAX_LAG))

    @property
    def doubts(self) -> list[str]:
        """Reasons, as sentences, to think that the model is wrong or poorly determined."""
        doubts = self.doubts_of_size("the scene", "readings")
        if self.serial_p_value < least_squares.DOUBT_LEVEL:
            doubts.append(
                "the residuals are correlated in time, as for a wrong model: "
                f"p = {self.serial_p_value:.1g}"
            )
        doubts += self.undetermined_constants()
        doubts += [
            f"{name} is at its bound, 0: its interval is unreliable" for name in self.at_bounds
        ]
        smallest = self.noise or min(float(np.min(r.deviations)) for r in self.records)  # type: ignore[arg-type]
        if self.model.scene.target.tolerance > TOLERANCE_FRACTION * smallest:
            doubts.append(
                f"the scene's tolerance, {self.model.scene.target.tolerance:g}, is not small "
                f"compared with the deviation of a reading, {smallest:.2g}: lower the tolerance"
            )
        return doubts

    def document(self) -> dict[str, Any]:
        """Return the tables of a lattice file, with constants and the fitted ones' covariance."""
        lattice = self.model.scene.symbolic_lattice.with_losses()
        numbers, names = self.model.at(self.values), [str(symbol) for symbol in lattice.constants]
        rows = (dict(zip(self.names, row, strict=True)) for row in self.covariance.tolist())
        covariance = {
            one: {two: row[two] for two in self.names if two in names}
            for one, row in zip(self.names, rows, strict=True)
            if one in names
        }
        constants = {name: numbers[name] for name in names}
        return {**document_of_lattice(lattice), "constants": constants, "covariance": covariance}


def fit_scene(
    scene: str | Path | Scene, records: Sequence[str | Path | SensorRecord], free: Sequence[str]
) -> SceneFit:
    """Fit constants, ``losses.site`` and ``losses.bond`` of a scene to records of its sensors.

    The fit starts from the scene's values. Raises ValueError for an unsuitable scene or record, and
    for constants that the records do not determine; the message names them.
    """
    model = SceneModel(scene if isinstance(scene, Scene) else load_scene(scene), free)
    chain, span = model.chain(model.start), (model.scene.t0, model.scene.end)
    loaded = tuple(
        one if isinstance(one, SensorRecord) else read_record(one, chain.ordered, chain.cells, span)
        for one in records
    )
    known = _check_records(model, loaded)
    problem = _Problem(model, loaded)
    result = problem.least(model.start)
    covariance = problem.unit_covariance(result.jac)
    noise = 1.0
    if not known:
        covariance, noise = least_squares.estimate_noise(covariance, result.fun, math.ulp(1.0))
    left = tuple(part / noise for part in problem.parts(-result.fun))
    bounds = tuple(name for name, on in zip(model.free, result.active_mask, strict=True) if on)
    estimate = None if known else noise
    return SceneFit(model, loaded, result.x, covariance, left, problem.step, estimate, bounds)


def _check_records(model: SceneModel, records: Sequence[SensorRecord]) -> bool:
    """Check the records, and return whether they contain standard deviations.

    Raises ValueError if only some records contain them, if several quantities are recorded without
    them, and for too few readings.
    """
    known = {record.deviations is not None for record in records}
    quantities = {sensor.quantity for record in records for sensor in record.sensors}
    if len(known) != 1 or (known == {False} and len(quantities) > 1):
        got = " and ".join(sorted(quantities)) or "no record"
        raise ValueError(
            "deviations must be given in all records or in none, and always for several "
            f"quantities, got {got} without (add columns such as displacement_0_deviation)"
        )
    count, least = sum(r.values.size for r in records), len(model.free) + least_squares.MIN_DEGREES
    if count < least:
        raise ValueError(
            f"readings must be at least {least} for {len(model.free)} constants, got {count} "
            "(record more, or fit fewer)"
        )
    return known == {True}


class _Problem:
    """Least-squares problem of all records; each evaluation is one run of the model."""

    def __init__(self, model: SceneModel, records: Sequence[SensorRecord]) -> None:
        self._model, self._records = model, records
        self._times = np.unique(np.concatenate([record.times for record in records]))
        self._sensors = list(dict.fromkeys(s for record in records for s in record.sensors))
        self._cached: tuple[tuple[float, ...], Array] | None = None
        self.step = math.nan

    def least(self, start: Array) -> optimize.OptimizeResult:
        """Fit from ``start``, repeatedly while the result needs a shorter time step.

        Raises ValueError if the fit does not converge.
        """
        result, self.step = None, math.inf
        while (step := self._model.step(start, self._times)) < STEP_FRACTION * self.step:
            self.step, self._cached = step, None
            self.unit_covariance(self._evaluate(start)[:, 1:])
            result = optimize.least_squares(
                lambda values: self._evaluate(values)[:, 0],
                start,
                lambda values: self._evaluate(values)[:, 1:],
                bounds=(self._model.least, np.inf),
                x_scale="jac",
                max_nfev=MAX_RUNS,
                xtol=CONVERGED_CHANGE,
                ftol=CONVERGED_CHANGE,
            )
            start = result.x
        if result is None or not result.success:
            raise ValueError(
                "scene must converge to constants of least chi^2, got some that still change "
                f"after {MAX_RUNS} runs (start nearer, or fit fewer)"
            )
        return result

    def unit_covariance(self, jacobian: Array) -> Array:
        """Return the covariance for residuals of deviation 1; ValueError if undetermined."""
        remedy = "leave {} out, or place more sensors"
        return least_squares.unit_covariance(jacobian, self._model.free, "records", remedy)

    def _evaluate(self, values: Array) -> Array:
        """Return residuals and their derivatives, (readings, 1 + free); caches the latest."""
        at = tuple(values.tolist())
        if self._cached is None or self._cached[0] != at:
            readings = self._model.readings(values, self._times, self._sensors, self.step)
            rows = np.concatenate([self._residuals(readings, r) for r in self._records])
            self._cached = at, rows
        return self._cached[1]

    def _residuals(self, readings: Array, record: SensorRecord) -> Array:
        rows = np.searchsorted(self._times, record.times)
        columns = np.array([self._sensors.index(sensor) for sensor in record.sensors])
        residuals = readings[np.ix_(rows, columns)]
        residuals[..., 0] -= record.values
        if record.deviations is not None:
            residuals /= record.deviations[..., np.newaxis]
        return residuals.reshape(-1, residuals.shape[-1])

    def parts(self, residuals: Array) -> list[Array]:
        """Split flat residuals into one array (times, sensors) for each record."""
        sizes = np.cumsum([record.values.size for record in self._records])[:-1]
        pairs = zip(np.split(residuals, sizes), self._records, strict=True)
        return [part.reshape(record.values.shape) for part, record in pairs]
