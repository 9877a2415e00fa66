"""Time-periodic orbits of a chain: approximations by Newton's method, then certificates."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from flint import arb, arb_mat, ctx, fmpq
from numpy.typing import NDArray

from longwave.waves.certificates import (
    contracting_radius,
    decimal_text,
    intervals,
    lattice_record,
)
from longwave.waves.continuation import continued
from longwave.waves.force_values import taylor_coefficients
from longwave.waves.kernel.force_text import Force
from longwave.waves.kernel.limits import CertificateError
from longwave.waves.kernel.orbit import energy_at_start
from longwave.waves.kernel.orbit_claim import BreatherClaim, OrbitClaim
from longwave.waves.kernel.periodic import Spring
from longwave.waves.kernel.reading import Record
from longwave.waves.periodic_waves import strips
from longwave.waves.springs import Refused

BITS = 128
NU = ("7/5", "6/5", "21/20")
"""Weights nu to try: the energy's equation needs nu > 1, slow decay of the modes a small nu."""

SMALLEST_IN_BLOCK = (1e-3, 1e-5, 1e-7)
"""Sizes, relative to the largest mode, down to which modes are in the block."""

FASTEST = 1.6
"""Least frequency of an orbit's block, relative to the largest of the linear modes."""

SMALLEST = (1e-25, 1e-20, 1e-15, 1e-12, 1e-32)
"""Sizes, relative to the largest mode, to try as that below which modes are left out."""

NEWTON_STEPS = 30
STEPS, ORDER = 32, 44
"""Taylor steps over half a period, and their order, for the multipliers."""

Vector = NDArray[np.float64]


def _is_odd(springs: Sequence[Spring]) -> bool:
    return all(spring.force.is_odd for spring in springs)


