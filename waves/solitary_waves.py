"""Solitary waves of a chain: approximations by Newton's method, then certificates of existence."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from flint import arb, ctx, fmpq
from numpy.typing import NDArray
from scipy.optimize import brentq

from longwave.waves.certificates import completed, decimal_text, lattice_record
from longwave.waves.continuation import continued
from longwave.waves.force_values import taylor_coefficients
from longwave.waves.kernel.cosine_series import Series, entry, product
from longwave.waves.kernel.limits import CertificateError
from longwave.waves.kernel.periodic import Spring
from longwave.waves.kernel.reading import Record
from longwave.waves.kernel.solitary import SolitaryCentre, nonlinear_springs
from longwave.waves.kernel.solitary_claim import SolitaryClaim
from longwave.waves.periodic_waves import strips
from longwave.waves.springs import Refused

BITS = 160
HALF_LENGTH = 34.0
"""Half-length of the computed interval, in decay lengths of the wave's tail."""

LEAST_MODES, MOST_MODES, GROWTH = 64, 800, 1.4
SIZES = ((0.85, 0.4), (0.85, 0.8), (0.6, 1.0))
"""Sizes to try: the kernel's decay kappa over the wave's, the share of the modes in the block."""

STRIPS = (0.4, 0.2, 0.1)
"""Widths to try of the strip of an analytic force, as powers of the ratio of successive modes."""

MARGIN = "0.01"
"""Distance from the values on the strip within which an analytic force is bounded."""

CHORD_STEPS = 2
PADDING = 1.15
"""Ratio of the modes in the certificate to those found in floating point."""

SMALL_EXCESS = 0.02
"""Excess of the speed over sound at which the continuation in the speed begins."""

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class _Chain:
    """Springs of a chain, in floating point."""

    springs: tuple[Spring, ...]

    def jets(self, terms: int) -> list[tuple[int, Vector]]:
        """Return each neighbour m with the first Taylor coefficients of its force at rest."""
        return [
            (s.neighbour, taylor_coefficients(s.force, np.zeros(1), terms)[:, 0])
            for s in self.springs
        ]

    @property
    def sound_squared(self) -> float:
        """Squared speed of sound."""
        return sum(float(jet[1]) * m * m for m, jet in self.jets(2))

    def symbol(self, speed: float, k: Any) -> Any:
        """Return v^2 - sum K_m T_m^2 at wavenumbers, real or complex."""
        return speed**2 - sum(jet[1] * _box(m, k) ** 2 for m, jet in self.jets(2))

    def decay(self, speed: float) -> float:
        """Return the largest kappa such that Re Delta > 0 at Im k = kappa, the tail's decay rate.

        It is where the symbol has its first zero if no spring pushes.
        """
        line = np.linspace(0, 8, 200)

        def least(kappa: float) -> float:
            return float(self.symbol(speed, line + 1j * kappa).real.min())

        rates = np.geomspace(1e-3, 8, 100)
        last = next((i for i, rate in enumerate(rates) if least(rate) <= 0), 0)
        if not last:
            raise CertificateError("no decay rate of the tail between 0.001 and 8 was found")
        return float(brentq(least, rates[last - 1], rates[last], xtol=1e-14))

    def require_no_resonance(self, speed: float) -> None:
        """Raise Refused if waves of some wavenumber move with this speed."""
        most = 2 * math.sqrt(sum(abs(float(jet[1])) for _, jet in self.jets(2))) / speed
        k = np.linspace(0, most, 4000)
        values = self.symbol(speed, k)
        if values.min() <= 0:
            resonant = k[np.argmax(values <= 0)]
            raise Refused(
                f"speed {speed:g} is resonant with wavenumber {resonant:.4f}; "
                "no solitary wave is proved"
            )


