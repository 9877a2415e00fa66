r"""Elliptic waves of the modified KdV equation as cosine series: period and modes by the nome.

On the chain V'(r) = K2 r + K4 r^3 + O(r^4), eps Y has with a^2 = 6 |K4|/K2, K = K(k), q the nome:

    dn  P = 2K/(a eps)   f_0 = pi eps/(2K)   f_j = (pi eps/K) q^j/(1 + q^(2j))
    cn  P = 4K/(a eps)   odd j:  f_j = (pi eps/K) q^(j/2)/(1 + q^j)               of k cn
    sn  P = 4K/(a eps)   odd j:  f_j = (-1)^((j-1)/2) (pi eps/K) q^(j/2)/(1 - q^j)  of k sn(x + K)
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from flint import acb, arb, fmpq

from .cosine_series import Series, upper
from .force_text import Force
from .limits import CertificateError

FORMS = {"dn": 1, "cn": 1, "sn": -1}
"""Forms of the wave, each with the sign of K4 that it needs."""


@dataclass(frozen=True)
class NearWave:
    """The elliptic wave eps Y of a force law."""

    form: str
    k: fmpq
    eps: fmpq
    force: Force

    def __post_init__(self) -> None:
        if self.form not in FORMS or not 0 < self.k < 1 or not self.eps > 0:
            raise CertificateError("near must have form dn, cn or sn, 0 < k < 1 and eps > 0")
        jet = self.force.at_rest
        if not (jet[1] > 0 and jet[2].is_zero() and jet[3] * FORMS[self.form] > 0):
            raise CertificateError(
                f"near {self.form} needs a force K2 r + K4 r^3 with K2 > 0 and "
                f"K4 {'>' if FORMS[self.form] > 0 else '<'} 0, without r^2"
            )

    @cached_property
    def quarter_period(self) -> arb:
        """Quarter period K(k)."""
        return acb(arb(self.k * self.k)).elliptic_k().real

    @cached_property
    def nome(self) -> arb:
        """Nome q = exp(-pi K(k')/K(k))."""
        complementary = acb(arb(1 - self.k * self.k)).elliptic_k().real
        return (-arb.pi() * complementary / self.quarter_period).exp()

    @property
    def period(self) -> arb:
        """Period P in cells."""
        jet = self.force.at_rest
        scale = (6 * abs(jet[3]) / jet[1]).sqrt() * arb(self.eps)
        return (2 if self.form == "dn" else 4) * self.quarter_period / scale

    def mode(self, j: int) -> arb:
        """Return the cosine mode f_j of eps Y."""
        unit, q = arb.pi() * arb(self.eps) / self.quarter_period, self.nome
        if self.form == "dn":
            return unit * q**j / (1 + q ** (2 * j)) if j else unit / 2
        if j % 2 == 0:
            return arb(0)
        root = q**j / (q**j).sqrt()
        if self.form == "cn":
            return unit * root / (1 + q**j)
        return (-1) ** ((j - 1) // 2) * unit * root / (1 - q**j)

    def modes(self, top: int) -> Series:
        """Return the cosine modes f_0 ... f_top of eps Y."""
        return [self.mode(j) for j in range(top + 1)]

    def rest(self, top: int) -> arb:
        """Return a bound of the sum of 2 |f_j| over j > top."""
        first = top + 1 if self.form == "dn" or top % 2 == 0 else top + 2
        return upper(2 * abs(self.mode(first)) * (1 + self.nome**first) / (1 - self.nome))