@dataclass(frozen=True)
class _Galerkin:
    """The equations of the harmonics up to ``top`` in floating point, by collocation.

    The modes are an array (sites, harmonics); q_n = a_n0 + 2 (a_n1 cos + ...). ``coupling``
    multiplies the forces between sites.
    """

    springs: tuple[Spring, ...]
    sites: int
    top: int
    coupling: float = 1.0

    @cached_property
    def harmonics(self) -> NDArray[np.int64]:
        """Harmonics that occur; only odd ones if all forces are odd."""
        return np.arange(1, self.top + 1, 2) if _is_odd(self.springs) else np.arange(self.top + 1)

    @cached_property
    def bonds(self) -> tuple[list[tuple[Force, float]], Vector]:
        """Force and factor of each bond, and the matrix of stretches; q = 0 beyond the ends."""
        forces, rows = [], []
        for spring in self.springs:
            m = spring.neighbour
            for n in range(-m, self.sites):
                row = np.zeros(self.sites)
                for site, sign in ((n + m, 1), (n, -1 if m else 0)):
                    if 0 <= site < self.sites:
                        row[site] += sign
                forces.append((spring.force, self.coupling if m else 1.0))
                rows.append(row)
        return forces, np.array(rows)

    @cached_property
    def cosines(self) -> Vector:
        """Cosines at the collocation points of half a period, by point and harmonic."""
        points = 2 * self.top + 8
        return np.cos(np.pi * np.outer(np.arange(points) + 0.5, self.harmonics) / points)

    @cached_property
    def factors(self) -> Vector:
        """Factor of each harmonic's cosine: 1 for the mean, else 2."""
        return np.where(self.harmonics, 2.0, 1.0)

    @property
    def fastest(self) -> float:
        """Largest frequency of small oscillations."""
        return math.sqrt(max(float(self.rest_frequencies()[0][-1]), 0.0))

    def rest_frequencies(self) -> tuple[Vector, Vector]:
        """Return the squared frequencies of small oscillations, ascending, and their shapes."""
        forces, stretches = self.bonds
        slopes = np.array([factor * float(f.at_rest[1]) for f, factor in forces])
        squares, shapes = np.linalg.eigh(stretches.T @ (slopes[:, None] * stretches))
        return squares, shapes.T

    def energy(self, modes: Vector) -> tuple[float, Vector]:
        """Return the energy at t = 0 and the slope of each site."""
        forces, stretches = self.bonds
        starts = stretches @ (modes @ self.factors)
        nodes, weights = np.polynomial.legendre.leggauss(24)
        total, pulls = 0.0, np.zeros(len(starts))
        for i, ((force, factor), start) in enumerate(zip(forces, starts, strict=True)):
            (values,) = taylor_coefficients(force, start * (nodes + 1) / 2, 1)
            total += factor * float(weights @ values) * start / 2
            pulls[i] = factor * taylor_coefficients(force, np.array([start]), 1)[0, 0]
        return total, stretches.T @ pulls

    def solve(
        self, modes: Vector, square: float, energy: float | None = None
    ) -> tuple[Vector, float]:
        """Return modes and squared frequency after Newton's method. Raises CertificateError.

        Without ``energy`` the frequency is fixed.
        """
        modes, last = modes.copy(), math.inf
        for _ in range(NEWTON_STEPS):
            residual, jacobian = self._equations(modes, square)
            if energy is not None:
                value, jacobian = self._with_energy(modes, jacobian)
                residual = np.array([value - energy, *residual])
            try:
                change = np.linalg.solve(jacobian, -residual)
            except np.linalg.LinAlgError:
                break
            if energy is not None:
                square += change[0]
            modes += change[-modes.size :].reshape(modes.shape)
            step = float(np.abs(change).max())
            if not math.isfinite(step) or step > 1e3 or not square > 0:
                break
            if step < 1e-15 or (step < 1e-10 and step >= last):
                return modes, square
            last = step
        raise CertificateError("Newton's method did not converge")

    def inverse(self, modes: Vector, square: float, pinned: bool) -> Vector:
        """Return the inverse of the equations' matrix, with the energy's if it is ``pinned``."""
        _, jacobian = self._equations(modes, square)
        matrix = self._with_energy(modes, jacobian)[1] if pinned else jacobian
        return np.asarray(np.linalg.inv(matrix), dtype=np.float64)

    def _with_energy(self, modes: Vector, jacobian: Vector) -> tuple[float, Vector]:
        """Return the energy, and the matrix with its equation and the unknown Omega^2 in front."""
        value, slopes = self.energy(modes)
        speeds = (self.harmonics**2 * modes).ravel()
        row = np.outer(slopes, self.factors).ravel()
        return value, np.block([[np.zeros((1, 1)), row[None]], [speeds[:, None], jacobian]])

    def _equations(self, modes: Vector, square: float) -> tuple[Vector, Vector]:
        """Return k^2 Omega^2 a_nk - [G_n]_k and its derivatives by the modes, flattened."""
        forces, stretches = self.bonds
        synthesis, analysis = self.cosines * self.factors, self.cosines.T / len(self.cosines)
        points = stretches @ modes @ synthesis.T
        count, width = modes.shape
        pulls = np.zeros_like(modes)
        slopes = np.zeros((count, width, count, width))
        for (force, factor), row, values in zip(forces, stretches, points, strict=True):
            force_values, force_slopes = taylor_coefficients(force, values, 2)
            ends = np.nonzero(row)[0]
            pulls[ends] += np.outer(row[ends], factor * (analysis @ force_values))
            matrix = factor * (analysis @ (force_slopes[:, None] * synthesis))
            for n in ends:
                for m in ends:
                    slopes[n, :, m, :] += row[n] * row[m] * matrix
        squares = square * self.harmonics.astype(float) ** 2
        jacobian = np.diag(np.tile(squares, count)) - slopes.reshape(modes.size, modes.size)
        return (squares * modes - pulls).ravel(), jacobian


def orbit_certificate(
    springs: tuple[Spring, ...], sites: int, mode: int, energy: fmpq, error: float
) -> dict[str, Any]:
    """Return the certificate of the orbit of a finite chain that continues a linear mode.

    Its modes have an error of at most ``error``. The multipliers are left out where they are not
    proved. Raises CertificateError with the inequality that failed.
    """
    with ctx.workprec(BITS):
        system = _Galerkin(springs, sites, FIRST_TOP)
        modes, square = _continued_in_energy(system, mode, float(energy))
        return _certificate(_Target("orbit", energy), system, modes, square, error)


