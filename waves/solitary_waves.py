"""Solitary waves of a chain: approximations by Newton's method, then certificates of existence."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import acb, arb, arb_mat, ctx, fmpq
from numpy.typing import NDArray
from scipy.optimize import brentq

from longwave.waves.certificates import contracting_radius, decimal_text, interval
from longwave.waves.kernel.cosine_series import polynomial_of
from longwave.waves.kernel.limits import CertificateError
from longwave.waves.kernel.periodic import Spring
from longwave.waves.kernel.reading import Record
from longwave.waves.kernel.solitary import SolitaryCentre, solitary_contraction
from longwave.waves.kernel.solitary_claim import SolitaryClaim

BITS = 160
HALF_LENGTH = 34.0
"""Half-length of the computed interval, in decay lengths of the wave's tail."""

KERNEL_DECAY = 0.85
"""Ratio of the decay rate kappa in the kernel's bound to the decay rate of the wave."""

LEAST_MODES, MOST_MODES, GROWTH = 48, 700, 1.4
TAYLOR_DEGREES = (12, 20, 32)

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class _Approximation:
    """Approximate cosine modes of g = N(f) on (-d, d) for a wave of this speed."""

    spring: Spring
    speed: float
    half_length: float
    modes: Vector

    @property
    def strain(self) -> Vector:
        """Cosine modes of the strain f."""
        return self.modes * _multiplier(self.spring, self.speed, self.half_length, len(self.modes))


def _jet(spring: Spring, r: float, terms: int) -> list[float]:
    return [float(c.real) for c in spring.force.taylor(acb(r), terms)]


def _multiplier(spring: Spring, speed: float, half_length: float, count: int) -> Vector:
    sound = _jet(spring, 0.0, 2)[1]
    square = np.sinc(np.arange(count) / (2 * half_length)) ** 2
    return square / (speed**2 - sound * square)


def decay(speed: float, sound_squared: float) -> float:
    """Return the decay rate k of a solitary wave's tail: c^2 (sinh(k/2)/(k/2))^2 = v^2."""
    ratio = speed / math.sqrt(sound_squared)
    return float(brentq(lambda k: math.sinh(k / 2) / (k / 2) - ratio, 1e-9, 60.0, xtol=1e-14))


def _newton(start: _Approximation) -> _Approximation:
    """Return the approximation after Newton's method. Raises CertificateError."""
    count, spring = len(start.modes), start.spring
    points = 2 * count
    order = np.arange(count)
    angle = np.pi * np.outer(np.arange(points) + 0.5, order) / points
    synthesis = np.cos(angle) * np.where(order, 2, 1)
    analysis = np.cos(angle).T / points
    multiplier = _multiplier(spring, start.speed, start.half_length, count)
    sound = _jet(spring, 0.0, 2)[1]
    modes, last = start.modes.copy(), math.inf
    for _ in range(40):
        strain = synthesis @ (multiplier * modes)
        jets = np.array([_jet(spring, r, 2) for r in strain])
        rest = _jet(spring, 0.0, 1)[0]
        values, slopes = jets[:, 0] - rest - sound * strain, jets[:, 1] - sound
        residual = modes - analysis @ values
        jacobian = np.eye(count) - analysis @ (slopes[:, None] * synthesis) * multiplier
        change = np.linalg.solve(jacobian, -residual)
        modes = modes + change
        step = float(np.abs(change).max())
        if not math.isfinite(step) or step > 100:
            break
        if step < 1e-15 or (step < 1e-11 and step >= last):
            if np.abs(modes).max() < 1e-8:
                break
            return _Approximation(spring, start.speed, start.half_length, modes)
        last = step
    raise CertificateError("Newton's method did not converge")


def _small_wave(spring: Spring, speed: float, count: int) -> _Approximation:
    """Return the reduced equation's soliton as approximation, at a speed just above sound."""
    _, sound, quadratic, cubic = _jet(spring, 0.0, 4)
    gap, kappa = speed**2 - sound, decay(speed, sound)
    half_length = HALF_LENGTH / kappa
    points = 2 * count
    x = half_length * (np.arange(points) + 0.5) / points
    if abs(quadratic) > 1e-12:
        strain = 1.5 * gap / quadratic / np.cosh(kappa * x / 2) ** 2
    elif cubic > 0:
        strain = math.sqrt(2 * gap / cubic) / np.cosh(kappa * x)
    else:
        raise CertificateError(
            "the force needs r^2, or r^3 with a positive factor, to focus a wave"
        )
    jets = np.array([_jet(spring, r, 1)[0] for r in strain])
    values = jets - _jet(spring, 0.0, 1)[0] - sound * strain
    modes = np.cos(np.pi * np.outer(np.arange(count), np.arange(points) + 0.5) / points) @ values
    return _Approximation(spring, speed, half_length, modes / points)


def _approximate(spring: Spring, speed: float, count: int) -> _Approximation:
    """Return an approximation at ``speed``, continued from slower waves."""
    sound = math.sqrt(_jet(spring, 0.0, 2)[1])
    excess = speed / sound - 1
    trial = min(excess, 0.03)
    wave = _newton(_small_wave(spring, sound * (1 + trial), count))
    step = trial
    while trial < excess:
        forward = min(trial + step, excess)
        guess = _moved(wave, sound * (1 + forward), sound)
        try:
            wave = _newton(guess)
        except CertificateError:
            step /= 2
            if step < excess / 500:
                raise
        else:
            trial, step = forward, 1.5 * step
    return wave