@dataclass(frozen=True)
class _Approximation:
    """Approximate modes of phi = sum T_m N_m(T_m phi)/Delta on (-d, d); T_1 phi is the strain."""

    chain: _Chain
    speed: float
    half_length: float
    modes: Vector

    def stretch(self, m: int) -> Vector:
        """Return the modes of the stretch between m-th neighbours."""
        stretch: Vector = self.modes * _box(m, self._wavenumbers)
        return stretch

    @property
    def _wavenumbers(self) -> Vector:
        count = len(self.modes)
        return np.asarray(np.pi * np.arange(count) / self.half_length, dtype=np.float64)

    def step(self) -> Vector:
        """Return the change of the modes in a step of Newton's method."""
        count = len(self.modes)
        points, order = 2 * count, np.arange(count)
        cosines = np.cos(np.pi * np.outer(np.arange(points) + 0.5, order) / points)
        pull = self.chain.symbol(self.speed, self._wavenumbers)
        residual, jacobian = self.modes.copy(), np.eye(count)
        for spring in nonlinear_springs(self.chain.springs):
            box = _box(spring.neighbour, self._wavenumbers)
            synthesis = cosines * np.where(order, 2, 1) * box
            analysis = cosines.T * (box / pull / points)[:, None]
            strain = synthesis @ self.modes
            values, slopes = taylor_coefficients(spring.force, strain, 2)
            rest = taylor_coefficients(spring.force, np.zeros(1), 2)[:, 0]
            residual -= analysis @ (values - rest[0] - rest[1] * strain)
            jacobian -= analysis @ ((slopes - rest[1])[:, None] * synthesis)
        try:
            return np.asarray(np.linalg.solve(jacobian, -residual), dtype=np.float64)
        except np.linalg.LinAlgError:
            raise CertificateError("Newton's method met a singular problem") from None

    def solved(self) -> _Approximation:
        """Return the approximation after Newton's method. Raises CertificateError."""
        wave, last = self, math.inf
        for _ in range(40):
            change = wave.step()
            wave = replace(wave, modes=wave.modes + change)
            size, step = float(np.abs(wave.modes).max()), float(np.abs(change).max())
            if not math.isfinite(step) or step > 100:
                break
            if step < 1e-15 * size or (step < 1e-10 * size and step >= last):
                if size * self.half_length < 1e-5 * float(np.abs(self.modes).max()):
                    break
                return wave
            last = step
        raise CertificateError("Newton's method did not converge")

    def at_speed(self, speed: float) -> _Approximation:
        """Return the wave rescaled to another ``speed``, as an initial guess at that speed."""
        half_length = HALF_LENGTH / self.chain.decay(speed)
        gaps = [s**2 - self.chain.sound_squared for s in (self.speed, speed)]
        return _Approximation(self.chain, speed, half_length, self.modes * gaps[1] / gaps[0])


def _box(m: int, k: Any) -> Any:
    return m * np.sinc(m * k / (2 * np.pi))


def _small_wave(chain: _Chain, speed: float, count: int) -> _Approximation:
    """Return the soliton of the Gardner equation as approximation, at a speed just above sound.

    It is phi = 1/(q/(3 D) + E cosh(kappa x)), D phi - a phi'' = q phi^2 + p phi^3.
    """
    gap, kappa = speed**2 - chain.sound_squared, chain.decay(speed)
    jets = chain.jets(4)
    quadratic = sum(float(jet[2]) * m**3 for m, jet in jets)
    cubic = sum(float(jet[3]) * m**4 for m, jet in jets)
    square = (quadratic / (3 * gap)) ** 2 + cubic / (2 * gap)
    if not square > 0:
        raise CertificateError(
            "the force needs r^2, or r^3 with a positive factor, to focus a wave"
        )
    half_length, points = HALF_LENGTH / kappa, 2 * count
    x = half_length * (np.arange(points) + 0.5) / points
    shape = math.copysign(math.sqrt(square), quadratic) * np.cosh(kappa * x)
    phi = 1 / (quadratic / (3 * gap) + shape)
    modes = np.cos(np.pi * np.outer(np.arange(count), np.arange(points) + 0.5) / points) @ phi
    return _Approximation(chain, speed, half_length, modes / points)


