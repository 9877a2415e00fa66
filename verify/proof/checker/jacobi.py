"""Jacobi functions: values by the addition theorems, derivatives, and what m must be."""

from __future__ import annotations

from flint import fmpq

from . import axioms
from .axioms import Station
from .images import Images, integer_of
from .limits import CertificateError
from .ring import Element
from .signs import BELOW_ONE


class Jacobi:
    """Images of Jacobi functions that follow from those of others."""

    def __init__(self, images: Images) -> None:
        self._images = images
        self._stations: dict[tuple[int, int, str], Station] = {}

    def need_parameter(self, name: str, m: int) -> None:
        """Elliptic functions have a constant parameter; K and what is made with it, one below 1."""
        images = self._images
        if images.moves(m):
            raise CertificateError("the parameter m of an elliptic function must be constant")
        if name in BELOW_ONE and not images.signs.below_one(m):
            raise CertificateError(f"{name} needs m < 1, which is not shown on the domain")
        if name in ("jacobi_theta", "jacobi_eta") and not images.signs.positive(m):
            raise CertificateError(f"{name} needs m > 0, which is not shown on the domain")

    def value(self, name: str, z: int, m: int) -> Element:
        """The image of a Jacobi function, by the addition theorems."""
        images = self._images
        self.need_parameter(f"jacobi_{name}", m)
        if name == "theta":
            return self._theta(z, m)
        if name == "eta":
            root = images.image(images.nodes.made("Pow", m, fmpq(1, 4)))
            return root * images.made("jacobi_sn", z, m) * images.made("jacobi_theta", z, m)
        if name == "zeta" and not images.atoms("jacobi_zeta"):
            mean = images.made("elliptic_e", m) / images.made("elliptic_k", m)
            return images.made("jacobi_epsilon", z, m) - images.image(z) * mean
        station = self._station(z, m, name if name in ("epsilon", "zeta") else "")
        if name in ("epsilon", "zeta"):
            if station.second is None:
                return images.zero
            return station.second
        found: Element = getattr(station, name)
        return found

    def slope(self, name: str, image: Element, z: int, m: int) -> Element:
        """The derivative in z of a Jacobi function with this image."""
        images = self._images
        if name == "theta":
            return image * images.made("jacobi_zeta", z, m)
        if name in ("epsilon", "zeta"):
            square = images.made("jacobi_dn", z, m) ** 2
            if name == "epsilon":
                return square
            return square - images.made("elliptic_e", m) / images.made("elliptic_k", m)
        sign, with_m, functions = axioms.PRODUCTS[name]
        parts = [images.made(f"jacobi_{function}", z, m) for function in functions]
        result = images.ring.number(sign) * parts[0] * parts[1]
        return result * images.image(m) if with_m else result

    def _station(self, z: int, m: int, second: str) -> Station:
        images = self._images
        if (z, m, second) not in self._stations:
            found = images.sum_of(images.nodes.made("jacobi_sn", z, m))
            parts = [(integer_of(n), u) for n, u in found]
            total: Station | None = None
            for n, u in parts:
                if n:
                    step = self._base(u, m, second).times(n)
                    total = step if total is None else total + step
            if total is None:
                zero, one = images.zero, images.one
                total = Station(images.image(m), zero, one, one, zero)
            self._stations[z, m, second] = total
        return self._stations[z, m, second]

    def _base(self, u: int, m: int, second: str) -> Station:
        """A generator's argument, or K, or again a sum."""
        images = self._images
        made, parameter = images.nodes.made, images.image(m)
        if images.nodes.all[u] == ("elliptic_k", m):
            negative = made("Mul", images.nodes.rational(-1), m)
            rest = made("Add", images.nodes.rational(1), negative)
            dn = images.image(made("Pow", rest, fmpq(1, 2)))
            value = images.made("elliptic_e", m) if second == "epsilon" else images.zero
            return Station(parameter, images.one, images.zero, dn, value)
        names = [f"jacobi_{name}" for name in ("sn", "cn", "dn", second) if name]
        return Station(parameter, *(images.made(name, u, m) for name in names))

    def _theta(self, z: int, m: int) -> Element:
        """Theta is even; Theta(u-d) by the product theorem."""
        images = self._images
        for atom in images.atoms("jacobi_theta"):
            _, other, parameter = images.nodes.all[atom]
            if images.equal(m, parameter) and (images.image(z) + images.image(other)).is_zero:
                return images.image(atom)
        match images.sum_of(images.nodes.made("jacobi_theta", z, m)):
            case ((plus, u), (minus, d)) if plus == 1 and minus == -1:
                arguments = (images.nodes.made("Add", u, d), u, d, images.nodes.rational(0))
            case _:
                raise CertificateError("theta's argument must be a difference of two")
        ahead, here, shift, zero = (images.made("jacobi_theta", a, m) for a in arguments)
        sines = (images.made("jacobi_sn", u, m), images.made("jacobi_sn", d, m))
        return axioms.behind(images.image(m), (ahead, here, shift, zero), sines)
