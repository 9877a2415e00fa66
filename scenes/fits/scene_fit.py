"""Constants and losses of a chain on a bench, fitted to what its sensors recorded.

Each run is the lattice's own, its derivatives by what is fitted are exact
(`lattice.sensitivities`), and its step the one with which the chain meets the scene's tolerance.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import optimize, stats
from sympy import Expr

from longwave.derive.algebra.exact_numbers import exact
from longwave.derive.lattice_file import document_of_lattice
from longwave.derive.symbols import number_value
from longwave.lattice.driving import DrivenChain
from longwave.lattice.force_program import program_of
from longwave.lattice.integration import integrate
from longwave.lattice.sensitivities import FreeParameter, Sensor, VariedChain
from longwave.scenes.description.bench import ACTING
from longwave.scenes.description.losses import Losses, lossy, without_losses
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.scenes.fits.least_squares import (
    DOUBTFUL,
    SPARE,
    LeastSquares,
    inverse_square,
    of_residuals,
)
from longwave.scenes.fits.sensor_records import SensorRecord, read_record
from longwave.scenes.starts.bench_chain import chain_on_bench, start_on_bench
from longwave.support.known_names import one_of
from longwave.support.user_files import shown

Array = NDArray[np.float64]

FITTED = ("chain", "start", *ACTING, "observables")
"""Tables of a bench of which readings have derivatives."""

LOSSES = {"siteloss": "losses.site", "bondloss": "losses.bond"}
"""Names of losses that are numbers, by their symbols."""

EVALUATIONS, CLOSE = 200, 1e-10
"""Most runs, and the relative change of constants and chi^2 at which they have come to rest."""

AS_LONG = 0.9
"""Of the step of a fit; a shorter one is judged to be needed where it has ended: it goes on."""

LAGS = 5
"""Readings apart to which residuals are correlated."""

ROUNDED = 1e-300
"""A sum of squares that is none."""

SMALL = 0.1
"""Share of a reading's deviation that the scene's tolerance may be."""


class SceneModel:
    """The readings of a scene's sensors as a function of some of its constants and losses."""

    def __init__(self, scene: Scene, free: Sequence[str]) -> None:
        bench = scene.own_bench
        for table in bench.stated.tables:
            if table not in FITTED:
                raise ValueError(
                    f"tables of a scene that is fitted must be {', '.join(FITTED)}, got [{table}] "
                    "(leave it out)"
                )
        self.scene, self.free = scene, tuple(free)
        self._bench = bench
        stated = {name: float(number_value(name, value)) for name, value in scene.constants}
        losses = {"site": 0, "bond": 0} | (scene.losses.table if scene.losses else {})
        for key, value in losses.items():
            if isinstance(value, int | float):
                stated[f"losses.{key}"] = float(value)
                losses[key] = f"{key}loss"
        self._lattice = lossy(scene.symbolic_lattice.with_losses(), Losses.of(losses))
        self._symbols = {LOSSES.get(str(s), str(s)): s for s in self._lattice.constants}
        self.stated = stated
        for name in self.free:
            if name not in self.stated or self.free.count(name) > 1:
                raise ValueError(
                    f"free must name constants of the scene, each once, got {shown(name)} "
                    f"({one_of(name, self.stated)})"
                )
        if not self.free:
            raise ValueError("free must name what is fitted, got nothing (such as K4)")
        self.start = np.array([self.stated[name] for name in self.free])
        lost = LOSSES.values()
        positive = [name in lost or self._symbols[name].is_positive for name in self.free]
        self.least = np.where(positive, 0.0, -math.inf)

    def at(self, values: ArrayLike) -> dict[str, float]:
        """All constants, and the losses that are numbers, at these values."""
        return self.stated | dict(zip(self.free, np.asarray(values).tolist(), strict=True))

    def chain(self, values: ArrayLike) -> DrivenChain:
        """The chain at these values."""
        now = self.at(values)
        exactly = {str(symbol): exact(name, now[name]) for name, symbol in self._symbols.items()}
        lattice, losses = without_losses(self._lattice, exactly)
        span = self.scene.t0, self.scene.end
        return chain_on_bench(self._bench, lattice, span, losses)

    def step(self, values: ArrayLike, times: Array) -> float:
        """The step with which displacements and velocities meet the scene's tolerance."""
        chain = self.chain(values)
        start = start_on_bench(self._bench, chain, self.scene.t0)
        tolerance = self.scene.target.tolerance
        return integrate(chain, start, times, tolerance, judged=lambda f, v, _: [f, v]).step

    def readings(
        self, values: ArrayLike, times: Array, sensors: Sequence[Sensor], step: float
    ) -> Array:
        """What the sensors read, and its derivatives, (times, sensors, 1 + free)."""
        chain = self.chain(values)
        start = start_on_bench(self._bench, chain, self.scene.t0)
        with np.errstate(all="ignore"):
            varied = VariedChain(chain, [self._parameter(name, values) for name in self.free])
            return varied.readings(start, times, step, sensors)

    def _parameter(self, name: str, values: ArrayLike) -> FreeParameter:
        lattice, now, symbol = self._lattice, self.at(values), self._symbols[name]
        at = {other: now[key] for key, other in self._symbols.items()}

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
class SceneFit(LeastSquares):
    """Constants and losses of a scene at which its sensors read what was recorded.

    ``values`` and ``covariance`` are those of ``model.free``; ``left`` are the residuals of each
    record over the deviations, (times, sensors), ``noise`` the deviation that was taken from them.
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
        """The names of what was fitted."""
        return self.model.free

    @property
    def has_deviations(self) -> bool:
        """Whether the records have them."""
        return self.noise is None

    @property
    def residuals(self) -> Array:
        """Recorded less fitted readings, over their deviations."""
        return np.concatenate([part.ravel() for part in self.left])

    @cached_property
    def serial_p_value(self) -> float:
        """How often residuals are as correlated in time if the model is right.

        The squares of the sums of products of each sensor's residuals with those 1 to `LAGS`
        readings later, over their variances, are a chi^2 of as many degrees (Box and Pierce).
        Variances are those of the products that there are: with the ones of theory 3 in 100 are
        below 0.01 where sensors have 10 readings.
        """
        total = 0.0
        for lag in range(1, LAGS + 1):
            products = np.concatenate([(part[lag:] * part[:-lag]).ravel() for part in self.left])
            total += float(products.sum()) ** 2 / max(float(products @ products), ROUNDED)
        return float(stats.chi2.sf(total, LAGS))

    @property
    def doubts(self) -> list[str]:
        """Reasons, in words, to think that the model is wrong or says little."""
        found = self.doubts_of_size("the scene", "readings")
        if self.serial_p_value < DOUBTFUL:
            found.append(
                "the residuals are correlated in time, as those of a wrong model are: "
                f"p = {self.serial_p_value:.1g}"
            )
        found += [
            f"{name} is not determined: its deviation is larger than itself"
            for name, value, deviation in zip(self.names, self.values, self.deviations, strict=True)
            if deviation > abs(value)
        ]
        found += [f"{name} is at its bound, 0: its interval says little" for name in self.at_bounds]
        smallest = self.noise or min(float(np.min(r.deviations)) for r in self.records)  # type: ignore[arg-type]
        if self.model.scene.target.tolerance > SMALL * smallest:
            found.append(
                f"the scene's tolerance, {self.model.scene.target.tolerance:g}, is not small "
                f"against the deviation of a reading, {smallest:.2g}: take a smaller one"
            )
        return found

    def document(self) -> dict[str, Any]:
        """The tables of a lattice file: the scene's lattice, with its constants and covariance."""
        bare = self.model.scene.symbolic_lattice.with_losses()
        now, held = self.model.at(self.values), [str(symbol) for symbol in bare.constants]
        rows = (dict(zip(self.names, row, strict=True)) for row in self.covariance.tolist())
        covariance = {
            one: {two: row[two] for two in self.names if two in held}
            for one, row in zip(self.names, rows, strict=True)
            if one in held
        }
        constants = {name: now[name] for name in held}
        return {**document_of_lattice(bare), "constants": constants, "covariance": covariance}


