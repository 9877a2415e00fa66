"""The reduced equation of a lattice, with every order's equation, its numbers and corrections."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from sympy import Eq, Expr, S, Symbol, expand, factor, sqrt

from longwave.derive.algebra.exact_numbers import Number
from longwave.derive.algebra.jets import DifferentialPolynomial, EpsSeries, Monomial
from longwave.derive.algebra.rational_functions import RationalFunction
from longwave.derive.amplitude_law import AmplitudeLaw, amplitude_law
from longwave.derive.equations import Coefficients, Condition, EvolutionEquation, OrderEquation
from longwave.derive.lattice import Lattice
from longwave.derive.normal_form import NormalForm, equation_of, normal_form_of
from longwave.derive.output.notation import (
    Notation,
    Printed,
    idle_loss,
    latex_of,
    power_of,
    text_of,
)
from longwave.derive.output.own_names import joined_powers, unused
from longwave.derive.scaling import Scaling
from longwave.derive.symbols import eps, values_of

_POWERS = {"KdV": 1, "mKdV": 2}
"""The power of Y before Y_X, of equations whose solitons have an amplitude law."""

_LOST = ("Y", "Y_XX")
"""Terms of losses."""


@dataclass(frozen=True, repr=False)
class ReducedEquation:
    """The reduced equation of a lattice, and every order of the expansion that leads to it.

    ``orders``: the lattice equation order by order, before any condition is used (orders that
    vanish identically are absent).  ``sound_polynomial``: P(c), zero at the sound speed.
    ``conditions``: what the constants must satisfy, with the order that asks for it.  ``pde``:
    the reduced equation.  ``remainders``: order -> what an exact solution of ``pde`` leaves in the
    lattice equation.  ``corrections``: power p -> G_p of ``Y_T = G_0 + sum eps^p G_p``.
    ``obstruction``: the first (power, polynomial) that is no X-derivative, where the one-way
    reduction ends, or None if no such order was reached.  With a transverse term no corrections
    and remainders are sought.  ``slaved``: field -> its share e of the wave and the series that is
    added to ``eps^p e W``, in jets of the wave.  ``left``: what the rows of the equations of motion
    are weighted with.  Constants that ``sound_condition`` and
    ``conditions`` fix are eliminated from ``pde``, remainders, corrections and obstruction.
    """

    lattice: Lattice
    scaling: Scaling
    highest_order: int
    orders: Mapping[int, OrderEquation]
    sound_polynomial: RationalFunction
    conditions: tuple[Condition, ...]
    pde: EvolutionEquation
    remainders: Mapping[int, DifferentialPolynomial]
    corrections: Mapping[int, DifferentialPolynomial]
    obstruction: tuple[int, DifferentialPolynomial] | None
    slaved: Mapping[str, tuple[RationalFunction, EpsSeries]]
    left: tuple[RationalFunction, ...]

    @property
    def notation(self) -> Notation:
        """The names of unknown and axes."""
        return self.pde.notation

    @property
    def speed_squared(self) -> Expr:
        """c^2 in the lattice's constants, from the sound condition."""
        polynomial, speed = self.sound_polynomial.numerator(), self.scaling.frame_symbol
        value = polynomial.solved_for(speed, 2)
        if value is None:
            raise ValueError(
                f"the sound condition must be linear in the square of the speed, got "
                f"{text_of(polynomial.as_expr())} = 0 (solve it by hand)"
            )
        squared = value.as_expr()
        return squared.expand() if value.is_polynomial else factor(squared)

    @property
    def is_balanced(self) -> bool:
        """Whether the reduced equation has a nonlinear and a dispersive term."""
        degrees = {len(monomial) for monomial in self.pde.flow.terms}
        dispersive = any(len(m) == 1 and m[0][0] > 1 for m in self.pde.flow.terms)
        return dispersive and max(degrees, default=0) > 1

    @property
    def is_displacement(self) -> bool:
        """Whether the lattice's fields are displacements: the wave is W, and Y = W_X."""
        return self.wave != "Y"

    @property
    def wave(self) -> str:
        """The unknown of the orders: Y, or W of displacements."""
        return next((equation.notation.unknown for equation in self.orders.values()), "Y")

    @property
    def idle_losses(self) -> tuple[str, ...]:
        """The losses without a term in the reduced equation, a line for each kind."""
        entered = {sum(monomial[0]) for monomial in self.pde.flow.terms if len(monomial) == 1}
        return tuple(
            idle_loss(kind, value)
            for kind, (value, _) in self.lattice.leading_losses.items()
            if {"site": 0, "bond": 2}[kind] not in entered
        )

    @property
    def units(self) -> str:
        """The meaning of Y, in words."""
        scaling, names = self.scaling, list(self.lattice.fields)
        size = power_of(eps, scaling.amplitude, text_of)
        if not self.is_displacement:
            return f"Y: {names[0]} less its mean is {size}Y, at first order"
        strain = power_of(eps, scaling.amplitude + scaling.space[0].exponent, text_of)
        moved = f"Y = {self.wave}_X: {names[0]} is {size}{self.wave}"
        return f"{moved}, the strain of a cell {strain}Y, at first order"

    @property
    def sound_condition(self) -> Eq:
        """``c^2 = K2``, from the lowest order."""
        return Eq(self.scaling.speed**2, self.speed_squared, evaluate=False)

    def _at(self, values: Mapping[Symbol, Expr]) -> dict[Symbol, Expr]:
        """The values, and the frame's symbol as the positive root of c^2 there."""
        return {**values, self.scaling.frame_symbol: sqrt(self.speed_squared.xreplace(values))}

    def values(self, constants: Mapping[str, Number]) -> dict[Symbol, Expr]:
        """The value of every symbol that coefficients have, the frame's speed among them.

        Raises ValueError as coefficients does.
        """
        return self._at(self._checked(constants))

    def coefficients(self, **constants: Number) -> Coefficients:
        """Speed and coefficients in the lattice's constants, or at given values of them.

        Raises ValueError for an unknown name, c^2 <= 0 or constants that violate a condition, what
        their symbols are declared to be, or a denominator.

        >>> from longwave.derive import LATTICES, reduce
        >>> reduce(LATTICES["fput_strain"]).coefficients(K2=4, K4=1)
        Coefficients(c=2, terms={'Y^2 Y_X': 3/4, 'Y_XXX': 1/12})
        """
        at = self.values(constants)
        flow = sorted(self.pde.flow.terms.items(), key=lambda item: (-len(item[0]), item[0]))
        terms = [*((m, -value) for m, value in flow), *self.pde.transverse.terms.items()]
        found = [
            (
                self.notation.monomial(monomial),
                monomial,
                joined_powers(value.factored().xreplace(at)),
            )
            for monomial, value in terms
        ]
        return Coefficients(
            joined_powers(self.scaling.speed.xreplace(at)),
            {name: value for name, _, value in found},
            {name: monomial for name, monomial, _ in found},
        )

    def normal_form(self, **constants: Number) -> NormalForm:
        """The map to the normal form of the equation; arguments as for coefficients.

        Raises ValueError for an equation that is none of `NORMAL_EQUATIONS`.

        >>> from longwave.derive import LATTICES, reduce
        >>> reduce(LATTICES["fput_strain"]).normal_form(K2=6, K4=-1)
        NormalForm(a=1, b=sqrt(6)/24, s=-1, c=sqrt(6))
        """
        values = self.coefficients(**constants)
        return normal_form_of(values.c, self._named(values))

    def lossless_form(self, **constants: Number) -> NormalForm:
        """The same of the equation without the terms of losses."""
        values = self.coefficients(**constants)
        terms = {name: value for name, value in self._named(values).items() if name not in _LOST}
        return normal_form_of(values.c, terms)

    def amplitude_law(self, **constants: Number) -> AmplitudeLaw | None:
        """The decay of a soliton by the losses; arguments as for coefficients.

        None unless the equation is KdV or mKdV with losses, and has bright solitons.

        >>> from longwave.derive import LATTICES, reduce
        >>> damped = LATTICES["fput_strain"].with_losses(site="eps^3*gamma")
        >>> reduce(damped).amplitude_law()
        AmplitudeLaw(a'(T) = -a(T) gamma, a(T) = a(0) exp(-T gamma))
        """
        values = self.coefficients(**constants)
        terms = self._named(values)
        damping, diffusion = terms.pop("Y", S.Zero), -terms.pop("Y_XX", S.Zero)
        equation = equation_of(terms)
        if equation is None or equation.name not in _POWERS or not (damping or diffusion):
            return None
        power = _POWERS[equation.name]
        nonlinear, third = (terms[name] for name in equation.terms)
        sign = nonlinear * third
        if sign.is_zero or (power == 2 and sign.is_negative):
            return None
        ratio = 2 * nonlinear / ((power + 1) * (power + 2) * third)
        return amplitude_law(power, ratio, damping, diffusion)

    @property
    def has_normal_form(self) -> bool:
        """Whether the equation is one of `NORMAL_EQUATIONS`, by its terms."""
        monomials = (*self.pde.flow.terms, *self.pde.transverse.terms)
        return equation_of(map(self._term, monomials)) is not None

    def _named(self, values: Coefficients) -> dict[str, Expr]:
        """The coefficients under the names of terms in normal forms."""
        return {self._term(monomial): values.terms[n] for n, monomial in values.monomials.items()}

    def _term(self, monomial: Monomial) -> str:
        """A term's name in normal forms."""
        return Notation(("X", *"ZVW"[: len(self.notation.axes) - 2], "T")).monomial(monomial)

    def _checked(self, constants: Mapping[str, Number]) -> dict[Symbol, Expr]:
        own = (s for s in self.scaling.constants if s != self.scaling.frame_symbol)
        names = {str(s): s for s in sorted({*self.lattice.basic_constants, *own}, key=str)}
        values = values_of(constants, names, self.lattice.name)
        self.lattice.check_values(values)
        values = self.lattice.with_defined(values)
        self._check_denominators(values)
        self._check_speed(values)
        for condition in self.conditions:
            left = expand(condition.expression.xreplace(self._at(values)))
            if left.is_number and not left.equals(0):
                raise ValueError(
                    f"constants must satisfy {text_of(condition.expression)} = 0, got "
                    f"{text_of(condition.expression)} = {left} ({condition.reason}; take constants "
                    "that meet it or are small, such as 5*eps, a background, or another amplitude)"
                )
        return values

    def _check_denominators(self, values: Mapping[Symbol, Expr]) -> None:
        """Refuse what makes the speed or a coefficient infinite; the speed itself is no zero."""
        elements = (self.sound_polynomial, *self.pde.flow.terms.values())
        for part in {f for element in elements for f in element.factors(below=True)}:
            below = part.as_expr()
            if below.xreplace(values).is_zero:
                raise ValueError(
                    f"constants must satisfy {text_of(below)} != 0, got 0 (the reduction divides "
                    "by it; take other constants or another background)"
                )

    def _check_speed(self, values: Mapping[Symbol, Expr]) -> None:
        squared = self.speed_squared.xreplace(values)
        if squared.is_positive is False:
            told = "" if self.speed_squared == squared else f"{text_of(self.speed_squared)}, "
            raise ValueError(
                f"stiffness must be positive: {told}the square of the sound speed, must be > 0, "
                f"got {squared} (a spring that is stretched pulls back: K*x with K > 0)"
            )

    def latex_correction(self, power: int) -> str:
        """``G_{power}`` of ``Y_T = G_0 + ...`` in LaTeX; KeyError if it was not reached."""
        return (
            f"{self.label('G', power, latex_of)} = {self.notation.latex(self.corrections[power])}"
        )

    def latex_remainder(self, order: int) -> str:
        """The remainder of a solution of the reduced equation at ``eps^order``, in LaTeX."""
        return f"{self.label('R', order, latex_of)} = {self.notation.latex(self.remainders[order])}"

    def label(self, letter: str, number: int, printed: Printed = text_of) -> str:
        """The name of a remainder R5 or correction G2."""
        return printed(Symbol(unused(f"{letter}{number}", self.lattice.names)))