def breather_certificate(
    springs: tuple[Spring, ...], frequency: fmpq, error: float
) -> dict[str, Any]:
    """Return the certificate of a breather of an infinite chain, about one site.

    Its modes have an error of at most ``error``. Raises Refused for a resonant frequency, and
    CertificateError with the inequality that failed.
    """
    _refuse_resonance(springs, float(frequency))
    with ctx.workprec(BITS):
        square = float(frequency) ** 2
        system = _Galerkin(springs, 2 * FIRST_SITES + 1, FIRST_TOP)
        modes = _continued_in_coupling(system, square)
        return _certificate(_Target("breather", frequency), system, modes, square, error)


def _refuse_resonance(springs: tuple[Spring, ...], frequency: float) -> None:
    """Raise Refused if a harmonic that occurs is a frequency of the chain's linear waves."""
    slopes = [(s.neighbour, float(s.force.at_rest[1])) for s in springs]
    middle = sum(slope * (2 if m else 1) for m, slope in slopes)
    half_width = sum(2 * abs(slope) for m, slope in slopes if m)
    top = math.ceil(math.sqrt(max(middle + half_width, 0.0)) / frequency)
    for k in range(top + 1):
        if abs(k * k * frequency**2 - middle) <= half_width and (k % 2 or not _is_odd(springs)):
            low, high = middle - half_width, middle + half_width
            raise Refused(
                f"harmonic {k} of the frequency {frequency:g} is resonant with the chain's linear "
                f"waves, {low:.6g} <= omega^2 <= {high:.6g}; no breather is proved"
            )


FIRST_TOP, FIRST_SITES = 17, 5
MOST_UNKNOWNS = 1400
LARGEST_CHANGE = 0.2
"""Largest relative change of the first harmonic in a step of the continuation in energy."""

LEAST_STEP = 1 / 512
"""Least step of a continuation in the amplitude or the coupling, over its range."""

FIRST_ENERGY = 1 / 64
"""Fraction of the energy at which the continuation of a linear mode begins."""


def _continued_in_energy(system: _Galerkin, mode: int, energy: float) -> tuple[Vector, float]:
    """Return modes and squared frequency at an energy, continued from a linear mode."""
    squares, shapes = system.rest_frequencies()
    square, shape = float(squares[mode - 1]), shapes[mode - 1]
    if not square > 1e-12:
        raise CertificateError("the linear mode does not oscillate")
    modes = np.zeros((system.sites, len(system.harmonics)))
    place = int(np.nonzero(system.harmonics == 1)[0][0])
    step = math.sqrt(FIRST_ENERGY)
    modes[:, place] = shape * step * math.sqrt(2 * energy / square) / 2

    def solve(state: tuple[Vector, float], before: float, aim: float) -> tuple[Vector, float]:
        guess = state[0] * (aim / (before or step))
        return _near_guess(system, guess, state[1], aim * aim * energy)

    return continued((modes, square), solve, start=0.0, end=1.0, step=step, least=LEAST_STEP)


def _near_guess(
    system: _Galerkin, guess: Vector, square: float, energy: float
) -> tuple[Vector, float]:
    """Return modes and squared frequency. Raises CertificateError if they leave the branch."""
    modes, square = system.solve(guess, square, energy)
    first = int(np.nonzero(system.harmonics == 1)[0][0])
    change = np.linalg.norm(modes[:, first] - guess[:, first])
    if change > LARGEST_CHANGE * np.linalg.norm(guess[:, first]):
        raise CertificateError("the orbit is not continued to this energy (take a smaller one)")
    return modes, square


def _continued_in_coupling(system: _Galerkin, square: float) -> Vector:
    """Return the modes of a breather, continued from the oscillation of a site alone."""
    middle = system.sites // 2
    modes = np.zeros((system.sites, len(system.harmonics)))
    modes[middle] = _oscillation(system, square)[0]

    def solve(modes: Vector, _: float, aim: float) -> Vector:
        return replace(system, coupling=aim).solve(modes, square)[0]

    return continued(modes, solve, start=0.0, end=1.0, step=0.25, least=LEAST_STEP)


