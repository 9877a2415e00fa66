"""Carrier waves on a lattice: data from an envelope A(X, T), and what the lattice is compared with.

With ``X = eps (n - v t)`` and ``T = eps^2 t`` the fields are ``eps (e_j A exp(i theta) + c.c.)``
with the polarisation e_j, then what follows A: second harmonic, mean, the other branches.  Time
derivatives are whole ones: theta and X move, and A_T is that of the envelope equation.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.derive import CarrierTerms, Envelope, carrier_fields
from longwave.derive.algebra.exact_numbers import Number
from longwave.lattice.numeric_lattice import (
    NumericLattice,
    numeric_lattice,
    stretch_text,
)
from longwave.scenes.starts.envelope_flow import EnvelopeFlow
from longwave.scenes.starts.initial_cells import InitialCells
from longwave.scenes.starts.lattice_wave import LatticeWave
from longwave.solutions.pieces import PIECE

if TYPE_CHECKING:
    from longwave.solutions import Wave

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

POWERS = {"leading": 1, "slaved": 2, "corrected": 3}
"""The highest power of eps in the fields."""


FLAT = 1e-9
"""A wave has ended where it is below that share of its largest value."""

FARTHEST = 400.0
"""A wave that has not ended so far in X fills the line."""

WIDER = 2.0
"""The interval on which the next order is solved, in units of the wave's width."""


class EnvelopeWave(Protocol):
    """A solution A of the envelope equation, or of that with the next order."""

    def jets(self, X: Array, T: float, highest: int) -> Any:
        """A and its X-derivatives, complex, (highest + 1, *points)."""


class PlaneBackground:
    """The plane wave that a closed form deviates from; 0 for what is a plane wave itself."""

    def __init__(self, wave: Wave) -> None:
        self._wave = wave

    def jets(self, X: Array, T: float, highest: int) -> Complex:
        """A and its X-derivatives, each the same multiple of the one before it."""
        A = self._wave.background(X, T)
        if self._is_plane(T):
            return np.zeros((highest + 1, *A.Y.shape), np.complex128)
        turn = np.divide(A.Y_X, A.Y, out=np.zeros_like(A.Y), where=A.Y != 0.0)
        return np.stack([A.Y * turn**order for order in range(highest + 1)])

    def _is_plane(self, T: float) -> bool:
        X = np.linspace(-FARTHEST, FARTHEST, LOOKS)
        return np.array_equal(self._wave.background(X, T).Y, self._wave.jets(X, T, 0)[0])


LOOKS = 8001
"""Places where it is looked for a wave."""