def _moved(wave: _Approximation, speed: float, sound: float) -> _Approximation:
    """Return the wave rescaled to another ``speed``, as an initial guess at that speed."""
    half_length = HALF_LENGTH / decay(speed, sound**2)
    gaps = [s**2 - sound**2 for s in (wave.speed, speed)]
    factor = gaps[1] / gaps[0] * (half_length / wave.half_length) ** 0
    return _Approximation(wave.spring, speed, half_length, wave.modes * factor)


def solitary_certificate(spring: Spring, speed: fmpq, error: float) -> dict[str, Any]:
    """Return the certificate of a solitary wave whose strain has an error of at most ``error``.

    Raises CertificateError with the inequality that failed, and ValueError if no approximation
    was found.
    """
    before, ctx.prec = ctx.prec, BITS
    try:
        return _certificate(spring, speed, error)
    finally:
        ctx.prec = before


def _certificate(spring: Spring, speed: fmpq, error: float) -> dict[str, Any]:
    if not float(speed) ** 2 > _jet(spring, 0.0, 2)[1] > 0:
        raise CertificateError("speed must be above the speed of sound")
    count = LEAST_MODES
    failure = CertificateError("the error is not reached")
    wave = _approximate(spring, float(speed), count)
    while count <= MOST_MODES:
        size = np.abs(wave.modes)
        if size[-8:].max() < 1e-14 * size.max():
            for degree in TAYLOR_DEGREES:
                try:
                    data = _prove(wave, speed, degree)
                except CertificateError as reason:
                    failure = reason
                else:
                    low, high = map(arb, data["claims"]["crest"])
                    if float(high - low) <= 2 * error:
                        return data
                    failure = CertificateError(f"the radius {data['radius']} is too large")
                if spring.force.polynomial is not None:
                    break
        count = math.ceil(GROWTH * count)
        padded = np.pad(wave.modes, (0, count - len(wave.modes)))
        wave = _newton(_Approximation(spring, wave.speed, wave.half_length, padded))
    raise failure


def _prove(wave: _Approximation, speed: fmpq, degree: int) -> dict[str, Any]:
    kappa_wave = HALF_LENGTH / wave.half_length
    strain_size = np.abs(wave.strain[0]) + 2 * np.abs(wave.strain[1:]).sum()
    data: dict[str, Any] = {
        "kind": "solitary",
        "version": 1,
        "lattice": {"springs": [{"neighbour": 1, "force": wave.spring.force.text}]},
        "speed": str(speed),
        "bits": BITS,
        "half_length": f"{wave.half_length:.6f}",
        "kappa": f"{KERNEL_DECAY * kappa_wave:.6f}",
        "degree": degree,
        "range_bound": f"{1.02 * strain_size + 1e-3:.6g}",
        "radius_bound": "1e-5",
        "radius": "1e-5",
        "modes": [repr(float(c)) for c in wave.modes],
    }
    data["modes"] = _refined(data)
    claim = SolitaryClaim(Record(data, "certificate"))
    bounds = solitary_contraction(claim.centre)
    data["radius"] = contracting_radius(bounds)
    claim = SolitaryClaim(Record(data, "certificate"))
    data["claims"] = {name: interval(value) for name, value in claim.prove().items()}
    return data


def _refined(data: dict[str, Any]) -> list[str]:
    """Return the modes after chord iterations in ball arithmetic."""
    centre = SolitaryClaim(Record(data, "certificate")).centre
    inverse = arb_mat(_float_inverse(centre))
    modes = centre.modes
    for _ in range(4):
        moved = SolitaryCentre(**{**_fields(centre), "modes": modes})
        values = polynomial_of(moved.nonlinear, moved.strain)
        count = len(modes)
        residual = arb_mat(count, 1, [(modes[n] - values[n]).mid() for n in range(count)])
        step = inverse * residual
        modes = [(modes[n] - step[n, 0]).mid() for n in range(count)]
        if max(abs(float(step[n, 0])) for n in range(count)) < 1e-30:
            break
    return [decimal_text(c) for c in modes]


def _fields(centre: SolitaryCentre) -> dict[str, Any]:
    return {name: getattr(centre, name) for name in centre.__dataclass_fields__}


def _float_inverse(centre: SolitaryCentre) -> list[list[float]]:
    slope = polynomial_of([i * c for i, c in enumerate(centre.nonlinear)][1:], centre.strain)
    w = np.array([float(c) for c in slope])
    w = np.pad(w, (0, max(0, 2 * centre.top + 1 - len(w))))
    order = np.arange(centre.top + 1)
    multiplier = np.array([float(centre.multiplier(int(n))) for n in order])
    product = w[np.abs(order[:, None] - order)] + np.where(order, 1, 0) * w[order[:, None] + order]
    inverse: list[list[float]] = np.linalg.inv(np.eye(len(order)) - product * multiplier).tolist()
    return inverse