def _approximate(chain: _Chain, speed: float, count: int) -> _Approximation:
    """Return an approximation at ``speed``, continued from slower waves."""
    sound = math.sqrt(chain.sound_squared)
    excess = speed / sound - 1
    trial = min(excess, SMALL_EXCESS)
    wave = _small_wave(chain, sound * (1 + trial), count).solved()

    def solve(wave: _Approximation, _: float, excess: float) -> _Approximation:
        return wave.at_speed(sound * (1 + excess)).solved()

    wave = continued(wave, solve, start=trial, end=excess, step=trial, least=excess / 500)
    return replace(wave, speed=speed)


def solitary_certificate(springs: Sequence[Spring], speed: fmpq, error: float) -> dict[str, Any]:
    """Return the certificate of a solitary wave whose crest has an error of at most ``error``.

    Raises CertificateError with the inequality that failed, and Refused for a resonant speed.
    """
    with ctx.workprec(BITS):
        return _certificate(_Chain(tuple(springs)), speed, error)


def _certificate(chain: _Chain, speed: fmpq, error: float) -> dict[str, Any]:
    if not nonlinear_springs(chain.springs):
        raise Refused("the force must be nonlinear: a linear chain has no solitary wave")
    if not float(speed) ** 2 > chain.sound_squared > 0:
        raise CertificateError("speed must be above the speed of sound")
    chain.require_no_resonance(float(speed))
    failure = CertificateError("the error is not reached")
    wave = _approximate(chain, float(speed), LEAST_MODES)
    while len(wave.modes) <= MOST_MODES:
        size = np.abs(wave.modes)
        if size[-8:].max() < 1e-14 * size.max():
            try:
                return _proved(_padded(wave, PADDING), speed, error)
            except CertificateError as reason:
                failure = reason
        wave = _padded(wave, GROWTH).solved()
    raise failure


def _padded(wave: _Approximation, factor: float) -> _Approximation:
    """Return the approximation with more modes, the new ones 0."""
    more = math.ceil((factor - 1) * len(wave.modes))
    return replace(wave, modes=np.pad(wave.modes, (0, more)))


def _proved(wave: _Approximation, speed: fmpq, error: float) -> dict[str, Any]:
    """Return a certificate, with the first strip and sizes for which the proof succeeds.

    Raises CertificateError with the last inequality that failed.
    """
    failure = CertificateError("no strip was found on which the force is analytic")
    for strip in strips(wave.chain.springs, wave.stretch(1), STRIPS):
        try:
            draft = _draft(wave, speed, {**strip, "margin": MARGIN} if strip else None)
        except CertificateError as reason:
            failure = reason
            continue
        for decay, share in SIZES:
            sizes = {
                "kappa": f"{decay * HALF_LENGTH / wave.half_length:.6f}",
                "block": math.ceil(share * len(wave.modes)),
            }
            try:
                claim = SolitaryClaim(Record({**draft, **sizes}, "certificate"))
                data = completed({**draft, **sizes}, claim, claim.bounds)
            except CertificateError as reason:
                failure = reason
                continue
            low, high = map(arb, data["claims"]["crest"])
            if float(high - low) <= 2 * error:
                return data
            failure = CertificateError(f"the radius {data['radius']} is too large")
    raise failure


