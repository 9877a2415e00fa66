"""Polynomials over the Gaussian rationals, as pairs of python-flint polynomials."""

from dataclasses import dataclass

from flint import fmpq, fmpq_mpoly

__all__ = ["GaussianPolynomial"]


@dataclass(frozen=True)
class GaussianPolynomial:
    """``re + i im`` with real polynomial parts."""

    re: fmpq_mpoly
    im: fmpq_mpoly

    def __add__(self, other: "GaussianPolynomial") -> "GaussianPolynomial":
        return GaussianPolynomial(self.re + other.re, self.im + other.im)

    def __mul__(self, other: "GaussianPolynomial") -> "GaussianPolynomial":
        return GaussianPolynomial(
            self.re * other.re - self.im * other.im, self.re * other.im + self.im * other.re
        )

    def scaled(self, factor: fmpq) -> "GaussianPolynomial":
        """The product with a rational number."""
        return GaussianPolynomial(self.re * factor, self.im * factor)
