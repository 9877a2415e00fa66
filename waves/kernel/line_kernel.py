r"""Kernels of the linear chain on the whole line, with their decay, seen from a wave of speed v.

T_m(k) = sin(m k/2)/(k/2) is the transform of a box of length m, and a strain f that moves with the
speed v has the symbol Delta(k) = v^2 - sum_m K_m T_m(k)^2. A kernel has the transforms
T_m T_n/Delta^j, m, n among the ``boxes``. If Re Delta > 0 on the line Im k = kappa, then it is on
the strip |Im k| <= kappa, since a harmonic function is least on the boundary. So Delta has no zero
there, and the path of integration can be moved to the line:

    |kernel(x)| <= C_j exp(-kappa |x|),  C_j = integral_0^oo sum_m |T_m|^2/|Delta|^j dk/pi.

Hence |kernel*h| <= (C_j/sqrt(kappa)) ||h|| and ||kernel*h|| <= (2 C_j/kappa) ||h||.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from flint import acb, arb

from .cosine_series import upper
from .limits import CertificateError

PIECES = 32
"""Number of pieces of the line of integration in the length kappa."""

MOST_PIECES = 20_000
END = 16
"""Least end of the pieces; beyond it, the integrand is bounded by its decay 1/k^2."""

POWERS = 3
"""Largest power j of 1/Delta in a kernel."""


@dataclass(frozen=True)
class LineKernel:
    """Symbol of a chain with the stiffness K_m between m-th neighbours, for waves of one speed."""

    stiffness: tuple[tuple[int, arb], ...]
    speed_squared: arb
    kappa: arb
    boxes: tuple[int, ...]

    @property
    def gap(self) -> arb:
        """Gap Delta(0) = v^2 - c^2 above the squared speed of sound c^2 = sum K_m m^2."""
        return self.symbol(arb(0))

    def symbol(self, k: arb) -> arb:
        """Return Delta(k) for a real k."""
        squares = ((stiffness, box(m, k)) for m, stiffness in self.stiffness)
        return self.speed_squared - sum((s * t * t for s, t in squares), arb(0))

    def largest_beyond(self, k: arb) -> arb:
        """Bound sum_m T_m^2/Delta for all real wavenumbers from ``k`` on.

        From 1/sin(b)^2 >= 1/b^2 + 1/3 follows T_m^2 <= m^2/(1 + k^2/12).
        """
        positive = sum((upper(s).max(arb(0)) * m * m for m, s in self.stiffness), arb(0))
        below = self.speed_squared - positive + self.speed_squared * k * k / 12
        if not below > 0:
            raise CertificateError("block must have more modes: the symbol is not proved positive")
        return upper(sum(m * m for m in self.boxes) / below)

    @cached_property
    def constants(self) -> tuple[arb, ...]:
        """Constants C_1 ... C_3. Raises CertificateError if Re Delta > 0 fails on the line."""
        if not (self.kappa > 0 and self.kappa < 10):
            raise CertificateError("0 < kappa < 10 must hold")
        growth = {m: (m * self.kappa / 2).cosh() ** 2 for m in {*dict(self.stiffness), *self.boxes}}
        pull = 4 * sum((abs(s) * growth[m] for m, s in self.stiffness), arb(0))
        end = upper((2 * (pull / self.speed_squared).sqrt()).max(arb(END)))
        totals = [arb(0)] * POWERS
        for low, step in self._pieces(end):
            squares = {m: self._square(m, low, step) for m in growth}
            delta = self.speed_squared - sum((s * squares[m] for m, s in self.stiffness), acb(0))
            if not delta.real > 0:
                raise CertificateError("the symbol is not proved positive for this speed and kappa")
            size = step * sum((abs(squares[m]) for m in self.boxes), arb(0))
            for j in range(POWERS):
                size = upper(size / abs(delta))
                totals[j] += size
        rest = 4 * sum((growth[m] for m in self.boxes), arb(0)) / end
        for j in range(POWERS):
            rest = upper(rest / (self.speed_squared - pull / (end * end)))
            totals[j] = upper((totals[j] + rest) / arb.pi())
        if not all(total.is_finite() for total in totals):
            raise CertificateError("the kernel is not bounded for this speed and kappa")
        return tuple(totals)

    def _pieces(self, end: arb) -> Iterator[tuple[arb, arb]]:
        """Yield beginning and length of pieces that cover (0, ``end``), all exact."""
        low, most = arb(0), arb(1) / (8 * max(m for m, _ in self.stiffness))
        for _ in range(MOST_PIECES):
            step = ((self.kappa + low) / PIECES).min(most).mid()
            yield low, step
            low = (low + step).lower()
            if low >= end:
                return
        raise CertificateError(f"the kernel must be bounded by at most {MOST_PIECES} pieces")

    def _square(self, m: int, low: arb, step: arb) -> acb:
        """Enclose T_m^2 at k = x + i kappa, low <= x <= low + ``step``, from the middle.

        T_m^2 is the transform of a triangle of variance m^2/6 and mass m^2, so its derivative is
        at most |k| cosh(m kappa) m^4/6; and T_m^2 = 2 (1 - cos(m k))/k^2.
        """
        near, far = acb(low, self.kappa), acb(low + step, self.kappa)
        growth = (m * self.kappa).cosh()
        rate = (abs(far) * growth * m**4 / 6).min(
            2 * m * growth / abs(near) ** 2 + 4 * (1 + growth) / abs(near) ** 3
        )
        middle = m * (m * acb(low + step / 2, self.kappa) / 2).sinc()
        error = arb(0, upper(step * rate / 2))
        return middle * middle + acb(error, error)


def box(m: int, k: arb) -> arb:
    """Return T_m(k) = sin(m k/2)/(k/2) for a real k."""
    return m * (m * k / 2).sinc()
