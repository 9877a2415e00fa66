"""Periodic waves of a chain: approximations by Newton's method, then certificates of existence."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import acb, arb, arb_mat, ctx, fmpq
from numpy.typing import NDArray

from longwave.waves.certificates import completed, decimal_text, lattice_record
from longwave.waves.continuation import continued
from longwave.waves.force_values import taylor_coefficients
from longwave.waves.kernel.elliptic_pins import NearWave
from longwave.waves.kernel.limits import CertificateError, decimal
from longwave.waves.kernel.periodic import PeriodicCentre, Spring, contraction
from longwave.waves.kernel.periodic_claim import PeriodicClaim
from longwave.waves.kernel.reading import Record

BITS = 128
WEIGHT = fmpq(1, 10)
PIN_DIGITS = 30
"""Digits of the mean and the first mode of a wave of an elliptic form and a given period."""

MODES_PER_CELL, LEAST_MODES, MOST_MODES = 1.6, 12, 700
GROWTH = 1.5
"""Factor by which the number of modes grows until the error is small enough."""

NEWTON_STEPS = 40

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class PeriodicProblem:
    """Springs, period, mean and first mode of a wave to find, perhaps those of an elliptic wave."""

    springs: tuple[Spring, ...]
    period: arb
    mean: arb
    first_mode: arb
    statement: Mapping[str, Any]
    near: NearWave | None = None

    @classmethod
    def of(
        cls, springs: tuple[Spring, ...], period: fmpq, mean: fmpq, first_mode: fmpq
    ) -> PeriodicProblem:
        """Return the problem with exact period, mean and first mode."""
        statement = {"period": str(period), "mean": str(mean), "first_mode": str(first_mode)}
        return cls(springs, arb(period), arb(mean), arb(first_mode), statement)

    @classmethod
    def near_elliptic(
        cls, springs: tuple[Spring, ...], form: str, k: fmpq, eps: fmpq
    ) -> PeriodicProblem:
        """Return the problem with period, mean and first mode of an elliptic mKdV wave."""
        near = NearWave(form, k, eps, springs[0].force)
        statement = {"near": {"form": form, "k": str(k), "eps": str(eps)}}
        return cls(springs, near.period, near.mode(0), near.mode(1), statement, near)

    @classmethod
    def of_period(
        cls, springs: tuple[Spring, ...], form: str, k: fmpq, period: fmpq
    ) -> PeriodicProblem:
        """Return the problem of a period, with the elliptic wave's mean and first mode, rounded."""
        with ctx.workprec(BITS):
            unit = NearWave(form, k, fmpq(1), springs[0].force)
            size = (unit.period / period) ** unit.form.order
            mean, first_mode = (
                decimal(str((unit.mode(j) * size).mid().str(PIN_DIGITS, radius=False)))
                for j in (0, 1)
            )
            return cls.of(springs, period, mean, first_mode)


@dataclass(frozen=True)
class _Galerkin:
    """The wave's first N equations in floating point, by collocation at 4 N points."""

    problem: PeriodicProblem
    top: int

    def solve(self, modes: Vector, speed_squared: float) -> tuple[Vector, float]:
        """Return modes and squared speed after Newton's method. Raises CertificateError."""
        modes = modes.copy()
        step = math.inf
        for _ in range(NEWTON_STEPS):
            values, slopes = self._forces(modes)
            residual = speed_squared * modes[1:] - values
            jacobian = speed_squared * np.eye(self.top) - slopes
            jacobian[:, 0] = modes[1:]
            try:
                change = np.linalg.solve(jacobian, -residual)
            except np.linalg.LinAlgError:
                break
            last, step = step, float(np.abs(change).max())
            speed_squared += change[0]
            modes[2:] += change[1:]
            if not math.isfinite(step) or step > 10:
                break
            if step < 1e-15 or (step < 1e-11 and step >= last):
                return modes, speed_squared
        raise CertificateError("Newton's method did not converge")

    def _forces(self, modes: Vector) -> tuple[Vector, Vector]:
        """Return mu_j sum_m S_mj [V_m'(S_m f)]_j and its derivatives by f_k, j and k = 1 ... N."""
        count, order = 4 * self.top, np.arange(self.top + 1)
        half = np.pi * order / float(self.problem.period)
        mobility = np.sinc(half / np.pi) ** 2
        cosines = np.cos(2 * np.pi * np.outer(np.arange(count), order) / count)
        total, slopes = np.zeros(self.top), np.zeros((self.top, self.top))
        for spring in self.problem.springs:
            m = spring.neighbour
            factor = sum(np.cos(half * (2 * i + 1 - m)) for i in range(m))
            synthesis = cosines * np.where(order, 2, 1) * factor
            values, rates = taylor_coefficients(spring.force, synthesis @ modes, 2)
            analysis = (cosines * mobility * factor / count)[:, 1:].T
            total += analysis @ values
            slopes += analysis @ (rates[:, None] * synthesis[:, 1:])
        return total, slopes


def periodic_certificate(problem: PeriodicProblem, error: float) -> dict[str, Any]:
    """Return the certificate of a wave with a radius of at most ``error``.

    Raises CertificateError with the inequality that failed, and ValueError if no approximation
    was found.
    """
    with ctx.workprec(BITS):
        return _certificate(problem, error)


