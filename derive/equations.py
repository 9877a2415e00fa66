"""Equations of a reduction: orders in eps, conditions, the evolution equation, coefficients."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from sympy import Expr, S

from longwave.derive.algebra.formula_printing import Printed, latex_of, text_of
from longwave.derive.algebra.jets import DifferentialPolynomial, Monomial
from longwave.derive.normal_form import equation_of
from longwave.derive.output.notation import Displayed, Notation, derived, terms

_NAMES_BY_TERM = {
    **dict.fromkeys(("Y_XXX", "Y_5X"), "linear"),
    "Y Y_X": "Hopf, without dispersion",
    "Y^2 Y_X": "modified Hopf, without dispersion",
}
"""Text of a term -> name of the equation with that term only, besides Y_T and Y_X."""

_BURGERS_NAMES = {
    "unnamed": "unnamed",
    "Hopf, without dispersion": "Burgers",
    "modified Hopf, without dispersion": "modified Burgers",
}
"""Name of an equation without Y_XX -> its name with Y_XX; other names get the suffix "-Burgers"."""


@dataclass(frozen=True, repr=False)
class OrderEquation(Displayed):
    """Order ``eps^order`` of the lattice equation: ``polynomial = 0``.

    ``polynomial`` has the sign of "acceleration minus force", so that the orders add up to the
    lattice residual; text and LaTeX make the first term positive.
    """

    order: int
    polynomial: DifferentialPolynomial
    notation: Notation

    @property
    def _printed(self) -> DifferentialPolynomial:
        first = terms(self.polynomial)[:1]
        return -self.polynomial if first and first[0].negative else self.polynomial

    def written(self, printed: Printed) -> str:
        """Return the equation as text or LaTeX, such as ``2 c Y_XT + K4 (Y^3)_XX + ... = 0``."""
        return f"{self.notation.written(self._printed, printed)} = 0"


@dataclass(frozen=True, repr=False)
class Condition(Displayed):
    """``expression = 0``, a condition on the constants that the equation at ``order`` requires."""

    order: int
    expression: Expr
    equation: OrderEquation

    @property
    def reason(self) -> str:
        """The equation that requires the condition, in words."""
        return f"order eps^{self.order} reads {self.equation.text()}"

    def text(self) -> str:
        """Return condition and reason, such as ``K3 = 0: order eps^4 reads K3 (Y^2)_XX = 0``."""
        return f"{text_of(self.expression)} = 0: {self.reason}"

    def latex(self) -> str:
        """Return the condition alone in LaTeX."""
        return f"{latex_of(self.expression)} = 0"


@dataclass(frozen=True, repr=False)
class EvolutionEquation(Displayed):
    """The reduced equation ``Y_T = flow``; coefficients are those of ``Y_T - flow = 0``.

    With a ``transverse`` part B it is ``(Y_T - flow)_X + B = 0``.
    """

    flow: DifferentialPolynomial
    notation: Notation
    transverse: DifferentialPolynomial

    @property
    def polynomial(self) -> DifferentialPolynomial:
        """The polynomial ``Y_T - flow``."""
        jet = (0,) * (len(self.notation.axes) - 1)
        return DifferentialPolynomial.monomial(self.flow.field, ((*jet, 1),)) - self.flow

    @property
    def kind(self) -> str:
        """Name of the equation, by its terms: "KdV", "modified Kawahara", "KP-II".

        A KP equation is "KP-I or KP-II" if the symbols' assumptions do not determine the sign.
        """
        names = {self.notation.monomial(monomial) for monomial in self.flow.terms}
        kind = self._kind_without_losses(names - {"Y", "Y_XX"})
        if "Y_XX" in names:
            kind = _BURGERS_NAMES.get(kind, f"{kind}-Burgers")
        return f"damped {kind}" if "Y" in names else kind

    def _kind_without_losses(self, names: set[str]) -> str:
        if not self.transverse:
            equation = equation_of(names)
            terms_text = ", ".join(names - {"Y_X"})
            return equation.name if equation else _NAMES_BY_TERM.get(terms_text, "unnamed")
        [(monomial, coefficient)] = self.transverse.terms.items()
        if names - {"Y_XXX"} not in ({"Y Y_X"}, {"Y^2 Y_X"}) or sum(monomial[0]) != 2:
            return "unnamed"
        name = "KP" if "Y Y_X" in names else "generalised KP"
        product = (coefficient.as_expr() * self.dispersive_coefficient).factor()
        if product.is_zero:
            return f"{name} without dispersion"
        sign = {True: "II", False: "I"}.get(product.is_positive)
        return f"{name}-{sign}" if sign else f"{name}-I or {name}-II"

    @property
    def nonlinear_coefficient(self) -> Expr:
        """The coefficient of the nonlinear term (of Y^2 Y_X for mKdV).

        Raises ValueError unless there is exactly one nonlinear term.
        """
        nonlinear = [monomial for monomial in self.flow.terms if len(monomial) > 1]
        if len(nonlinear) != 1:
            raise ValueError(
                f"the equation must have one nonlinear term, got {len(nonlinear)} "
                f"in {self.text()} (read the terms from .polynomial)"
            )
        return self.polynomial.coefficient(*nonlinear[0]).as_expr()

    @property
    def dispersive_coefficient(self) -> Expr:
        """The coefficient of Y_XXX."""
        jet = (3, *(0,) * (len(self.notation.axes) - 1))
        return self.polynomial.coefficient(jet).as_expr()

    def written(self, printed: Printed) -> str:
        """Return the equation, such as ``Y_T + 6 Y Y_X + Y_XXX = 0``, with loss terms last."""
        losses = self.polynomial.select(lambda m: len(m) == 1 and sum(m[0]) % 2 == 0)
        left_side = self.notation.written(self.polynomial - losses, printed)
        if losses:
            left_side = _sum_of(left_side, self.notation.written(losses, printed))
        if self.transverse:
            outer = derived(left_side, self.notation.axes[0], printed)
            left_side = _sum_of(outer, self.notation.written(self.transverse, printed))
        return f"{left_side} = 0"


def _sum_of(left: str, right: str) -> str:
    return f"{left} {'-' if right.startswith('-') else '+'} {right.removeprefix('-')}"


@dataclass(frozen=True)
class Coefficients:
    """Frame speed (negative for waves to the left) and the reduced equation's coefficients.

    ``terms`` maps the text of each term of ``Y_T + ... = 0`` to its coefficient.
    """

    c: Expr
    terms: Mapping[str, Expr]
    monomials: Mapping[str, Monomial] = field(repr=False)

    @property
    def nonlinear(self) -> Expr:
        """The nonlinear term's coefficient. Raises ValueError unless there is exactly one."""
        nonlinear = [name for name, monomial in self.monomials.items() if len(monomial) > 1]
        if len(nonlinear) != 1:
            raise ValueError(
                f"the equation must have one nonlinear term, got {len(nonlinear)} in "
                f"{', '.join(self.terms)} (read the coefficients from .terms)"
            )
        return self.terms[nonlinear[0]]

    @property
    def dispersive(self) -> Expr:
        """The coefficient of Y_XXX, 0 if the equation has no such term."""
        return self.terms.get("Y_XXX", S.Zero)