def _oscillation(system: _Galerkin, square: float) -> Vector:
    """Return the modes of one site alone that oscillates at a squared frequency."""
    own = tuple(spring for spring in system.springs if spring.neighbour == 0)
    site = _Galerkin(own, 1, system.top)
    energy, (modes, reached) = 1e-3, _continued_in_energy(site, 1, 1e-3)
    sign = reached - square
    while (reached - square) * sign > 0:
        energy *= 1.4
        if energy > 1e6:
            raise CertificateError("no oscillation of one site has this frequency")
        modes, reached = site.solve(1.15 * modes, reached, energy)
    return site.solve(modes, square)[0]


@dataclass(frozen=True)
class _Target:
    """Kind of the certificate, and the energy of the orbit or the frequency of the breather."""

    kind: str
    value: fmpq

    @property
    def statement(self) -> dict[str, str]:
        """Keys of the certificate that state the target."""
        return {("energy" if self.kind == "orbit" else "frequency"): str(self.value)}

    def claim(self, data: Mapping[str, Any]) -> OrbitClaim | BreatherClaim:
        """Return the statement of a certificate."""
        kind = OrbitClaim if self.kind == "orbit" else BreatherClaim
        return kind(Record(dict(data), "certificate"))


def _certificate(
    target: _Target, system: _Galerkin, modes: Vector, square: float, error: float
) -> dict[str, Any]:
    failure = CertificateError(f"more than {MOST_UNKNOWNS} modes are needed")
    for smallest in SMALLEST:
        top, margin = _sizes(target, system, modes, smallest)
        larger = replace(system, top=top, sites=system.sites + 2 * margin)
        if larger.sites * len(larger.harmonics) > MOST_UNKNOWNS:
            continue
        energy = float(target.value) if target.kind == "orbit" else None
        modes, square = larger.solve(_padded(system, larger, modes), square, energy)
        system = larger
        try:
            data = _prove(target, system, modes, square)
        except CertificateError as reason:
            failure = reason
            continue
        if float(data["radius"]) <= error:
            return data
        failure = CertificateError(f"the radius {data['radius']} is above {error:g}")
    raise failure


def _sizes(target: _Target, system: _Galerkin, modes: Vector, smallest: float) -> tuple[int, int]:
    """Return the harmonics needed for modes down to ``smallest``, and sites to add at each end."""
    sizes, moving = np.abs(modes), system.harmonics[system.harmonics > 0]
    stride = int(moving[1] - moving[0])
    top = 1 + stride * (_reach(sizes[:, -len(moving) :].max(axis=0), smallest) - 1)
    if target.kind == "orbit":
        return max(top, system.top), 0
    middle = system.sites // 2
    margin = _reach(sizes[middle:].max(axis=1), smallest) - 1 - middle
    return max(top, system.top), max(margin, 0)


def _reach(sizes: Vector, smallest: float) -> int:
    """Return how many of a sequence of decaying sizes exceed ``smallest`` times the largest.

    The sequence is continued beyond its end, to three times its length at most.
    """
    relative = sizes / sizes.max()
    last = max(int(np.nonzero(relative > 1e-13)[0][-1]), 1)
    decay = math.log(max(relative[last], 1e-16)) / last
    if decay >= 0:
        return 3 * len(sizes)
    return min(math.ceil(math.log(smallest) / decay) + 1, 3 * len(sizes))


def _padded(system: _Galerkin, larger: _Galerkin, modes: Vector) -> Vector:
    """Return the modes as an array of a ``larger`` system, with the same middle site."""
    margin = (larger.sites - system.sites) // 2
    more = len(larger.harmonics) - len(system.harmonics)
    return np.pad(modes, ((margin, margin), (0, more)))