def fit_scene(
    scene: str | Path | Scene, records: Sequence[str | Path | SensorRecord], free: Sequence[str]
) -> SceneFit:
    """Fit constants, ``losses.site`` and ``losses.bond`` of a scene to records of its sensors.

    The fit starts from the scene's values. Raises ValueError in one line for what is no such scene
    or record, and names what the records do not tell apart.
    """
    model = SceneModel(scene if isinstance(scene, Scene) else load_scene(scene), free)
    chain, span = model.chain(model.start), (model.scene.t0, model.scene.end)
    read = tuple(
        one if isinstance(one, SensorRecord) else read_record(one, chain.ordered, chain.cells, span)
        for one in records
    )
    known = _check_records(model, read)
    problem = _Problem(model, read)
    found = problem.least(model.start)
    inverse = problem.inverse_square(found.jac)
    noise = 1.0
    if not known:
        inverse, noise = of_residuals(inverse, found.fun, math.ulp(1.0))
    left = tuple(part / noise for part in problem.parts(-found.fun))
    bounds = tuple(name for name, on in zip(model.free, found.active_mask, strict=True) if on)
    given = None if known else noise
    return SceneFit(model, read, found.x, inverse, left, problem.step, given, bounds)


def _check_records(model: SceneModel, records: Sequence[SensorRecord]) -> bool:
    """Whether deviations are known; ValueError for records that say too little."""
    known = {record.deviations is not None for record in records}
    quantities = {sensor.quantity for record in records for sensor in record.sensors}
    if len(known) != 1 or (known == {False} and len(quantities) > 1):
        got = " and ".join(sorted(quantities)) or "no record"
        raise ValueError(
            "deviations must be there in all records or in none, and where several quantities are "
            f"read, got {got} without (add columns such as displacement_0_deviation)"
        )
    count, least = sum(record.values.size for record in records), len(model.free) + SPARE
    if count < least:
        raise ValueError(
            f"readings must be at least {least} for {len(model.free)} constants, got {count} "
            "(record more, or fit fewer)"
        )
    return known == {True}


