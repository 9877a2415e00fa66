r"""The tie of a chain's solitary waves to solitons of KdV or mKdV, for all small eps (Theorem 3').

V'(r) = K2 r + sum c_n r^n, p the lowest n (2 or 3), v^2 = K2 (1 + s), s = eps^2, and the strain is
f(n - v t) = a eps^(2/(p - 1)) phi(x), x = eps (n - v t), a = (K2/c_p)^(1/(p - 1)). On the line,

    phi = K*g,   g = N(phi) = phi^p + s sum b_n s^i phi^n,  b_n = c_n a^(n - 1)/K2,
    K has the transform mu/(1 + m),  m = xi^2 h(s xi^2),  mu = 1 - s m.

The soliton Y solves Y - Y''/12 = Y^p: sqrt(2) sech(omega x) for p = 3, (3/2) sech(omega x/2)^2 for
p = 2, omega^2 = 12. With g = Y^p + s (G + eta), G a cosine polynomial on (-d, d) and 0 outside,

    phi = Y + s (Z + K*eta),   Z = K*(G - T/(1 + s)) - s T/(1 + s),   T = -P*Y'''' - Q*(Y^p)'',

P, Q >= 0 the kernels of -h_2 and h, of integrals 1/360 and 1/12, on (-eps, eps). The unknown is
eta, even in L^2: F = G + eta - (N(phi) - Y^p)/s = 0, without a division by s.

    0 <= K <= C exp(-kappa |x|) with S = (sinh(b/2)/(b/2))^2, b = eps kappa, s' = 1 - (S - 1)/s > 0,
    C = (S/2) (24/s')^(1/2) + 4 cosh(b/2)^2 eps/(15^(1/2) pi (s' s + 11/15)),
    K^ <= 1/(1 + xi^2/12), hence |K*h| <= (sqrt(3)/2)^(1/2) ||h||,
    |Y| <= Y_1 exp(-omega |x|), |(Y^p)''| <= 3 p (p^2 - 1) |Y|, |Y''''| <= (144 or 720) |Y|.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from flint import arb, fmpq

from .composition import trimmed
from .cosine_series import (
    Series,
    derivative,
    entry,
    norm,
    polynomial_bound,
    polynomial_of,
    product,
    supremum,
    upper,
)
from .force_text import Force
from .limits import MAX_MODES, CertificateError
from .line_block import LineBlock, LineInterval, line_block, square_integral
from .long_waves import h, h2, h_series
from .periodic import Contraction

CUT = 1e-10
"""Norm of the highest modes of T that are only bounded."""

SLOPE_CUT = 1e-7


@dataclass(frozen=True)
class Soliton:
    """The soliton Y of a polynomial force, with its scaling.

    ``power`` is p; ``coefficients`` are the numbers b_n by n, b_p = 1; ``stiffness`` is K2 and
    ``scale`` is a^(p - 1) = K2/c_p.
    """

    power: int
    coefficients: tuple[fmpq, ...]
    stiffness: fmpq
    scale: fmpq

    @classmethod
    def of(cls, force: Force) -> Soliton:
        """Return the soliton of a force. Raises CertificateError if there is none."""
        c = (*(force.polynomial or ()), *[fmpq(0)] * 4)
        power = 2 if c[2] != 0 else 3
        if not (c[0] == 0 and c[1] > 0 and (c[2] != 0 or c[3] > 0)):
            raise CertificateError(
                "a soliton needs a polynomial force K2 r + K3 r^2 + ... with K2 > 0 and K3 != 0, "
                "or K2 r + K4 r^3 + ... with K4 > 0"
            )
        if power == 3 and any(c[4::2]):
            raise CertificateError("without r^2 the force must have odd powers of r only")
        scale = c[1] / c[power]
        b = [fmpq(0)] * len(c)
        for n in range(power, len(c)):
            if c[n] != 0:
                b[n] = c[n] * scale ** ((n - 1) // (power - 1)) / c[1]
        return cls(power, tuple(b), c[1], scale)

    @property
    def amplitude(self) -> arb:
        """Factor |a| of the strain."""
        return abs(arb(self.scale)) if self.power == 2 else arb(self.scale).sqrt()

    @property
    def crest(self) -> arb:
        """Largest value Y(0)."""
        return arb(3) / 2 if self.power == 2 else arb(2).sqrt()

    @property
    def front(self) -> arb:
        """Constant Y_1 in Y <= Y_1 exp(-omega |x|)."""
        return (4 if self.power == 2 else 2) * self.crest

    @property
    def source_bound(self) -> arb:
        """Constant in |T(x)| <= constant times the largest Y within eps of x."""
        p = self.power
        return arb(3 * p * (p * p - 1)) / 12 + arb(144 if p == 2 else 720) / 360

    @property
    def omega(self) -> arb:
        """Decay rate omega of Y."""
        return arb(12).sqrt()

    @property
    def rate(self) -> arb:
        """Decay rate beta of the transform: it is exp(-beta xi) up to a power of xi."""
        return arb.pi() / (self.omega if self.power == 2 else 2 * self.omega)

    def transform(self, xi: arb) -> arb:
        """Return the Fourier transform of Y at xi >= 0."""
        if self.power == 3:
            return self.crest * arb.pi() / self.omega / (self.rate * xi).cosh()
        if xi.is_zero():
            return arb(3).sqrt()
        return arb.pi() * xi / 2 / (self.rate * xi).sinh()


@dataclass(frozen=True)
class LineTiePiece(LineInterval):
    """A piece of the values of s = eps^2, as a ball, with the correction of the wave there.

    ``correction`` has the modes of G, ``top`` is the highest mode N in the inverted block, and
    ``bound`` the largest norm c of eta.
    """

    soliton: Soliton
    square: arb
    half_length: arb
    kappa: arb
    correction: Sequence[arb]
    top: int
    bound: arb

    @property
    def largest_square(self) -> arb:
        """Upper end of the piece."""
        return upper(self.square)

    def dispersion(self, n: int) -> arb:
        """Return m at xi_n, for every s of the piece."""
        square = self.wavenumber(n) * self.wavenumber(n)
        return square * h(self.square * square)

    def multiplier(self, n: int) -> arb:
        """Return the transform of K at xi_n."""
        m = self.dispersion(n)
        return (1 - self.square * m) / (1 + m)

    @cached_property
    def tail(self) -> arb:
        """Bound of the transform of K at xi_n, n > N."""
        wave = self.wavenumber(self.top + 1)
        return upper(1 / (1 + wave * wave / 12))

    @cached_property
    def embedding(self) -> arb:
        """Constant L in |K*h| <= L ||h||."""
        return upper((arb(3).sqrt() / 2).sqrt())

    @cached_property
    def decay_constant(self) -> arb:
        """Constant C in K(x) <= C exp(-kappa |x|). Raises CertificateError for a large kappa."""
        s, rate = self.largest_square, self.kappa * self.kappa
        if not (s * rate <= 1 and 0 < self.kappa < self.soliton.omega):
            raise CertificateError("0 < kappa < sqrt(12) and eps kappa <= 1 must hold")
        ratio = h_series(-s * rate)
        gap = 1 - rate * ratio
        if not gap > 0:
            raise CertificateError("kappa^2 h(-(eps kappa)^2) < 1 fails (take a smaller kappa)")
        size, spread = 1 + s * rate * ratio, 1 + s * rate * (1 + s * rate * ratio) / 4
        near = size / 2 * (24 / gap).sqrt()
        far = 4 * spread * s.sqrt() / (arb(15).sqrt() * arb.pi() * arb(11) / 15)
        return upper(near + far)

    @cached_property
    def modes(self) -> Series:
        """Modes of the periodic sum of Y over shifts by 2 d; the modes of T beyond are small."""
        top = max(self.top, len(self.correction))
        while not self._rest(top, 4) < CUT:
            top += 8
            if top > MAX_MODES:
                raise CertificateError("half_length is too large for the modes of Y")
        values = [self.soliton.transform(self.wavenumber(n)) for n in range(top + 1)]
        return [value / (2 * self.half_length) for value in values]

    def _rest(self, top: int, power: int) -> arb:
        """Bound the sum of 2 |Y_n| max(1, xi_n^power) over n > ``top``, power <= 4."""
        first = self.wavenumber(top + 1)
        step, rate = self.wavenumber(1), self.soliton.rate
        ratio = (1 + arb(1) / (top + 1)) ** 5 * (-rate * step).exp()
        if not ratio < 1:
            return arb.pos_inf()
        decay = (-rate * first).exp()
        value = self.soliton.transform(first) / (2 * self.half_length)
        sizes = (1 + decay * decay) / (1 - ratio)
        return upper(2 * value * sizes * first.max(arb(1)) ** power)

    @cached_property
    def rests(self) -> tuple[arb, arb]:
        """Bounds of the norms of the modes of Y and of T, hence Z, that are not in the lists."""
        top = len(self.modes) - 1
        fourth = self._rest(top, 4)
        weights = arb(1) / 12 + arb(1) / 144 + arb(1) / 360
        return self._rest(top, 0), upper(weights * fourth)

    @cached_property
    def source(self) -> Series:
        """Modes of the periodic sum of T."""
        result = []
        for n, value in enumerate(self.modes):
            square = self.wavenumber(n) * self.wavenumber(n)
            u = self.square * square
            result.append(value * square * (square * h2(u) + h(u) * (1 + square / 12)))
        return result

    @cached_property
    def change(self) -> Series:
        """Modes of the periodic sum of Z."""
        s, result = self.square, []
        for n, value in enumerate(self.source):
            part = value / (1 + s)
            result.append(self.multiplier(n) * (entry(self.correction, n) - part) - s * part)
        return result

    @cached_property
    def wave(self) -> Series:
        """Modes of Y + s Z."""
        return [a + self.square * b for a, b in zip(self.modes, self.change, strict=True)]

    @cached_property
    def nonlinear(self) -> tuple[Series, Series]:
        """Coefficients of the polynomials N(y) and (N(y) - y^p)/s."""
        p, b = self.soliton.power, self.soliton.coefficients
        full, higher = [arb(0)] * len(b), [arb(0)] * len(b)
        full[p] = arb(1)
        for n in range(p + 1, len(b)):
            if b[n] != 0:
                order = (n - p) // (p - 1)
                higher[n] = arb(b[n]) * self.square ** (order - 1)
                full[n] = self.square * higher[n]
        return full, higher

    @cached_property
    def fronts(self) -> tuple[arb, arb]:
        """Constants in |Y| <= Y_1 exp(-kappa |x|) and |Z| <= Z_1 exp(-kappa |x|)."""
        soliton, s = self.soliton, self.largest_square
        source = soliton.source_bound * soliton.front * (soliton.omega * s.sqrt()).exp()
        square = square_integral([self.correction], 2 * self.kappa, self.half_length)
        weight = (2 * self.half_length * square).abs_upper().sqrt()
        weight += 2 * source / (soliton.omega - self.kappa)
        return upper(soliton.front), upper(self.decay_constant * weight + s * source)

    @cached_property
    def periodic_errors(self) -> tuple[arb, arb]:
        """Bounds on (-d, d) of the differences of Y and Z from their series."""
        images = 2 * self.images * self.edge
        pairs = zip(self.fronts, self.rests, strict=True)
        first, second = (upper(images * front + rest) for front, rest in pairs)
        return first, second

    @cached_property
    def outer(self) -> tuple[arb, arb]:
        """Bounds of Y and Z outside (-d, d)."""
        return upper(self.fronts[0] * self.edge), upper(self.fronts[1] * self.edge)

    @cached_property
    def distance(self) -> tuple[arb, arb]:
        """Lower and upper bounds of sup |phi - Y|/s."""
        low, high = supremum(self.change)
        error = self.periodic_errors[1] + self.embedding * self.bound
        return (low - error).lower(), upper((high + error).max(self.outer[1] + error))


def defect(piece: LineTiePiece) -> Series:
    """Return the modes of F at the series of the centre, eta = 0."""
    p, higher = piece.soliton.power, piece.nonlinear[1]
    factor: Series = [arb(0)]
    below: Series = [arb(1)]
    for _ in range(p):
        factor = product(factor, piece.wave)
        factor = [entry(factor, n) + entry(below, n) for n in range(max(len(factor), len(below)))]
        below = product(below, piece.modes)
    force = product(piece.change, factor)
    rest = polynomial_of(higher, piece.wave)
    count = max(len(force), len(rest), len(piece.correction))
    return [entry(piece.correction, n) - entry(force, n) - entry(rest, n) for n in range(count)]


def tie_block(piece: LineTiePiece) -> tuple[LineBlock, arb]:
    """Return the inverted linear part, and the norm of the modes of W that it leaves out."""
    slope = polynomial_of(derivative(piece.nonlinear[0], 1), piece.wave)
    known, rest = trimmed(slope, arb(1), SLOPE_CUT)
    block = line_block(
        [known], lambda n: [[piece.multiplier(n)]], piece.tail, piece.top + 1, piece.half_length
    )
    return block, rest


def line_tie_contraction(piece: LineTiePiece) -> Contraction:
    """Return the bounds of the map eta - A F(eta) about 0. Raises CertificateError."""
    if not (piece.half_length > 0 and piece.bound > 0):
        raise CertificateError("half_length > 0 and bound > 0 must hold")
    p, (full, higher) = piece.soliton.power, piece.nonlinear
    block, rest = tie_block(piece)
    (error_y, error_z), (outer_y, outer_z) = piece.periodic_errors, piece.outer
    s, kappa, length = piece.largest_square, piece.kappa, (2 * piece.half_length).sqrt()
    size_z = norm(piece.change, arb(1)) + error_z
    reach = upper(piece.soliton.crest + error_y + s * size_z)
    slope, second = derivative(full, 1), derivative(full, 2)
    by_y = size_z * p * (p - 1) * reach ** (p - 2) + polynomial_bound(derivative(higher, 1), reach)
    inner = length * (by_y * error_y + polynomial_bound(slope, reach) * error_z)
    outer = upper(outer_y + s * outer_z)
    outside = outer_z * p * outer ** (p - 1) + polynomial_bound(higher, outer)
    front = polynomial_bound(slope, upper(piece.fronts[0] + s * piece.fronts[1])) * piece.edge
    coupling = (2 * piece.images + 1) * piece.decay_constant * front * length / kappa.sqrt()
    variation = polynomial_bound(second, reach) * (error_y + s * error_z) + rest
    third = polynomial_bound(second, upper(reach + outer + s * piece.embedding * piece.bound))
    return Contraction(
        upper(
            block.image_size([defect(piece)]) + block.size * inner + outside / (2 * kappa).sqrt()
        ),
        block.contraction,
        upper(block.size * (coupling + variation) + polynomial_bound(slope, outer)),
        upper(block.size * third * s * piece.embedding),
    )