def _prove(target: _Target, system: _Galerkin, modes: Vector, square: float) -> dict[str, Any]:
    """Refine an approximation, find a radius that contracts, and return the certificate."""
    data: dict[str, Any] = {
        "kind": target.kind,
        "version": 1,
        "bits": BITS,
        "lattice": lattice_record(system.springs),
        **target.statement,
        "nu": "1",
        "weight": "1",
        "radius_bound": "1e-6",
        "radius": "1e-6",
        "modes": [[repr(float(c)) for c in site] for site in modes],
    }
    if target.kind == "orbit":
        data["frequency_squared"] = repr(float(square))
    failure = CertificateError("no strip was tried")
    for strip in _strips(system, modes):
        try:
            trial = _refined(target, system, modes, square, {**data, **strip})
            return _with_claims(
                *_contracted(target, trial, _choices(target, system, modes, square))
            )
        except CertificateError as reason:
            failure = reason
    raise failure


def _with_claims(data: dict[str, Any], claim: OrbitClaim | BreatherClaim) -> dict[str, Any]:
    """Return the certificate with what it proves, with the multipliers if they are proved."""
    numbers = claim.prove()
    if isinstance(claim, OrbitClaim):
        more = {**data, "multipliers": {"steps": STEPS, "order": ORDER}}
        claim.monodromy = OrbitClaim(Record(more, "certificate")).monodromy
        try:
            numbers = claim.prove()
        except CertificateError:
            pass
        else:
            data = more
    return {**data, "claims": intervals(numbers)}


def _contracted(
    target: _Target, data: dict[str, Any], choices: Iterable[dict[str, Any]]
) -> tuple[dict[str, Any], OrbitClaim | BreatherClaim]:
    """Return a certificate with the first of ``choices`` that gives a radius, and its claim."""
    failure = CertificateError("no proof was tried")
    for choice in choices:
        claim = target.claim({**data, **choice})
        try:
            radius = contracting_radius(claim.contraction)
        except CertificateError as reason:
            failure = reason
            continue
        claim.radius = arb(radius)
        return {**data, **choice, "radius": radius}, claim
    raise failure


def _choices(
    target: _Target, system: _Galerkin, modes: Vector, square: float
) -> list[dict[str, Any]]:
    """Return blocks to try, small ones first, and weights nu for an orbit."""
    choices = []
    sizes = np.abs(modes) / np.abs(modes).max()
    for smallest in SMALLEST_IN_BLOCK:
        sites, harmonics = (np.nonzero(sizes.max(axis=i) > smallest)[0] for i in (1, 0))
        top = int(system.harmonics[harmonics[-1]])
        if target.kind == "orbit":
            top = max(top, math.ceil(FASTEST * system.fastest / math.sqrt(square)))
            choices += [{"block": {"margin": 0, "top": top}, "nu": nu} for nu in NU]
        else:
            choices.append({"block": {"margin": int(sites[0]), "top": top}})
    return choices


def _strips(system: _Galerkin, modes: Vector) -> Iterator[dict[str, Any]]:
    """Yield strips to try for analytic forces; nothing else for polynomials."""
    bound = np.zeros(system.top + 1)
    bound[system.harmonics] = 2 * np.abs(modes).max(axis=0)
    for strip in strips(system.springs, bound):
        yield {"strip": dict(strip)} if strip else {}


def _refined(
    target: _Target, system: _Galerkin, modes: Vector, square: float, data: dict[str, Any]
) -> dict[str, Any]:
    """Return the certificate's numbers after chord iterations in ball arithmetic."""
    pinned = target.kind == "orbit"
    inverse = arb_mat(system.inverse(modes, square, pinned).tolist())
    shape = modes.shape
    for _ in range(4):
        centre = target.claim(data).centre
        rows = [centre.residual(n, k).mid() for n, k in centre.index]
        if pinned:
            rows.insert(0, (energy_at_start(centre) - arb(target.value)).mid())
        step = [c for (c,) in (inverse * arb_mat(len(rows), 1, rows)).tolist()]
        if pinned:
            moved = centre.frequency_squared - step.pop(0)
            data = {**data, "frequency_squared": decimal_text(moved)}
        known = [centre.modes[n][k] - c for (n, k), c in zip(centre.index, step, strict=True)]
        texts = np.array([decimal_text(c) for c in known], dtype=object).reshape(shape)
        data = {**data, "modes": texts.tolist()}
        if max(abs(float(c)) for c in step) < 1e-32:
            break
    return data