def _certificate(problem: PeriodicProblem, error: float) -> dict[str, Any]:
    top = max(LEAST_MODES, math.ceil(MODES_PER_CELL * float(problem.period)))
    modes, speed_squared = _start(problem, top)
    failure = CertificateError("the error is not reached")
    while top <= MOST_MODES:
        padded = np.pad(modes, (0, top + 1 - len(modes)))
        modes, speed_squared = _Galerkin(problem, top).solve(padded, speed_squared)
        for strip in strips(problem.springs, modes):
            try:
                proof = _prove(problem, modes, speed_squared, strip)
            except CertificateError as reason:
                failure = reason
                continue
            if float(arb(proof["radius"])) <= error:
                return proof
            failure = CertificateError(f"the radius {proof['radius']} is above {error:g}")
            break
        top = math.ceil(GROWTH * top)
    raise failure


def _start(problem: PeriodicProblem, top: int) -> tuple[Vector, float]:
    """Return N = ``top`` modes and v^2, from the elliptic wave or continued from a small wave."""
    if problem.near:
        modes = np.array([float(problem.near.mode(j)) for j in range(top + 1)])
        return _Galerkin(problem, top).solve(modes, float(_sound(problem)))
    target = float(problem.first_mode)
    modes = np.zeros(top + 1)
    modes[0] = float(problem.mean)

    def solve(state: tuple[Vector, float], before: float, share: float) -> tuple[Vector, float]:
        trial = state[0].copy()
        trial[1:] *= share / before if before else 1
        trial[1] = target * share
        return _Galerkin(problem, top).solve(trial, state[1])

    start = modes, float(_sound(problem))
    return continued(start, solve, start=0.0, end=1.0, step=1.0, least=1 / 256, growth=2)


def _sound(problem: PeriodicProblem) -> arb:
    """Return the squared speed of small waves with this period."""
    half = arb.pi() / problem.period
    total = arb(0)
    for spring in problem.springs:
        m = spring.neighbour
        ratio = (m * half).sin() / half
        total += ratio * ratio * spring.force.taylor(acb(m * problem.mean), 2)[1].real
    return total


def strips(
    springs: Iterable[Spring], modes: Vector, powers: Iterable[float] = (0.6, 0.4, 0.25)
) -> Iterator[Mapping[str, Any] | None]:
    """Yield strips to try for analytic forces; None for polynomials.

    Their widths are the ``powers`` of the ratio of one mode to the next.
    """
    if all(spring.force.polynomial is not None for spring in springs):
        yield None
        return
    sizes = np.abs(modes)
    visible = np.nonzero(sizes > 1e-13 * sizes[1])[0]
    last = int(visible[-1])
    decay = (sizes[last] / sizes[1]) ** (1 / max(last - 1, 1)) if last > 1 else 0.1
    for power in powers:
        rho = min(max(decay**-power, 1.02), 8.0)
        count = 2 ** math.ceil(math.log2(max(8 * len(modes) / 2, 100 / math.log(rho))))
        size = max(np.abs(modes[0]) + 2 * sizes[1:].sum(), 1e-3)
        margin = f"{min(size, 0.2):.3g}"
        yield {"rho": f"{rho:.4g}", "margin": margin, "samples": count}


def _prove(
    problem: PeriodicProblem, modes: Vector, speed_squared: float, strip: Mapping[str, Any] | None
) -> dict[str, Any]:
    """Refine an approximation, find a radius that contracts, and return the certificate."""
    data = {
        "kind": "periodic",
        "version": 1,
        "lattice": lattice_record(problem.springs),
        **problem.statement,
        "bits": BITS,
        "nu": "1",
        "weight": str(WEIGHT),
        "radius_bound": "1e-6",
        "radius": "1e-6",
        "modes": [repr(float(c)) for c in modes[2:]],
        "speed_squared": repr(float(speed_squared)),
        **({"strip": dict(strip)} if strip else {}),
    }
    data = _refined(data)
    claim = PeriodicClaim(Record(data, "certificate"))
    return completed(data, claim, contraction(claim.centre))


def _refined(data: dict[str, Any]) -> dict[str, Any]:
    """Return the certificate's numbers after chord iterations in ball arithmetic."""
    inverse: arb_mat | None = None
    for _ in range(4):
        centre = PeriodicClaim(Record(data, "certificate")).centre
        if inverse is None:
            inverse = arb_mat(_float_inverse(centre))
        residual = arb_mat(
            centre.top, 1, [centre.residual(j).mid() for j in range(1, centre.top + 1)]
        )
        step = inverse * residual
        modes = [decimal_text(c - step[k + 1, 0]) for k, c in enumerate(centre.modes[2:])]
        data = {
            **data,
            "modes": modes,
            "speed_squared": decimal_text(centre.speed_squared - step[0, 0]),
        }
        if max(abs(float(step[k, 0])) for k in range(centre.top)) < 1e-30:
            break
    return data


def _float_inverse(centre: PeriodicCentre) -> list[list[float]]:
    top = centre.top
    rows = range(1, top + 1)
    matrix = np.array([[-float(centre.coupling(j, k)) for k in rows] for j in rows])
    matrix += float(centre.speed_squared) * np.eye(top)
    matrix[:, 0] = [float(c) for c in centre.modes[1:]]
    inverse: list[list[float]] = np.linalg.inv(matrix).tolist()
    return inverse
