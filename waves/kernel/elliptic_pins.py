r"""Elliptic waves of KdV and of the modified KdV equation as cosine series, by the nome.

On the chain V'(r) = K2 r + K3 r^2 + K4 r^3 + ... the strain is eps^p Y, v^2 = K2 + sigma eps^2,
with K = K(k), E = E(k), q the nome.

Modified KdV: K3 = 0, p = 1, a^2 = 6 |K4|/K2, sigma = |K4|/2 times 2 - k^2, 2 k^2 - 1, -(1 + k^2):

    dn           P = 2K/(a eps)   f_0 = pi eps/(2K)   f_j = (pi eps/K) q^j/(1 + q^(2j))
    k cn         P = 4K/(a eps)   odd j:  f_j = (pi eps/K) q^(j/2)/(1 + q^j)
    k sn(x + K)  P = 4K/(a eps)   odd j:  f_j = (-1)^((j-1)/2) (pi eps/K) q^(j/2)/(1 - q^j)

KdV: K3 != 0, p = 2, Y = (K2/(2 K3)) k^2 cn^2(x), sigma = K2 (2 k^2 - 1)/3, c = K2 eps^2/(2 K3):

    cnoidal      P = 2K/eps       f_0 = c (E/K - 1 + k^2)   f_j = c (pi/K)^2 j q^j/(1 - q^(2j))
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from flint import acb, arb, fmpq

from .cosine_series import Series, upper
from .force_text import Force
from .limits import CertificateError


@dataclass(frozen=True)
class EllipticForm:
    """A form of Y: the strain is eps^order Y, for a force with the given sign of its nonlinearity.

    ``sign`` is that of the coefficient of r^(1 + 2/order), or 0 for either sign. ``stride`` is the
    distance of nonzero modes, ``growth`` the power of j in mode j. ``speed`` returns the factor
    of sigma for a squared modulus.
    """

    order: int
    sign: int
    quarters: int
    stride: int
    growth: int
    speed: Callable[[fmpq], fmpq]

    @property
    def power(self) -> int:
        """Power of the strain in the force's leading nonlinear term: 2 for KdV, 3 for mKdV."""
        return 1 + 2 // self.order


FORMS = {
    "dn": EllipticForm(1, 1, 2, 1, 0, lambda square: (2 - square) / 2),
    "cn": EllipticForm(1, 1, 4, 2, 0, lambda square: (2 * square - 1) / 2),
    "sn": EllipticForm(1, -1, 4, 2, 0, lambda square: -(1 + square) / 2),
    "cnoidal": EllipticForm(2, 0, 2, 1, 1, lambda square: (2 * square - 1) / 3),
}
"""Forms of Y, by name."""


@dataclass(frozen=True)
class NearWave:
    """The elliptic wave eps^p Y of a force law, p = 1 for mKdV and 2 for KdV."""

    name: str
    k: fmpq
    eps: fmpq
    force: Force

    def __post_init__(self) -> None:
        if self.name not in FORMS or not 0 < self.k < 1 or not self.eps > 0:
            names = ", ".join(FORMS)
            raise CertificateError(
                f"near must have a form of {names}, 0 < k < 1 and eps > 0, "
                f"got {self.name[:20]}, k = {self.k}, eps = {self.eps}"
            )
        jet, sign = self.force.at_rest, self.form.sign
        if self.form.order == 2:
            if not (jet[1] > 0 and abs(jet[2]) > 0):
                raise CertificateError(
                    f"near {self.name} needs a force K2 r + K3 r^2 + ... with K2 > 0 and K3 != 0"
                )
        elif not (jet[1] > 0 and jet[2].is_zero() and jet[3] * sign > 0):
            raise CertificateError(
                f"near {self.name} needs a force K2 r + K4 r^3 with K2 > 0 and "
                f"K4 {'>' if sign > 0 else '<'} 0, without r^2"
            )

    @property
    def form(self) -> EllipticForm:
        """Form of Y."""
        return FORMS[self.name]

    @property
    def equation(self) -> str:
        """Name of the equation that Y solves."""
        return "KdV equation" if self.form.order == 2 else "modified KdV equation"

    @property
    def scaled(self) -> str:
        """The approximate strain in symbols: eps Y or eps^2 Y."""
        return "eps^2 Y" if self.form.order == 2 else "eps Y"

    @property
    def size(self) -> arb:
        """Factor eps^p of Y."""
        return arb(self.eps**self.form.order)

    @cached_property
    def quarter_period(self) -> arb:
        """Quarter period K(k)."""
        return acb(arb(self.k * self.k)).elliptic_k().real

    @cached_property
    def nome(self) -> arb:
        """Nome q = exp(-pi K(k')/K(k))."""
        complementary = acb(arb(1 - self.k * self.k)).elliptic_k().real
        return (-arb.pi() * complementary / self.quarter_period).exp()

    @cached_property
    def sigma(self) -> arb:
        """Speed sigma of Y: v^2 = K2 + sigma eps^2."""
        jet = self.force.at_rest
        unit = jet[1] if self.form.order == 2 else abs(jet[3])
        return unit * arb(self.form.speed(self.k * self.k))

    @property
    def period(self) -> arb:
        """Period P in cells."""
        jet = self.force.at_rest
        scale = arb(1) if self.form.order == 2 else (6 * abs(jet[3]) / jet[1]).sqrt()
        return self.form.quarters * self.quarter_period / (scale * arb(self.eps))

    def mode(self, j: int) -> arb:
        """Return the cosine mode f_j of eps^p Y."""
        if self.form.stride == 2 and j % 2 == 0:
            return arb(0)
        unit, q = arb.pi() / self.quarter_period, self.nome
        if self.form.order == 2:
            jet, square = self.force.at_rest, arb(self.k * self.k)
            if j:
                value = unit * unit * j * q**j / (1 - q ** (2 * j))
            else:
                value = acb(square).elliptic_e().real / self.quarter_period - 1 + square
            return jet[1] / (2 * jet[2]) * self.size * value
        unit *= self.size
        if self.name == "dn":
            return unit * q**j / (1 + q ** (2 * j)) if j else unit / 2
        root = q**j / (q**j).sqrt()
        if self.name == "cn":
            return unit * root / (1 + q**j)
        return (-1) ** ((j - 1) // 2) * unit * root / (1 - q**j)

    def modes(self, top: int) -> Series:
        """Return the cosine modes f_0 ... f_top of eps^p Y."""
        return [self.mode(j) for j in range(top + 1)]

    def rest(self, top: int, power: int = 0) -> arb:
        """Return a bound of the sum of 2 |f_j| (j/n)^power over j > top.

        n is the first j > top with a mode. The ratio of a mode to the one before is at most the
        nome q times (1 + stride/j)^growth. The bound is infinite if more modes are needed.
        """
        first = self.first_after(top)
        ratio = self.nome * (1 + arb(self.form.stride) / first) ** (power + self.form.growth)
        if not ratio < 1:
            return arb.pos_inf()
        return upper(2 * abs(self.mode(first)) * (1 + self.nome**first) / (1 - ratio))

    def first_after(self, top: int) -> int:
        """Return the index of the first nonzero mode after ``top``."""
        return top + 1 if self.form.stride == 1 or top % 2 == 0 else top + 2