class _Problem:
    """Least squares of records by one run for all of them."""

    def __init__(self, model: SceneModel, records: Sequence[SensorRecord]) -> None:
        self._model, self._records = model, records
        self._times = np.unique(np.concatenate([record.times for record in records]))
        self._sensors = list(dict.fromkeys(s for record in records for s in record.sensors))
        self._held: tuple[tuple[float, ...], Array] | None = None
        self.step = math.nan

    def least(self, start: Array) -> optimize.OptimizeResult:
        """The fit from there, with a step that is judged where it ends.

        Raises ValueError if it does not come to rest.
        """
        found, self.step = None, math.inf
        while (step := self._model.step(start, self._times)) < AS_LONG * self.step:
            self.step, self._held = step, None
            self.inverse_square(self._of(start)[:, 1:])
            found = optimize.least_squares(
                lambda values: self._of(values)[:, 0],
                start,
                lambda values: self._of(values)[:, 1:],
                bounds=(self._model.least, np.inf),
                x_scale="jac",
                max_nfev=EVALUATIONS,
                xtol=CLOSE,
                ftol=CLOSE,
            )
            start = found.x
        if found is None or not found.success:
            raise ValueError(
                "scene must come to rest at constants of least chi^2, got some that still move "
                f"after {EVALUATIONS} runs (start nearer, or fit fewer)"
            )
        return found

    def inverse_square(self, jacobian: Array) -> Array:
        """The covariance; ValueError for what the records do not tell apart."""
        remedy = "leave {} out, or place more sensors"
        return inverse_square(jacobian, self._model.free, "records", remedy)

    def _of(self, values: Array) -> Array:
        """Residuals and their derivatives."""
        at = tuple(values.tolist())
        if self._held is None or self._held[0] != at:
            read = self._model.readings(values, self._times, self._sensors, self.step)
            self._held = at, np.concatenate([self._apart(read, r) for r in self._records])
        return self._held[1]

    def _apart(self, read: Array, record: SensorRecord) -> Array:
        rows = np.searchsorted(self._times, record.times)
        columns = np.array([self._sensors.index(sensor) for sensor in record.sensors])
        found = read[np.ix_(rows, columns)]
        found[..., 0] -= record.values
        if record.deviations is not None:
            found /= record.deviations[..., np.newaxis]
        return found.reshape(-1, found.shape[-1])

    def parts(self, residuals: Array) -> list[Array]:
        """The residuals of each record, (times, sensors)."""
        sizes = np.cumsum([record.values.size for record in self._records])[:-1]
        pairs = zip(np.split(residuals, sizes), self._records, strict=True)
        return [part.reshape(record.values.shape) for part, record in pairs]
