"""The result of a reduction: every order's equation, the reduced equation, its coefficients."""

import json
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
from longwave.derive.output import report
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

_SOLITON_POWERS = {"KdV": 1, "mKdV": 2}
"""Power of Y before Y_X, for equations whose solitons have an amplitude law."""

_LOSS_TERMS = ("Y", "Y_XX")
"""Terms that come from losses."""


@dataclass(frozen=True, repr=False)
class Reduction:
    """Result of `reduce`: the reduced equation and all orders of the expansion that lead to it.

    ``orders``: the lattice equation order by order, before any condition is used (orders that
    vanish identically are omitted).  ``sound_polynomial``: P(c), zero at the sound speed.
    ``conditions``: required of the constants, each with its order.  ``pde``: the reduced equation.
    ``remainders``: order -> residual of the lattice equation for an exact solution of ``pde``.
    ``corrections``: power p -> G_p of ``Y_T = G_0 + sum eps^p G_p``.  ``obstruction``: the first
    (power, polynomial) that is not an X-derivative, where the one-way reduction ends, or None.
    With a transverse term no corrections and remainders are computed.  ``slaved``: field -> its
    weight e in the wave and the series added to ``eps^p e W``, in jets of the wave.  ``left``:
    weights of the rows of the equations of motion.  Constants that ``sound_condition`` and
    ``conditions`` determine are eliminated from ``pde``, remainders, corrections and obstruction.
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

    def __repr__(self) -> str:
        needed = "".join(f", {text_of(item.expression)} = 0" for item in self.conditions)
        squared = f"{text_of(self.scaling.speed**2)} = {text_of(self.speed_squared)}"
        return f"Reduction({self.lattice.name}: {self.pde.text()}, {squared}{needed})"

    def _repr_latex_(self) -> str:
        parts = [self.pde.latex(), latex_of(self.sound_condition)]
        joined = r",\quad ".join([*parts, *(item.latex() for item in self.conditions)])
        return rf"$\displaystyle {joined}$"

    def text(self) -> str:
        """Return the whole reduction in plain text."""
        return "\n".join(report.text_lines(self))

    def latex(self, **constants: Number) -> str:
        """Return orders, conditions, reduced equation and coefficients as one ``aligned`` block.

        The coefficients are those at ``constants``. Raises ValueError as coefficients does.
        """
        return report.latex_report(self, constants)

    def json(self, **constants: Number) -> str:
        """Return the reduction as a JSON document (layout: derive.output.report).

        The coefficients are those at ``constants``. Raises ValueError as coefficients does.
        """
        return json.dumps(report.reduction_data(self, constants), indent=2)

    @property
    def notation(self) -> Notation:
        """Names of the unknown and the axes."""
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
        """The unknown of the orders: Y, or W for displacements."""
        return next((equation.notation.unknown for equation in self.orders.values()), "Y")

    @property
    def idle_losses(self) -> tuple[str, ...]:
        """Messages on losses without a term in the reduced equation, one for each kind of loss."""
        derivative_counts = {sum(m[0]) for m in self.pde.flow.terms if len(m) == 1}
        return tuple(
            idle_loss(kind, value)
            for kind, (value, _) in self.lattice.leading_losses.items()
            if {"site": 0, "bond": 2}[kind] not in derivative_counts
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
        """Return the values, with the frame's symbol as the positive root of c^2."""
        return {**values, self.scaling.frame_symbol: sqrt(self.speed_squared.xreplace(values))}

    def values(self, constants: Mapping[str, Number]) -> dict[Symbol, Expr]:
        """Return the value of every symbol in the coefficients, including the frame's speed.

        Raises ValueError as coefficients does.
        """
        return self._at(self._checked(constants))

    def coefficients(self, **constants: Number) -> Coefficients:
        """Return speed and coefficients in the lattice's constants, or at given values of them.

        Raises ValueError for an unknown name, c^2 <= 0 or constants that violate a condition, the
        assumptions of their symbols, or a nonzero denominator.

        >>> from longwave.derive import LATTICES, reduce
        >>> reduce(LATTICES["fput_strain"]).coefficients(K2=4, K4=1)
        Coefficients(c=2, terms={'Y^2 Y_X': 3/4, 'Y_XXX': 1/12})
        """
        symbol_values = self.values(constants)
        flow = sorted(self.pde.flow.terms.items(), key=lambda item: (-len(item[0]), item[0]))
        terms = [*((m, -value) for m, value in flow), *self.pde.transverse.terms.items()]
        monomials = {self.notation.monomial(monomial): monomial for monomial, _ in terms}
        values = [joined_powers(v.factored().xreplace(symbol_values)) for _, v in terms]
        speed = joined_powers(self.scaling.speed.xreplace(symbol_values))
        return Coefficients(speed, dict(zip(monomials, values, strict=True)), monomials)

    def normal_form(self, **constants: Number) -> NormalForm:
        """Return the map to the normal form of the equation; arguments as for coefficients.

        Raises ValueError if the equation is not in `NORMAL_EQUATIONS`.

        >>> from longwave.derive import LATTICES, reduce
        >>> reduce(LATTICES["fput_strain"]).normal_form(K2=6, K4=-1)
        NormalForm(a=1, b=sqrt(6)/24, s=-1, c=sqrt(6))
        """
        values = self.coefficients(**constants)
        return normal_form_of(values.c, self._named(values))

    def lossless_form(self, **constants: Number) -> NormalForm:
        """Return the normal form of the equation without the terms of losses."""
        values = self.coefficients(**constants)
        terms = self._named(values).items()
        return normal_form_of(values.c, {n: v for n, v in terms if n not in _LOSS_TERMS})

    def amplitude_law(self, **constants: Number) -> AmplitudeLaw | None:
        """Return the decay of a soliton by the losses; arguments as for coefficients.

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
        if equation is None or equation.name not in _SOLITON_POWERS or not (damping or diffusion):
            return None
        power = _SOLITON_POWERS[equation.name]
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
        """Return the coefficients by the names of terms in normal forms."""
        return {self._term(monomial): values.terms[n] for n, monomial in values.monomials.items()}

    def _term(self, monomial: Monomial) -> str:
        """Return a term's name in normal forms."""
        return Notation(("X", *"ZVW"[: len(self.notation.axes) - 2], "T")).monomial(monomial)

    def _checked(self, constants: Mapping[str, Number]) -> dict[Symbol, Expr]:
        symbols = {*self.lattice.basic_constants, *self.scaling.constants}
        names = {str(s): s for s in sorted(symbols - {self.scaling.frame_symbol}, key=str)}
        values = values_of(constants, names, self.lattice.name)
        self.lattice.check_values(values)
        values = self.lattice.with_defined(values)
        self._check_denominators(values)
        self._check_speed(values)
        for condition in self.conditions:
            remainder = expand(condition.expression.xreplace(self._at(values)))
            if remainder.is_number and not remainder.equals(0):
                vanishing = text_of(condition.expression)
                raise ValueError(
                    f"constants must satisfy {vanishing} = 0, got {vanishing} = {remainder} "
                    f"({condition.reason}; take constants that meet it or are small, such as "
                    "5*eps, a background, or another amplitude)"
                )
        return values

    def _check_denominators(self, values: Mapping[Symbol, Expr]) -> None:
        """Raise ValueError for values that make the speed or a coefficient infinite."""
        elements = (self.sound_polynomial, *self.pde.flow.terms.values())
        for divisor_factor in {f for element in elements for f in element.factors(below=True)}:
            divisor = divisor_factor.as_expr()
            if divisor.xreplace(values).is_zero:
                raise ValueError(
                    f"constants must satisfy {text_of(divisor)} != 0, got 0 (the reduction divides "
                    "by it; take other constants or another background)"
                )

    def _check_speed(self, values: Mapping[Symbol, Expr]) -> None:
        squared = self.speed_squared.xreplace(values)
        if squared.is_positive is False:
            formula = "" if self.speed_squared == squared else f"{text_of(self.speed_squared)}, "
            raise ValueError(
                f"stiffness must be positive: {formula}the square of the sound speed, must be > 0, "
                f"got {squared} (a stretched spring pulls back: K*x with K > 0)"
            )

    def latex_correction(self, power: int) -> str:
        """Return ``G_{power}`` of ``Y_T = G_0 + ...`` in LaTeX; KeyError if it was not derived."""
        correction = self.notation.latex(self.corrections[power])
        return f"{self.label('G', power, latex_of)} = {correction}"

    def latex_remainder(self, order: int) -> str:
        """Return the residual of a solution of the reduced equation at ``eps^order``, in LaTeX."""
        return f"{self.label('R', order, latex_of)} = {self.notation.latex(self.remainders[order])}"

    def label(self, letter: str, number: int, printed: Printed = text_of) -> str:
        """Return the name of a remainder R5 or correction G2."""
        return printed(Symbol(unused(f"{letter}{number}", self.lattice.names)))
