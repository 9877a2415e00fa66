"""The result of a reduction: every order's equation, the reduced equation, its coefficients."""

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial

from sympy import Eq, Expr, S, Symbol, expand, factor, sqrt

from longwave.derive.algebra.exact_numbers import Number
from longwave.derive.algebra.formula_printing import Printed, latex_of, text_of
from longwave.derive.algebra.jets import DifferentialPolynomial, EpsSeries, Monomial
from longwave.derive.algebra.rational_functions import RationalFunction
from longwave.derive.amplitude_law import AmplitudeLaw, amplitude_law
from longwave.derive.equations import Coefficients, Condition, EvolutionEquation, OrderEquation
from longwave.derive.lattice import Lattice
from longwave.derive.normal_form import NORMAL_EQUATIONS, NormalForm, equation_of, normal_form_of
from longwave.derive.output.notation import Notation, aligned, idle_loss, power_of
from longwave.derive.output.own_names import joined_powers, marked, unused
from longwave.derive.output.report import Data, form_data, head_lines, polynomial_data
from longwave.derive.scaling import Scaling
from longwave.derive.symbols import eps, values_of

_SOLITON_POWERS = {"KdV": 1, "mKdV": 2}
"""Equation whose solitons have an amplitude law -> power of Y in its term ``Y^r Y_X``."""

_LOSS_TERMS = ("Y", "Y_XX")
"""Terms of reduced equations that only losses produce."""


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
        return "\n".join(text_lines(self))

    def latex(self, **constants: Number) -> str:
        """Return orders, conditions, reduced equation and coefficients as one ``aligned`` block.

        The coefficients are those at ``constants``. Raises ValueError as coefficients does.
        """
        return latex_report(self, constants)

    def json(self, **constants: Number) -> str:
        """Return the reduction as a JSON document (layout: derive.output.report).

        The coefficients are those at ``constants``. Raises ValueError as coefficients does.
        """
        return json.dumps(reduction_data(self, constants), indent=2)

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
        """Name of the unknown in `orders`: Y, or W for displacements."""
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
        power = power_of(eps, scaling.amplitude, text_of)
        if not self.is_displacement:
            return f"Y: {names[0]} less its mean is {power}Y, at first order"
        strain = power_of(eps, scaling.amplitude + scaling.space[0].exponent, text_of)
        moved = f"Y = {self.wave}_X: {names[0]} is {power}{self.wave}"
        return f"{moved}, the strain of a cell {strain}Y, at first order"

    @property
    def sound_condition(self) -> Eq:
        """Equation for the sound speed from the lowest order, such as ``c^2 = K2``."""
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

        Raises ValueError for an unknown name, c^2 <= 0, a denominator that is 0, or constants that
        violate a condition or the assumptions of their symbols.

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
        """Return the normal form of the equation without the terms from losses."""
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
        """Return the coefficients ``values`` by the names of their terms in `NORMAL_EQUATIONS`."""
        return {self._term(monomial): values.terms[n] for n, monomial in values.monomials.items()}

    def _term(self, monomial: Monomial) -> str:
        """Return a monomial's name as in the terms of `NORMAL_EQUATIONS`, such as ``Y Y_X``."""
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
        """Return in LaTeX the lattice's residual at ``eps^order`` for exact solutions of `pde`."""
        return f"{self.label('R', order, latex_of)} = {self.notation.latex(self.remainders[order])}"

    def label(self, letter: str, number: int, printed: Printed = text_of) -> str:
        """Return the printed name of a remainder or correction, such as R5 or G2."""
        return printed(Symbol(unused(f"{letter}{number}", self.lattice.names)))


def text_lines(reduction: Reduction) -> Iterator[str]:
    """Yield ansatz, orders, conditions, reduced equation and corrections as lines of text."""
    yield from head_lines(reduction.lattice)
    yield f"ansatz: {reduction.scaling.text(reduction.lattice.fields[0], reduction.wave)}"
    yield from (f"  {line}" for line in _slaved_lines(reduction))
    if reduction.is_displacement:
        yield f"  {reduction.units}"
    yield ""
    yield "orders of the lattice equation:"
    for order in range(min(reduction.orders), reduction.highest_order + 1):
        equation = reduction.orders.get(order)
        yield f"  eps^{order}: {equation.text() if equation else '0 = 0'}"
    yield ""
    sound = reduction.sound_condition
    yield f"sound condition: {text_of(sound.lhs)} = {text_of(sound.rhs)}"
    yield from (f"condition: {condition.text()}" for condition in reduction.conditions)
    yield f"reduced equation (order eps^{reduction.scaling.leading_order}), {reduction.pde.kind}:"
    yield f"  {reduction.pde.text()}"
    yield from (f"  {line}" for line in reduction.idle_losses)
    for symbol, value in reduction.lattice.definitions:
        if value.is_zero is not True and reduction.pde.flow.field.symbols.count(symbol):
            yield f"  {symbol} = {text_of(value)}"
    yield from _beyond(reduction)


def _slaved_lines(reduction: Reduction) -> Iterator[str]:
    """Yield a line for each field after the first: its share of W and its first slaved term."""
    notation = replace(reduction.notation, unknown=reduction.wave)
    field = reduction.pde.flow.field
    unit = DifferentialPolynomial.monomial(field, ((0,) * len(notation.axes),))
    small = partial(power_of, eps, printed=text_of)
    for name, (weight, series) in list(reduction.slaved.items())[1:]:
        first = next(iter(series.parts.items()), None)
        wave_text = small(reduction.scaling.amplitude) + notation.text(weight * unit)
        text = f" + {small(first[0])}({notation.text(first[1])}) + ..." if first else ""
        yield f"{name} = {wave_text}{text}"