class EnvelopeData(LatticeWave):
    """The wave ``wave`` of an envelope equation, on the lattice of that envelope.

    ``numbers`` are the lattice's constants; ``k`` and ``branch`` those of the envelope unless they
    are given.  The order "leading" is the carrier with its amplitude alone; "slaved" has the terms
    in eps^2 too; "corrected" has those in eps^3, and from `start` on its amplitude follows the
    equation with the next order (`EnvelopeFlow`), on an ``interval`` of X which that repeats: whole
    periods, or many times the width of what there is.  A wave that ends needs none.

    Slaved data hold the mean strain that belongs to the wave.  Leading data hold none but a uniform
    one: that of ``mean_square``, the mean of |A|^2 over the ring, or far away on an infinite chain.
    Without it a wave on a background turns at another frequency, by a part of order eps^2.

    ``lattice`` is what is run, where the envelope is that of its expansion; its constants are among
    those numbers.  Cells must be consecutive on a lattice of displacements, which are told up to a
    common constant.
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
        self.lattice = self.strained((0.0,))
        background = sum(term.value.real for term in self.carrier.mean if term.power == 2)
        self._uniform = self.eps**2 * background * mean_square if order == "leading" else 0.0

    def strained(self, mean_strain: tuple[float, ...]) -> NumericLattice:
        """The lattice about this uniform strain."""
        if mean_strain not in self._strained:
            used = mean_strain if any(mean_strain) else ()
            found = numeric_lattice(self._declared, self._numbers, used, self.growth_shares)
            self._strained[mean_strain] = found
        return self._strained[mean_strain]

    @property
    def frequency(self) -> float:
        """The carrier's."""
        return abs(float(self.carrier.omega))

    @property
    def growth_shares(self) -> tuple[float, ...]:
        """The shares of the fields in the mean."""
        return self.carrier.shares

    def support(self, t: float) -> tuple[float, float]:
        """The cells between which there is a wave."""
        first, last = _ends(self.wave, self.eps**2 * t)
        return first / self.eps + self.speed * t, last / self.eps + self.speed * t

    def start(self, t: float) -> None:
        """Let the amplitude of corrected data begin as the wave at this time."""
        if self.order != "corrected":
            return
        T = self.eps**2 * t
        first, last = self._interval or _ends(self.wave, T, WIDER)
        if not np.isfinite(last - first):
            raise ValueError(
                "interval must be given for a wave that does not end, got None (two ends in X that "
                "hold whole periods of |A|, or many times the width of what there is)"
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
        """A: the wave, or of corrected data what it becomes; ValueError before `start`."""
        if self._flow is None:
            raise ValueError(
                "start must be called for corrected data, got no time yet (the amplitude follows "
                "the next order from there)"
            )
        return self._flow

    def state(self, cells: ArrayLike, t: float) -> tuple[Array, Array]:
        """Fields and their time derivatives, (fields, *sites)."""
        n = np.asarray(cells, dtype=np.float64)
        fields = len(self.carrier.parts)
        f, v, mean = np.empty((fields, n.size)), np.empty((fields, n.size)), np.empty((3, n.size))
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
        """What displacements grow by in a cell, on average over a ring of these cells."""
        if not self.carrier.is_displacement:
            return (0.0,)
        if self.order == "leading":
            return (self._uniform,)
        kept = self._kept(self.carrier.mean)
        strains = [_Jets(self, cells[piece], t).sums(kept)[0].real for piece in _pieces(cells)]
        return (float(np.mean(np.concatenate(strains))),)

    def rest_slopes(self, ring: InitialCells) -> list[float]:
        """The slope of each bond's force at the ring's mean strain, about which the carrier swings.

        No cell within a carrier is at rest: its bonds at one time say nothing of the next.
        """
        return ring.lattice.rest_slopes()

    def strain(self, cells: ArrayLike, t: float) -> Array:
        """What is compared: the stretch of each bond in displacements, otherwise the fields."""
        n = np.asarray(cells, dtype=np.float64)
        if not self.carrier.is_displacement:
            return self.state(n, t)[0]
        beyond = 1.0 + np.arange(self.lattice.reach)
        wide = np.concatenate([n[0] - beyond[::-1], n, n[-1] + beyond])
        inner = slice(beyond.size, -beyond.size)
        return np.stack(self.lattice.stretches(self.state(wide, t)[0]))[:, inner]

    def background(self, cells: ArrayLike, t: float) -> Array:
        """The plane wave that the envelope deviates from, on the lattice; 0 if there is none."""
        bare = copy(self)
        bare._flow = PlaneBackground(cast("Wave", self.wave))
        return bare.strain(cells, t)

    @property
    def quantities(self) -> tuple[str, ...]:
        """What stretches the bonds, or the fields themselves."""
        if self.carrier.is_displacement:
            bonds = self.lattice.bonds
            return tuple(stretch_text(bond.stretch, self.lattice.fields) for bond in bonds)
        return super().quantities

    def measured(self, f: ArrayLike, mean_strain: tuple[float, ...]) -> Array:
        """The same from the fields of a ring."""
        fields = np.asarray(f, dtype=np.float64)
        if not self.carrier.is_displacement:
            return fields
        return np.stack(self.strained(mean_strain).stretches(fields))

    # the parts of the ansatz

    def _kept(self, terms: CarrierTerms) -> CarrierTerms:
        return tuple(term for term in terms if term.power <= POWERS[self.order])

    def _field(self, terms: CarrierTerms, jets: _Jets, theta: Array) -> tuple[Array, Array]:
        """A field without the mean, and its time derivative."""
        f, v = np.zeros_like(theta), np.zeros_like(theta)
        kept = self._kept(terms)
        for j in sorted({term.harmonic for term in kept}):
            value, rate = jets.sums([term for term in kept if term.harmonic == j])
            turn = (2.0 if j else 1.0) * np.exp(1j * j * theta)
            f += (turn * value).real
            v += (turn * (rate - 1j * j * self.carrier.omega * value)).real
        return f, v

    def _mean(self, jets: _Jets, n: Array) -> tuple[Array, Array, Array]:
        """The mean and its time derivative; of slaved displacements what the mean is the integral
        of, with the slope of that.
        """
        form, eps, none = self.carrier, self.eps, np.zeros_like(n)
        if self.order == "leading":
            grown = n if form.is_displacement else np.ones_like(n)
            return self._uniform * grown, none, none
        strain, rate = (part.real for part in jets.sums(self._kept(form.mean)))
        if not form.is_displacement:
            return strain, rate, none
        slope = jets.sums(self._kept(form.mean_slope))[0].real
        flow = jets.sums(form.mean_flow)[0].real
        return strain, -form.v * strain + eps * flow, eps * slope


def _pieces(n: Array) -> list[slice]:
    return [slice(first, first + PIECE) for first in range(0, n.size, PIECE)]


def _integral(values: Array, slopes: Array, n: Array) -> Array:
    """The integral from the first of consecutive cells, by the trapezoidal rule with its end term.

    Its error is values'''/720, whatever the number of cells.
    """
    if n.ndim != 1 or not np.allclose(np.diff(n), 1.0):
        raise ValueError(
            f"cells must be consecutive, got {n.size} others (displacements are summed over them)"
        )
    steps = np.concatenate([[0.0], (values[1:] + values[:-1]) / 2])
    return np.asarray(np.cumsum(steps) - (slopes - slopes[0]) / 12)


def _ends(wave: EnvelopeWave, T: float, wider: float = 1.0) -> tuple[float, float]:
    """The X between which there is a wave, stretched about their middle; or all X."""
    X = np.linspace(-FARTHEST, FARTHEST, LOOKS)
    size = np.abs(wave.jets(X, T, 0)[0])
    inside = X[size > FLAT * np.max(size)]
    if abs(inside[0]) == FARTHEST or abs(inside[-1]) == FARTHEST:
        return -np.inf, np.inf
    middle, half = (inside[0] + inside[-1]) / 2, (inside[-1] - inside[0]) / 2
    return float(middle - wider * half), float(middle + wider * half)


class _Jets:
    """A, its conjugate and their X-derivatives at cells and a time, with their time derivatives."""

    def __init__(self, data: EnvelopeData, n: Array, t: float) -> None:
        form, self.eps = data.carrier, data.eps
        most = 1 if data.order == "corrected" else 0
        flows = [[term for term in terms if term.power <= most] for terms in form.flow]
        found = data.amplitude.jets(self.eps * (n - form.v * t), self.eps**2 * t, form.highest_jet)
        self.values = np.asarray(found, dtype=np.complex128)
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
        """A polynomial in the jets, and its time derivative at a fixed phase."""
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
