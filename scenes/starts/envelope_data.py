"""Carrier waves on a lattice, modulated by an envelope A(X, T): initial data and reference values.

With ``X = eps (n - v t)`` and ``T = eps^2 t`` the fields are ``eps (e_j A exp(i theta) + c.c.)``
with the polarisation e_j, plus the terms slaved to A: second harmonic, mean, other branches.  Time
derivatives are total ones: theta and X depend on t, and A_T follows from the envelope equation.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.derive import CarrierTerms, Envelope, carrier_fields
from longwave.derive.algebra.exact_numbers import Number
from longwave.lattice.numeric_lattice import NumericLattice, numeric_lattice, stretch_text
from longwave.scenes.starts.envelope_flow import EnvelopeFlow
from longwave.scenes.starts.initial_cells import InitialCells
from longwave.scenes.starts.lattice_wave import LatticeWave
from longwave.solutions.pieces import PIECE

if TYPE_CHECKING:
    from longwave.solutions import Wave

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

HIGHEST_POWERS = {"leading": 1, "slaved": 2, "corrected": 3}
"""Highest power of eps in the fields, by the order of the data."""


END_LEVEL = 1e-9
"""Modulus of A, relative to the largest, below which a wave counts as ended."""

FARTHEST_X = 400.0
"""Distance in X at which a wave that has not ended counts as infinite."""

INTERVAL_WIDTHS = 2.0
"""Length of the interval on which the next order is solved, in units of the wave's width."""


class EnvelopeWave(Protocol):
    """Solution A of the envelope equation, with or without its next order."""

    def jets(self, X: Array, T: float, highest: int) -> Any:
        """Return complex A and its X-derivatives up to ``highest``, (highest + 1, *points)."""


class PlaneBackground:
    """Plane-wave background of a closed form; 0 if the closed form is a plane wave itself."""

    def __init__(self, wave: Wave) -> None:
        self._wave = wave

    def jets(self, X: Array, T: float, highest: int) -> Complex:
        """Return A and its X-derivatives up to order ``highest``, (highest + 1, *points).

        Each derivative is the previous one times i times the wavenumber of the plane wave.
        """
        A, far = self._wave.background(X, T), np.linspace(-FARTHEST_X, FARTHEST_X, END_SAMPLES)
        if np.array_equal(self._wave.background(far, T).Y, self._wave.jets(far, T, 0)[0]):
            return np.zeros((highest + 1, *A.Y.shape), np.complex128)
        turn = np.divide(A.Y_X, A.Y, out=np.zeros_like(A.Y), where=A.Y != 0.0)
        return np.stack([A.Y * turn**order for order in range(highest + 1)])


END_SAMPLES = 8001
"""Number of points in X at which a wave's ends are searched for."""