def _draft(wave: _Approximation, speed: fmpq, strip: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return a certificate with refined modes, without a radius that is proved."""
    springs = wave.chain.springs
    data: dict[str, Any] = {
        "kind": "solitary",
        "version": 1,
        "lattice": lattice_record(springs),
        "speed": str(speed),
        "bits": BITS,
        "half_length": f"{wave.half_length:.6f}",
        "kappa": f"{SIZES[0][0] * HALF_LENGTH / wave.half_length:.6f}",
        "block": len(wave.modes),
        "radius_bound": "1e-5",
        "radius": "1e-5",
        "modes": ["0"] * len(wave.modes) * len(nonlinear_springs(springs)),
        **({"strip": strip} if strip else {}),
    }
    modes, slope_modes = _refined(_start(wave, SolitaryClaim(Record(data, "certificate")).centre))
    data["modes"] = [decimal_text(c) for c in modes]
    data["slope_modes"] = [decimal_text(c) for c in slope_modes]
    return data


def _start(wave: _Approximation, centre: SolitaryCentre) -> SolitaryCentre:
    """Return the centre with the forces of an approximation as modes."""
    modes = []
    for spring in centre.nonlinear:
        stretch = [arb(float(c)) for c in wave.stretch(spring.neighbour)]
        values = centre.law(spring, stretch).values
        modes.append([value.mid() for value in values[: len(stretch)]])
    return replace(centre, modes=tuple(modes))


@dataclass(frozen=True)
class _Linear:
    """Problem (1 - P N' T) phi = P r in floating point, P r = sum T_m r_m/Delta."""

    boxes: Sequence[Vector]
    slopes: Sequence[Vector]
    pull: Vector

    @classmethod
    def of(cls, centre: SolitaryCentre) -> _Linear:
        """Return the problem at a centre."""
        order = np.arange(len(centre.modes[0]))
        boxes = np.array([[float(t) for t in centre.boxes(int(n))] for n in order]).T
        slopes = []
        for law in centre.laws:
            w = np.array([float(entry(law.slope, int(n))) for n in range(2 * len(order))])
            added = np.where(order, w[order[:, None] + order], 0)
            slopes.append(w[np.abs(order[:, None] - order)] + added)
        pull = [float(centre.line.symbol(centre.wavenumber(int(n)))) for n in order]
        return cls(list(boxes), slopes, np.array(pull))

    @cached_property
    def inverse(self) -> Vector:
        """Inverse of 1 - P N' T."""
        total = np.eye(len(self.pull))
        for box, slope in zip(self.boxes, self.slopes, strict=True):
            total -= (box / self.pull)[:, None] * slope * box
        return np.asarray(np.linalg.inv(total), dtype=np.float64)

    def corrected(
        self, functions: Sequence[Series], images: Sequence[Series]
    ) -> tuple[Series, ...]:
        """Return functions f_m closer to their ``images``, by f - (1 - N' K)^-1 (f - image)."""
        defects = [
            np.array([float(a - entry(image, n)) for n, a in enumerate(f)])
            for f, image in zip(functions, images, strict=True)
        ]
        parts = [box * defect for box, defect in zip(self.boxes, defects, strict=True)]
        phi = self.inverse @ (np.sum(parts, axis=0) / self.pull)
        result = []
        for f, defect, box, slope in zip(functions, defects, self.boxes, self.slopes, strict=True):
            steps = defect + slope @ (box * phi)
            result.append([(a - arb(float(s))).mid() for a, s in zip(f, steps, strict=True)])
        return tuple(result)


def _refined(centre: SolitaryCentre) -> tuple[list[arb], list[arb]]:
    """Return the modes of g after chord iterations in balls, and those of -dg/dv/(2 v)."""
    linear = _Linear.of(centre)
    for _ in range(CHORD_STEPS):
        potential = centre.potential(centre.modes, 1)
        forces = [
            centre.law(spring, centre.boxed(potential, spring.neighbour)).values
            for spring in centre.nonlinear
        ]
        centre = replace(centre, modes=linear.corrected(centre.modes, forces))
    second = centre.potential(centre.modes, 2)
    change: tuple[Series, ...] = tuple([arb(0)] * len(second) for _ in centre.modes)
    for _ in range(CHORD_STEPS + 1):
        potential = [a + b for a, b in zip(centre.potential(change, 1), second, strict=True)]
        forces = [
            product(law.slope, centre.boxed(potential, spring.neighbour))
            for spring, law in zip(centre.nonlinear, centre.laws, strict=True)
        ]
        change = linear.corrected(change, forces)
    return [c for f in centre.modes for c in f], [c for f in change for c in f]