def _beyond(reduction: Reduction) -> Iterator[str]:
    notation = reduction.notation
    for order, part in reduction.remainders.items():
        yield f"left in the lattice equation at eps^{order} by an exact solution of it:"
        yield f"  {reduction.label('R', order)} = {notation.text(part)}"
    for power, part in reduction.corrections.items():
        name = reduction.label("G", power)
        yield f"correction of the reduced equation, Y_T = ... + eps^{power} {name}:"
        yield f"  {name} = {notation.text(part)}"
    if reduction.obstruction:
        power, part = reduction.obstruction
        yield f"no local correction at eps^{power}: this is not an X-derivative:"
        yield f"  {notation.text(part)}"


def latex_report(reduction: Reduction, constants: Mapping[str, Number]) -> str:
    """Return orders, conditions, reduced equation and coefficients as one ``aligned`` block."""
    rows = [(rf"\epsilon^{{{order}}}:", e.latex()) for order, e in reduction.orders.items()]
    rows.append((r"\text{sound}:", latex_of(reduction.sound_condition)))
    rows += [(r"\text{condition}:", condition.latex()) for condition in reduction.conditions]
    rows.append((r"\text{reduced}:", reduction.pde.latex()))
    rows += [("", reduction.latex_remainder(order)) for order in reduction.remainders]
    rows += [("", reduction.latex_correction(power)) for power in reduction.corrections]
    values = reduction.coefficients(**constants)
    rows += [("", f"{latex_of(reduction.scaling.speed)} = {latex_of(values.c)}")]
    if constants:
        for name, value in values.terms.items():
            term = reduction.notation.monomial(values.monomials[name], latex_of)
            rows.append((rf"\text{{of }} {term}:", latex_of(value)))
    if reduction.has_normal_form:
        form = reduction.normal_form(**constants)
        taken = reduction.lattice.names
        equation = marked(NORMAL_EQUATIONS[form.equation].latex, "srU", taken)
        rows.append((r"\text{normal form}:", re.sub(r"(\w)~", r"\\tilde{\1}", equation)))
        values_by_label = {latex_of(Symbol(unused(n, taken))): v for n, v in form.values.items()}
        rows += [("", f"{label} = {latex_of(value)}") for label, value in values_by_label.items()]
    return aligned(rows)


def reduction_data(reduction: Reduction, constants: Mapping[str, Number]) -> Data:
    """Return the JSON document of a reduction: ansatz, orders, conditions, equation, corrections.

    It also has the coefficients and the normal form at ``constants`` (names to values).
    """
    notation, obstruction = reduction.notation, reduction.obstruction
    losses: Data = {}
    if reduction.lattice.has_losses:
        law = reduction.amplitude_law(**constants)
        texts = law and {"rate": text_of(law.rate), "solution": text_of(law.solution)}
        losses = {"idle_losses": list(reduction.idle_losses), "amplitude_law": texts}

    def data(part: DifferentialPolynomial) -> Data:
        return polynomial_data(part, notation)

    sound = reduction.sound_condition
    return {
        "lattice": reduction.lattice.name,
        "equations": list(reduction.lattice.equations()),
        "missing_energies": list(reduction.lattice.missing_energies),
        "scaling": _scaling_data(reduction.scaling),
        "generators": [str(symbol) for symbol in reduction.pde.flow.field.symbols],
        "orders": {str(o): data(e.polynomial) for o, e in reduction.orders.items()},
        "sound_condition": f"{text_of(sound.lhs)} = {text_of(sound.rhs)}",
        "conditions": [
            {"order": item.order, "vanishes": text_of(item.expression), "reason": item.reason}
            for item in reduction.conditions
        ],
        "kind": reduction.pde.kind,
        **losses,
        "units": reduction.units,
        "definitions": {str(s): text_of(value) for s, value in reduction.lattice.definitions},
        "pde": {"equation": reduction.pde.text(), **data(reduction.pde.polynomial)},
        "remainders": {str(o): data(part) for o, part in reduction.remainders.items()},
        "corrections": {str(p): data(part) for p, part in reduction.corrections.items()},
        "obstruction": {str(obstruction[0]): data(obstruction[1])} if obstruction else {},
        **_number_data(reduction, constants),
    }


def _scaling_data(scaling: Scaling) -> Data:
    return {
        "amplitude": scaling.amplitude,
        "time": scaling.time,
        "space": [
            {
                "name": v.name,
                "exponent": v.exponent,
                "direction": [int(d) if d.is_Integer else text_of(d) for d in v.direction],
                "speed": text_of(v.speed),
            }
            for v in scaling.space
        ],
        "background": [[exponent, text_of(value)] for exponent, value in scaling.background],
    }


def _number_data(reduction: Reduction, constants: Mapping[str, Number]) -> Data:
    """Return the coefficients at ``constants``, and the normal form if the equation has one."""
    values = reduction.coefficients(**constants)
    terms = {name: text_of(value) for name, value in values.terms.items()}
    has_form = reduction.has_normal_form
    return {
        "constants": {name: str(value) for name, value in constants.items()},
        "coefficients": {"c": text_of(values.c), "terms": terms},
        **({"normal_form": form_data(reduction.normal_form(**constants))} if has_form else {}),
    }