class EnvelopeData(LatticeWave):
    """Wave of an envelope equation on its lattice.

    ``numbers`` are the lattice's constants; ``k`` and ``branch`` default to those of the envelope.
    The order "leading" is the carrier with its amplitude only; "slaved" adds the terms in eps^2;
    "corrected" adds those in eps^3, and from `start` on its amplitude follows the envelope equation
    with the next order (`EnvelopeFlow`), solved on a periodic ``interval`` of X: whole periods, or
    many widths of the wave.  A wave of finite extent needs no interval.

    Slaved data contain the mean strain that belongs to the wave.  Leading data contain a uniform
    mean strain only: that of ``mean_square``, the mean of |A|^2 over the ring, or far away on an
    infinite chain.  Without it the frequency of a wave on a background is off by order eps^2.

    Displacements need consecutive cells and are determined up to a common constant.
    """

    power = 1
    slow = 2

    def __init__(
        self,
        envelope: Envelope,
        numbers: Mapping[str, Number],
        wave: EnvelopeWave,
        eps: float,
        order: str = "slaved",
        *,
        k: Number | None = None,
        branch: str | int | None = None,
        mean_square: float = 0.0,
        interval: tuple[float, float] | None = None,
    ) -> None:
        self.eps, self.order, self.wave = float(eps), order, wave
        self._interval = interval
        self._flow: EnvelopeWave | None = wave if order != "corrected" else None
        self.carrier = carrier_fields(envelope, k, branch, **numbers)
        self.speed = self.carrier.v
        self._declared = envelope.lattice
        names = {str(symbol) for symbol in self._declared.constants}
        self._numbers = {name: value for name, value in numbers.items() if name in names}
        self._strained: dict[tuple[float, ...], NumericLattice] = {}
        self.lattice = self.strained_lattice((0.0,))
        background = sum(term.value.real for term in self.carrier.mean if term.power == 2)
        self._uniform = self.eps**2 * background * mean_square if order == "leading" else 0.0

    def strained_lattice(self, mean_strain: tuple[float, ...]) -> NumericLattice:
        """Return the lattice about this uniform strain; cached."""
        if mean_strain not in self._strained:
            used = mean_strain if any(mean_strain) else ()
            lattice = numeric_lattice(self._declared, self._numbers, used, self.growth_shares)
            self._strained[mean_strain] = lattice
        return self._strained[mean_strain]

    @property
    def frequency(self) -> float:
        """Frequency of the carrier."""
        return abs(float(self.carrier.omega))

    @property
    def growth_shares(self) -> tuple[float, ...]:
        """Growth of each field's displacement per cell, in units of the mean strain."""
        return self.carrier.shares

    def support(self, t: float) -> tuple[float, float]:
        """Return the wave's first and last cell at time t; infinite for a wave without ends."""
        first, last = _ends(self.wave, self.eps**2 * t)
        return first / self.eps + self.speed * t, last / self.eps + self.speed * t

    def start(self, t: float) -> None:
        """Start the corrected amplitude from the wave at time t; no effect in other orders.

        Raises ValueError for an infinite wave without an interval.
        """
        if self.order != "corrected":
            return
        T = self.eps**2 * t
        first, last = self._interval or _ends(self.wave, T, INTERVAL_WIDTHS)
        if not np.isfinite(last - first):
            raise ValueError(
                "interval must be given for a wave that does not end, got None (two ends in X that "
                "enclose whole periods of |A|, or many widths of the wave)"
            )
        ends = self.wave.jets(np.array([first, last]), T, 0)[0]
        self._flow = EnvelopeFlow(
            self.carrier,
            self.eps,
            lambda X: self.wave.jets(X, T, 0)[0],
            first=first,
            length=last - first,
            points=2 ** int(np.log2((last - first) / self.eps)),
            T0=T,
            turn=float(np.angle(ends[1] * np.conj(ends[0]))),
        )

    @property
    def amplitude(self) -> EnvelopeWave:
        """Envelope A, with the next order if corrected.

        Raises ValueError for corrected data before `start`.
        """
        if self._flow is None:
            raise ValueError(
                "start must be called before corrected data are used, got no start time (the next "
                "order is solved from there)"
            )
        return self._flow

    def state(self, cells: ArrayLike, t: float) -> tuple[Array, Array]:
        """Return fields and their time derivatives at cells and a time, each (fields, *sites)."""
        n = np.asarray(cells, dtype=np.float64)
        (f, v), mean = np.empty((2, len(self.carrier.parts), n.size)), np.empty((3, n.size))
        for piece in _pieces(n):
            jets = _Jets(self, n[piece], t)
            theta = self.carrier.k * n[piece] - self.carrier.omega * t
            mean[:, piece] = self._mean(jets, n[piece])
            for row, terms in enumerate(self.carrier.parts):
                f[row, piece], v[row, piece] = self._field(terms, jets, theta)
        if self.order != "leading" and self.carrier.is_displacement:
            mean[0] = _integral(mean[0], mean[2], n)
        for row, share in enumerate(self.carrier.shares):
            f[row] += share * mean[0]
            v[row] += share * mean[1]
        return f, v

    def mean_strain(self, cells: Array, t: float) -> tuple[float, ...]:
        """Return the mean growth of displacements per cell over a ring of these cells."""
        if not self.carrier.is_displacement:
            return (0.0,)
        if self.order == "leading":
            return (self._uniform,)
        terms = self._terms(self.carrier.mean)
        strains = [_Jets(self, cells[piece], t).sums(terms)[0].real for piece in _pieces(cells)]
        return (float(np.mean(np.concatenate(strains))),)

    def rest_slopes(self, ring: InitialCells) -> list[float]:
        """Return the slope of each bond's force at the ring's mean strain.

        The carrier oscillates about that strain; the stretches at one time are not representative.
        """
        return ring.lattice.rest_slopes()

    def strain(self, cells: ArrayLike, t: float) -> Array:
        """Return the compared quantities: stretches of bonds for displacements, else the fields."""
        n = np.asarray(cells, dtype=np.float64)
        if not self.carrier.is_displacement:
            return self.state(n, t)[0]
        beyond = 1.0 + np.arange(self.lattice.reach)
        wide = np.concatenate([n[0] - beyond[::-1], n, n[-1] + beyond])
        inner = slice(beyond.size, -beyond.size)
        return np.stack(self.lattice.stretches(self.state(wide, t)[0]))[:, inner]

    def background(self, cells: ArrayLike, t: float) -> Array:
        """Return the compared quantities of the wave's plane background; 0 if it has none."""
        bare = copy(self)
        bare._flow = PlaneBackground(cast("Wave", self.wave))
        return bare.strain(cells, t)

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of the compared quantities: the bonds' stretches, or the fields."""
        if self.carrier.is_displacement:
            bonds = self.lattice.bonds
            return tuple(stretch_text(bond.stretch, self.lattice.fields) for bond in bonds)
        return super().quantities

    def quantity_values(self, f: ArrayLike, mean_strain: tuple[float, ...]) -> Array:
        """Return the compared quantities of the fields on a ring with this mean strain."""
        fields = np.asarray(f, dtype=np.float64)
        if not self.carrier.is_displacement:
            return fields
        return np.stack(self.strained_lattice(mean_strain).stretches(fields))

    def _terms(self, terms: CarrierTerms) -> CarrierTerms:
        """Return the terms up to the power of eps that ``order`` includes (`HIGHEST_POWERS`)."""
        return tuple(term for term in terms if term.power <= HIGHEST_POWERS[self.order])

    def _field(self, terms: CarrierTerms, jets: _Jets, theta: Array) -> tuple[Array, Array]:
        """Return a field less its mean over the carrier, and the time derivative of this part."""
        f, v = np.zeros_like(theta), np.zeros_like(theta)
        used = self._terms(terms)
        for j in sorted({term.harmonic for term in used}):
            value, rate = jets.sums([term for term in used if term.harmonic == j])
            phase = (2.0 if j else 1.0) * np.exp(1j * j * theta)
            f += (phase * value).real
            v += (phase * (rate - 1j * j * self.carrier.omega * value)).real
        return f, v

    def _mean(self, jets: _Jets, n: Array) -> tuple[Array, Array, Array]:
        """Return the mean of the fields, its time derivative and its slope from cell to cell.

        For displacements beyond "leading", the first array is the mean strain, which `state`
        integrates over cells, and the third its slope; otherwise the third is 0.
        """
        form, eps, zero = self.carrier, self.eps, np.zeros_like(n)
        if self.order == "leading":
            growth = n if form.is_displacement else np.ones_like(n)
            return self._uniform * growth, zero, zero
        strain, rate = (part.real for part in jets.sums(self._terms(form.mean)))
        if not form.is_displacement:
            return strain, rate, zero
        slope = jets.sums(self._terms(form.mean_slope))[0].real
        flow = jets.sums(form.mean_flow)[0].real
        return strain, -form.v * strain + eps * flow, eps * slope


