"""The exponential function and its inverses: exp, log and atan of sums and products."""

from __future__ import annotations

from .images import Images, integer_of
from .limits import CertificateError
from .principal import angle_of
from .ring import Element
from .stated import HALF_PI, StatedSigns


class Exponentials:
    """Images of exp, log and atan that follow from those of others."""

    def __init__(self, images: Images, stated: StatedSigns) -> None:
        self._images, self._stated = images, stated

    def exponential(self, z: int) -> Element:
        """exp(sum n u) = product of exp(u)**n, with exp(q log f) = f**q."""
        images = self._images
        result = images.one
        for coefficient, u in images.sum_of(images.nodes.made("exp", z)):
            inner = images.nodes.all[u]
            angle = angle_of(images, u)
            if inner[0] == "log":
                power = images.nodes.made("Pow", inner[1], coefficient)
                result = result * images.image(power)
            elif angle is not None and images.nodes.all[angle][0] == "atan":
                half = integer_of(coefficient / 2)
                result = result * self._phase(images.nodes.all[angle][1]) ** half
            else:
                result = result * images.made("exp", u) ** integer_of(coefficient)
        return result

    def _phase(self, f: int) -> Element:
        """exp(2 i atan f) = (1 + i f)/(1 - i f)."""
        images = self._images
        turned = images.image(images.nodes.made("I")) * images.image(f)
        return (images.one + turned) / (images.one - turned)

    def logarithm(self, node: int, inner: int) -> Element:
        """log of a product of powers of positive factors."""
        images = self._images
        if node not in images.hints.logs:
            raise CertificateError("there is no generator for a log")
        product, total = images.one, images.zero
        for q, factor in images.hints.logs[node]:
            # It is not 0 where the logarithm is smooth.
            if not images.signs.not_negative(factor):
                raise CertificateError("a factor in a logarithm is not shown to be positive")
            product = product * images.image(images.nodes.made("Pow", factor, q))
            part = images.nodes.all[factor]
            value = images.image(part[1]) if part[0] == "exp" else images.made("log", factor)
            total = total + images.ring.number(q) * value
        if product.is_zero or not (product - images.image(inner)).is_zero:
            raise CertificateError("a logarithm is not of the product that it is said to be of")
        return total

    def arctangent(self, node: int, inner: int) -> Element:
        """The number between -pi/2 and pi/2 with a given tangent."""
        images = self._images
        value = images.named(node)
        if not self._stated.is_between(value, -HALF_PI, HALF_PI):
            raise CertificateError("what an atan is said to be is not shown to be within pi/2 of 0")
        if not (images.made("tan", value) - images.image(inner)).is_zero:
            raise CertificateError("what an atan is said to be has another tangent")
        return images.image(value)