def _pieces(n: Array) -> list[slice]:
    return [slice(first, first + PIECE) for first in range(0, n.size, PIECE)]


def _integral(values: Array, slopes: Array, n: Array) -> Array:
    """Integrate over consecutive cells, by the trapezoidal rule with its end correction.

    The error is about 1/720 of the third derivative of ``values``, however many cells there are.
    Raises ValueError unless the cells are consecutive.
    """
    if n.ndim != 1 or not np.allclose(np.diff(n), 1.0):
        raise ValueError(
            f"cells must be consecutive, got {n.size} that are not (displacements are summed over "
            "them)"
        )
    steps = np.concatenate([[0.0], (values[1:] + values[:-1]) / 2])
    return np.asarray(np.cumsum(steps) - (slopes - slopes[0]) / 12)


def _ends(wave: EnvelopeWave, T: float, wider: float = 1.0) -> tuple[float, float]:
    """Return the wave's ends in X at T, widened by the factor ``wider``; infinite without ends."""
    X = np.linspace(-FARTHEST_X, FARTHEST_X, END_SAMPLES)
    modulus = np.abs(wave.jets(X, T, 0)[0])
    inside = X[modulus > END_LEVEL * np.max(modulus)]
    if abs(inside[0]) == FARTHEST_X or abs(inside[-1]) == FARTHEST_X:
        return -np.inf, np.inf
    middle, half = (inside[0] + inside[-1]) / 2, (inside[-1] - inside[0]) / 2
    return float(middle - wider * half), float(middle + wider * half)


class _Jets:
    """A and its X-derivatives at cells and a time, and the time derivatives of all of these."""

    def __init__(self, data: EnvelopeData, n: Array, t: float) -> None:
        form, self.eps = data.carrier, data.eps
        most = 1 if data.order == "corrected" else 0
        flows = [[term for term in terms if term.power <= most] for terms in form.flow]
        jets = data.amplitude.jets(self.eps * (n - form.v * t), self.eps**2 * t, form.highest_jet)
        self.values = np.asarray(jets, dtype=np.complex128)
        self.rates = [
            self.eps**2 * self._sum(flow) - self.eps * form.v * self.values[m + 1]
            for m, flow in enumerate(flows)
        ]

    def _sum(self, terms: Sequence[Any]) -> Complex:
        total = np.zeros_like(self.values[0])
        for term in terms:
            product = np.full_like(total, self.eps**term.power * term.value)
            for jet in term.jets:
                product *= _of(self.values, jet)
            total += product
        return total

    def sums(self, terms: Sequence[Any]) -> tuple[Complex, Complex]:
        """Return a polynomial in A and its X-derivatives, and its time derivative."""
        rate = np.zeros_like(self.values[0])
        for term in terms:
            for i, jet in enumerate(term.jets):
                product = self.eps**term.power * term.value * _of(self.rates, jet)
                for other in (*term.jets[:i], *term.jets[i + 1 :]):
                    product = product * _of(self.values, other)
                rate += product
        return self._sum(terms), rate


def _of(values: Any, jet: tuple[int, ...]) -> Complex:
    count, conjugated = jet
    return np.conj(values[count]) if conjugated else np.asarray(values[count])
