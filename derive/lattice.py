"""Lattices as data: fields, masses, and bonds and on-site forces of any smooth law."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from sympy import Expr, Poly, S, Symbol, factorial, nan, oo, simplify, zoo

from longwave.derive.algebra.contact import contact
from longwave.derive.algebra.exact_numbers import Number, exact, instance, integer, tuple_of
from longwave.derive.algebra.formula_printing import Printed, latex_of, text_of
from longwave.derive.output import notation
from longwave.derive.output.own_names import unused
from longwave.derive.symbols import (
    check_constants,
    check_names,
    constant_value,
    eps,
    loss_value,
    powers_of_eps,
    rational_function,
    values_of,
    x,
)
from longwave.support.user_files import shown

if TYPE_CHECKING:
    from longwave.derive.measured import Measured

Cell = tuple[int, ...]

SINGULAR = (nan, oo, -oo, zoo)

_ASSUMPTIONS = ("positive", "negative", "nonnegative", "nonpositive", "nonzero", "integer")

LARGEST_STEP = 10**6
"""Largest absolute value of a shift or weight in a stencil."""


@dataclass(frozen=True)
class Stencil:
    """``weight`` times ``field`` in the cell at offset ``shift`` (a tuple, one entry an axis)."""

    shift: Cell
    weight: int = 1
    field: int = 0

    def __post_init__(self) -> None:
        shift = tuple_of("shift", self.shift, object, "one an axis: (1,) is a chain's next cell")
        object.__setattr__(self, "shift", shift)
        for step in (*shift, self.weight):
            integer("shift and weight", step, -LARGEST_STEP, "whole cells, whole weights")
        integer("field", self.field, 0, "the index of the field in the lattice's fields")


@dataclass(frozen=True)
class Bond:
    """One kind of bond: its stretch, its force law, and where that force acts.

    The bond of cell n has the stretch ``x = sum weight f_{n+shift}`` over ``stretch``; field f then
    feels ``sum weight force(x_{n+shift})`` over the entries of ``action`` with that field.
    ``force`` is a polynomial in the symbol ``derive.symbols.x``, whose coefficients are exact
    rational functions of symbols, and polynomials in ``derive.symbols.eps`` for small constants; or
    any other function of x that is smooth about x = 0, such as ``exp(b*x)`` or ``-(d -
    x)**Rational(3, 2)``. ``loss`` is that of a dashpot parallel to the spring, which adds ``loss
    dx/dt`` to the force. Raises ValueError for anything else.
    """

    stretch: tuple[Stencil, ...]
    force: Expr
    action: tuple[Stencil, ...]
    loss: Expr = field(default=S.Zero, repr=False)

    def __post_init__(self) -> None:
        for name in ("stretch", "action"):
            entries = tuple_of(name, getattr(self, name), Stencil, "(Stencil((0,)),) is the cell")
            object.__setattr__(self, name, entries)
        if not isinstance(self.force, Expr):
            raise ValueError(
                "force must be an expression in longwave.derive.symbols.x, got "
                f"{shown(self.force)} (such as K2*x + K4*x**3)"
            )
        exact("force", self.force)
        object.__setattr__(self, "loss", _loss("loss", self.loss))
        if self.is_polynomial:
            for coefficient in self.coefficients():
                rational_function("force", coefficient)
            return
        if self.force.has(eps):
            raise ValueError(
                "force must be a polynomial in longwave.derive.symbols.x where it depends on eps, "
                f"got {shown(self.force)} (expand the force law about zero stretch)"
            )
        for value in (self._derivative(0), self._derivative(1)):
            if value.has(*SINGULAR) or value.is_real is False:
                raise ValueError(
                    f"force must be real and smooth about zero stretch, got {shown(self.force)} "
                    "(put the precompression into x: -A*sqrt(d - x)**3 with d positive)"
                )

    @property
    def has_reaction(self) -> bool:
        """Whether the bond's forces on all fields add up to 0, unlike those of an on-site force."""
        return not sum(entry.weight for entry in self.action)

    @property
    def is_polynomial(self) -> bool:
        """Whether the force is a polynomial in the stretch."""
        return bool(self.force.is_polynomial(x))

    def coefficients(self) -> tuple[Expr, ...]:
        """Return a polynomial force's coefficients, highest power first, for Horner's rule."""
        return tuple(Poly(self.force, x).all_coeffs())

    def taylor(self, power: int) -> Expr:
        """Return the factor of ``x**power`` in the force about zero stretch."""
        return simplify(self._derivative(power) / factorial(power))

    def _derivative(self, power: int) -> Expr:
        """Return the force's derivative at zero stretch."""
        return self.force.diff(x, power).subs(x, 0)

    def stiffness(self, stretch: Expr) -> Expr:
        """Return the force's slope at a uniform ``stretch``."""
        return self.force.diff(x).subs(x, stretch)


Weights = dict[tuple[int, Cell], int]
"""Weights of an action or a stretch by (field, offset)."""


def _weights(entries: Iterable[Stencil], factor: int = 1) -> Weights:
    """Return the total weight by (field, offset); ``factor`` multiplies weights and offsets."""
    totals: Weights = {}
    for entry in entries:
        site = entry.field, tuple(factor * step for step in entry.shift)
        totals[site] = totals.get(site, 0) + factor * entry.weight
    return {site: weight for site, weight in totals.items() if weight}


def _multiply_stencils(left: Weights, right: Weights, turn: int = 1) -> Weights:
    """Multiply two stencils as polynomials in shifts; ``turn`` = -1 mirrors the right one."""
    totals: Weights = {}
    for (_, first), a in left.items():
        for (_, second), b in right.items():
            site = 0, tuple(i + turn * j for i, j in zip(first, second, strict=True))
            totals[site] = totals.get(site, 0) + a * b
    return {site: weight for site, weight in totals.items() if weight}


def spring(force: Expr, start: tuple[Cell, int], end: tuple[Cell, int]) -> Bond:
    """Return the bond between two displacements, each given by its cell and its field.

    Its stretch is the end's displacement minus the start's, and its force pulls at both.

    >>> from longwave.derive.symbols import K2
    >>> chain = Lattice("chain", "chain", ("u",), (1,), (spring(K2*x, ((0,), 0), ((1,), 0)),))
    >>> chain.equations()[0]
    "u_n'' = F(u_{n+1} - u_n) - F(u_n - u_{n-1})"
    """
    (start_cell, first), (end_cell, second) = start, end
    from_start, from_end = (tuple(-step for step in cell) for cell in (start_cell, end_cell))
    return Bond(
        stretch=(Stencil(end_cell, 1, second), Stencil(start_cell, -1, first)),
        force=force,
        action=(Stencil(from_start, 1, first), Stencil(from_end, -1, second)),
    )


def on_site(force: Expr, field: int = 0, axes: int = 1) -> Bond:
    """Return the on-site force ``-force(f_n)`` on a field of a lattice with ``axes`` axes."""
    origin = (0,) * axes
    return Bond((Stencil(origin, 1, field),), force, (Stencil(origin, -1, field),))


@dataclass(frozen=True, repr=False)
class Lattice(notation.Displayed):
    """Equations of motion ``mass f'' = sum of bond forces - loss f'``, one for each field.

    ``definitions`` are symbols that represent expressions in the lattice's other constants,
    ``measured`` the measured values of constants, which remain symbols. ``losses`` are those of the
    sites, one for each field, or empty; bonds have their own.

    >>> from longwave.derive import LATTICES
    >>> LATTICES["fput_strain"].constants
    (K2, K3, K4)
    """

    name: str
    title: str
    fields: tuple[str, ...]
    masses: tuple[Expr, ...]
    bonds: tuple[Bond, ...]
    definitions: tuple[tuple[Symbol, Expr], ...] = ()
    measured: Measured | None = None
    losses: tuple[Expr, ...] = ()

    @property
    def constants(self) -> tuple[Symbol, ...]:
        """Symbols in forces, masses and losses, sorted by name, without eps."""
        forces = (part for bond in self.bonds for part in (bond.force, bond.loss))
        expressions = (*self.masses, *self.losses, *forces)
        symbols = {symbol for expression in expressions for symbol in expression.free_symbols}
        return tuple(sorted(symbols - {x, eps}, key=str))

    @property
    def basic_constants(self) -> tuple[Symbol, ...]:
        """Constants sorted by name; for a defined symbol, the symbols in its definition instead."""
        defined = dict(self.definitions)
        inner = (symbol for value in defined.values() for symbol in value.free_symbols)
        return tuple(sorted({*self.constants, *inner} - {*defined}, key=str))

    @property
    def names(self) -> set[str]:
        """Names of fields and constants, which other names in an output must avoid."""
        return {*self.fields, *map(str, (*self.constants, *self.basic_constants))}

    def with_defined(self, values: Mapping[Symbol, Expr]) -> dict[Symbol, Expr]:
        """Return ``values`` and the values of the symbols that are defined by other constants."""
        return {**{symbol: value.xreplace(values) for symbol, value in self.definitions}, **values}

    def with_values(self, values: Mapping[str, Number]) -> Lattice:
        """Return the lattice with constants replaced by numbers, or by polynomials in eps.

        Text may contain formulas.  Raises ValueError for an unknown constant, and for a value that
        violates the assumptions of its symbol.

        >>> from longwave.derive import LATTICES
        >>> LATTICES["fput"].with_values({"K2": 4, "K3": "eps/2"}).equations()[1]
        'F(x) = 4 x + eps/2 x^2 + K4 x^3'
        """
        names = {str(s): s for s in self.constants}
        substitutions = values_of(values, names, self.name, constant_value)
        for symbol, value in substitutions.items():
            if symbol.is_positive and value.subs(eps, 0).is_positive is False:
                remedy = self.vacuum_at(symbol, value) or self.name
                raise ValueError(f"{symbol} must satisfy {symbol} > 0, got {value} ({remedy})")

        def image(expression: Expr) -> Expr:
            return expression.xreplace(substitutions)

        return replace(
            self,
            masses=tuple(map(image, self.masses)),
            bonds=tuple(replace(b, force=image(b.force), loss=image(b.loss)) for b in self.bonds),
            definitions=tuple((symbol, image(value)) for symbol, value in self.definitions),
            losses=tuple(map(image, self.losses)),
        )

    def with_losses(
        self, site: Number | Mapping[str, Number] = 0, bond: Number | Mapping[int, Number] = 0
    ) -> Lattice:
        """Return the lattice with the force ``-site df/dt`` on each field and dashpots at springs.

        Losses are numbers or formulas such as "eps**3*gamma"; new names in them are positive
        constants.  A mapping gives different losses to fields (by name) or bonds (by number from
        1). An on-site force is not a bond between cells; its dashpot is a loss of the site. Raises
        ValueError for anything else.

        >>> from longwave.derive import LATTICES
        >>> LATTICES["fput_strain"].with_losses(site="eps^3*gamma", bond=1).equations()
        ("y_n'' = F(y_{n+1}) - 2 F(y_n) + F(y_{n-1}) - eps^3 gamma y_n'",
         "F(x) = K2 x + K3 x^2 + K4 x^3 + x'")
        """
        springs = [str(i) for i, each in enumerate(self.bonds, 1) if each.has_reaction]
        symbols = {str(symbol): symbol for symbol in self.constants}
        sites = _losses_by_name("site", site, self.fields, symbols)
        dashpots = _losses_by_name("bond", bond, springs, symbols)
        numbered = enumerate(self.bonds, 1)
        bonds = tuple(replace(b, loss=dashpots.get(str(i), S.Zero)) for i, b in numbered)
        losses = tuple(sites.values())
        return replace(self, bonds=bonds, losses=losses if any(losses) else ())

    @property
    def site_losses(self) -> tuple[Expr, ...]:
        """Losses of the sites, one for each field."""
        return self.losses or (S.Zero,) * len(self.fields)

    @property
    def leading_losses(self) -> dict[str, tuple[Expr, int]]:
        """For "site" and "bond", if lossy: the loss of the lowest power of eps, and that power."""
        losses_by_kind = {}
        for kind, values in (("site", self.losses), ("bond", [bond.loss for bond in self.bonds])):
            by_power = [(loss, min(powers_of_eps(loss))) for loss in values if loss]
            if by_power:
                losses_by_kind[kind] = min(by_power, key=lambda entry: entry[1])
        return losses_by_kind

    @property
    def contact_constants(self) -> set[Symbol]:
        """Constants that occur only in the arguments of contacts; a run allows 0 for them."""
        laws = [bond.force for bond in self.bonds]
        opening = {s for law in laws for at in law.atoms(contact) for s in at.free_symbols}
        closed_laws = (law.replace(contact, lambda _: S.One) for law in laws)
        return opening - {x} - {s for law in closed_laws for s in law.free_symbols}

    @property
    def unfelt_constants(self) -> set[Symbol]:
        """Constants that occur only in contacts open at rest; small waves do not depend on them."""

        def closed_at_rest(opening: Expr) -> Expr:
            return S.Zero if opening.subs(x, 0).is_negative else contact(opening)

        laws = (bond.force.replace(contact, closed_at_rest) for bond in self.bonds)
        bonds = (replace(b, force=law) for b, law in zip(self.bonds, laws, strict=True))
        return {*self.constants} - {*replace(self, bonds=tuple(bonds)).constants}

    def check_values(self, values: Mapping[Symbol, Expr]) -> None:
        """Raise ValueError for a value that violates the assumptions of its symbol."""
        for symbol, value in values.items():
            for word in _ASSUMPTIONS:
                if getattr(symbol, f"is_{word}") and getattr(value, f"is_{word}") is False:
                    remedy = self.vacuum_at(symbol, value) or (
                        "the equation is derived for such values; in a lattice file leave it out "
                        "of `positive` if others are meant"
                    )
                    raise ValueError(f"{symbol} must be {word}, got {shown(value)} ({remedy})")

    def vacuum_at(self, symbol: Symbol, value: Expr) -> str:
        """Return a message if ``symbol = value`` removes a bond's linear stiffness, else "".

        >>> from longwave.derive import LATTICES
        >>> LATTICES["granular"].vacuum_at(Symbol("d", positive=True), S.Zero)[:42]
        'there a bond has no linear stiffness, a so'
        """
        defined = dict(self.definitions)
        slopes = (bond.stiffness(S.Zero).xreplace(defined) for bond in self.bonds)
        if value != 0 or all(slope.subs(symbol, 0) != 0 for slope in slopes if slope.has(symbol)):
            return ""
        return (
            "there a bond has no linear stiffness, a sonic vacuum without linear waves to expand "
            f"about: precompress the chain, {symbol} > 0, or run the lattice itself"
        )

    @property
    def has_losses(self) -> bool:
        """Whether there is any loss."""
        return bool(self.leading_losses)

    @property
    def has_displacements(self) -> bool:
        """Whether each bond acts by minus its stretch with offsets negated, as for displacements.

        >>> from longwave.derive import LATTICES
        >>> [LATTICES[name].has_displacements for name in ("klein_gordon", "fput_strain")]
        [True, False]
        """
        return all(_weights(bond.action) == _weights(bond.stretch, -1) for bond in self.bonds)

    @property
    def missing_energies(self) -> tuple[str, ...]:
        """Messages on bonds whose action derives from no energy, so that energy is not conserved.

        With an energy ``V(x)`` a bond acts by minus its stretch with offsets negated, its mirror.
        In variables such as strains one positive symmetric stencil may multiply all actions.

        >>> from longwave.derive import LATTICES
        >>> LATTICES["fput_strain"].missing_energies
        ()
        >>> ends = Stencil((0,), 2), Stencil((-1,), -1)
        >>> bond = Bond((Stencil((1,)), Stencil((0,), -1)), x, ends)
        >>> Lattice("odd", "odd", ("u",), (S.One,), (bond,)).missing_energies
        ('F acts on u by 2*F[n] - F[n-1], an energy of its stretch by F[n] - F[n-1]',)
        """
        pairs = [(_weights(bond.action), _weights(bond.stretch, -1)) for bond in self.bonds]
        wrong = [i for i, (action, mirror) in enumerate(pairs) if action != mirror]
        if not wrong or (len({*self.masses}) == 1 and self._has_metric(pairs)):
            return ()
        messages = []
        for i in wrong:
            name = f"F{i + 1}" if len(pairs) > 1 else "F"
            for index, label in enumerate(self.fields):
                acts, expected = (_sum_of_force(part, index) for part in pairs[i])
                if acts != expected:
                    by_energy = f"an energy of its stretch by {expected}"
                    messages.append(f"{name} acts on {label} by {acts}, {by_energy}")
        return tuple(messages)

    def _has_metric(self, pairs: Sequence[tuple[Weights, Weights]]) -> bool:
        """Return whether each action is its mirrored stretch times a positive symmetric stencil.

        ``pairs`` lists (action, mirror) for each bond; the stencil must be the same for all bonds.
        """
        rows = [
            tuple({s: w for s, w in part.items() if s[0] == index} for part in pair)
            for pair in pairs
            for index in range(len(self.fields))
        ]
        rows = [row for row in rows if any(row)]
        action, mirror = rows[0]
        square = _multiply_stencils(action, mirror, -1)  # the stencil times the mirror squared
        mirrored = {(0, tuple(-step for step in cell)): w for (_, cell), w in square.items()}
        if square != mirrored or any(
            _multiply_stencils(a, mirror) != _multiply_stencils(action, m) for a, m in rows
        ):
            return False
        return all(
            sum(w * math.cos(k * c[0] + 0.7 * k * c[-1]) for (_, c), w in square.items()) > 0
            for k in (0.3, 1.0, 1.7, 2.4, 3.1)
        )

    def strained(self, strain: Expr) -> Lattice:
        """Return the one-field lattice expanded about a uniform strain: its field is the deviation.

        >>> from longwave.derive import LATTICES
        >>> LATTICES["alpha_fput"].strained(S(1) / 2).equations()[1]
        'F(x) = (K3 + K2) x + K3 x^2'
        """
        bonds = []
        for bond in self.bonds:
            shifts = [e.shift[0] if self.is_displacement else 1 for e in bond.stretch]
            mean = strain * sum(e.weight * i for e, i in zip(bond.stretch, shifts, strict=True))
            force = bond.force.subs(x, x + mean) - bond.force.subs(x, mean)
            bonds.append(replace(bond, force=force.expand() if bond.is_polynomial else force))
        return replace(self, bonds=tuple(bonds))

    @property
    def is_displacement(self) -> bool:
        """Whether no bond is stretched if all fields move by the same amount."""
        return not any(sum(entry.weight for entry in bond.stretch) for bond in self.bonds)

    @property
    def is_linear(self) -> bool:
        """Whether all forces are linear in the stretch."""
        return all(bond.force.diff(x, 2).is_zero for bond in self.bonds)

    @property
    def is_polynomial(self) -> bool:
        """Whether all forces are polynomials in the stretch."""
        return all(bond.is_polynomial for bond in self.bonds)

    def expanded(self, degree: int) -> Lattice:
        """Return the lattice with each force expanded about zero stretch up to ``x**degree``.

        A coefficient that is not a rational function gets a symbol, F2 for that of x^2 (F2a, F2b
        with several bonds), defined in ``definitions``; equal coefficients share it.

        >>> from sympy import Symbol, sin, sqrt
        >>> stiffness = Symbol("g", positive=True)
        >>> sine = Lattice("sine", "sine", ("u",), (1,), (on_site(sqrt(stiffness)*sin(x)),))
        >>> sine.expanded(3).equations()[1], sine.expanded(3).definitions
        ('F(x) = F1 x + F3 x^3', ((F1, sqrt(g)), (F3, -sqrt(g)/6)))
        """
        definitions = dict(self.definitions)
        known = {value: symbol for symbol, value in self.definitions}
        bonds, names = [], self.names
        for index, bond in enumerate(self.bonds):
            force: Expr = S.Zero
            for power in () if bond.is_polynomial else range(degree + 1):
                value = bond.taylor(power)
                if not _is_rational(value) and value not in known:
                    name = f"F{power}{_letters(index) if len(self.bonds) > 1 else ''}"
                    is_positive = value.is_positive or None
                    known[value] = Symbol(unused(name, names), real=True, positive=is_positive)
                    definitions[known[value]] = value
                force += known.get(value, value) * x**power
            bonds.append(bond if bond.is_polynomial else replace(bond, force=force))
        return replace(self, bonds=tuple(bonds), definitions=tuple(definitions.items()))

    @property
    def dimension(self) -> int:
        """Number of axes of the lattice."""
        return len(self.bonds[0].stretch[0].shift)

    def __post_init__(self) -> None:
        for name in ("name", "title"):
            instance(name, getattr(self, name), str, "such as 'chain'")
        fields = tuple_of("fields", self.fields, str, "('y',) is one field, the strain")
        masses = tuple_of("masses", self.masses, object, "(1,) is one field's, the unit")
        object.__setattr__(self, "fields", fields)
        object.__setattr__(self, "masses", tuple(rational_function("mass", m) for m in masses))
        losses = self.losses and tuple_of("losses", self.losses, object, "() is none")
        object.__setattr__(self, "losses", tuple(_loss("losses", loss) for loss in losses))
        bonds = tuple_of("bonds", self.bonds, Bond, "LATTICES['fput_strain'].bonds shows one")
        object.__setattr__(self, "bonds", bonds)
        for label, values in (("masses", masses), ("losses", losses or fields)):
            if len(values) != len(fields):
                none = ", or () for none" if label == "losses" else ""
                raise ValueError(
                    f"{label} must be as many as the fields, {len(fields)}, got {len(values)} "
                    f"(one for each field{none})"
                )
        for name in fields:
            if not re.fullmatch(r"[A-Za-z][A-Za-z0-9]*", name, re.ASCII) or fields.count(name) > 1:
                raise ValueError(
                    "fields must have different names of letters and digits, got "
                    f"{shown(name)} (such as 'u1', 'u2')"
                )
        for mass in self.masses:
            if mass.has(x):
                raise ValueError(f"mass must not depend on the stretch x, got {mass} (a constant)")
            if mass.is_nonpositive:
                raise ValueError(f"mass must satisfy mass > 0, got {mass} (1 is the unit)")
        for entry in (entry for bond in self.bonds for entry in (*bond.stretch, *bond.action)):
            if entry.field >= len(self.fields) or len(entry.shift) != self.dimension:
                raise ValueError(
                    f"{entry} must name one of {len(self.fields)} fields and shift along "
                    f"{self.dimension} axes, got field {entry.field} and {len(entry.shift)} axes "
                    "(fields are counted from 0)"
                )
        check_names("fields", fields)
        check_constants(self.basic_constants, fields)
        check_constants(self.constants, fields)

    def equations(self, printed: Printed = text_of) -> tuple[str, ...]:
        """Return the equations of motion, then the force of each bond, one a line.

        >>> from longwave.derive import LATTICES
        >>> LATTICES["fput_strain"].equations()[0]
        "y_n'' = F(y_{n+1}) - 2 F(y_n) + F(y_{n-1})"
        """
        is_text = printed is text_of
        dots = ("{}'", "{}''") if is_text else (r"\dot{{{}}}", r"\ddot{{{}}}")
        return tuple(_equations(self, printed, dots))

    def text(self) -> str:
        """Return the name, and the equations in plain text."""
        return f"{self.name}: {'; '.join(self.equations())}"

    def latex(self) -> str:
        """Return the equations in LaTeX, without delimiters."""
        return r",\quad ".join(self.equations(latex_of))


def _sum_of_force(weights: Weights, field: int) -> str:
    """Return the force that a bond exerts on a field, in the notation of lattice files."""
    terms = []
    for (field_index, cell), weight in sorted(weights.items(), reverse=True):
        if field_index == field:
            steps = ", ".join(f"{a}{s:+d}" if s else a for a, s in zip("nml", cell, strict=False))
            factor = "" if abs(weight) == 1 else f"{abs(weight)}*"
            terms.append((weight < 0, f"{factor}F[{steps}]"))
    return notation.signed_sum(terms)


def _letters(number: int) -> str:
    """Return a, b, ..., z, aa, ab, ... for the numbers from 0."""
    quotient, letter = divmod(number, 26)
    return (_letters(quotient - 1) if quotient else "") + chr(ord("a") + letter)


def _is_rational(value: Expr) -> bool:
    try:
        rational_function("force", value)
    except ValueError:
        return False
    return True


def _loss(label: str, value: Expr) -> Expr:
    """Return a loss exactly. Raises ValueError if it depends on the stretch or is negative."""
    value = rational_function(label, value)
    if value.has(x):
        raise ValueError(f"{label} must not depend on the stretch x, got {value} (a constant)")
    if value.is_negative:
        raise ValueError(f"{label} must satisfy {label} >= 0, got {value} (it takes energy out)")
    return value


def _losses_by_name(
    kind: str, given: Number | Mapping[Any, Number], names: Sequence[str], known: dict[str, Symbol]
) -> dict[str, Expr]:
    """Return the loss of each of ``names``, from a table or one value for all of them.

    New constants in the losses are added to ``known``.
    """
    losses = given if isinstance(given, Mapping) else dict.fromkeys(names, given)
    for name in losses:
        if str(name) not in names:
            raise ValueError(
                f"{kind} must be a loss of {', '.join(names) or 'nothing here'}, got one of "
                f"{shown(str(name))} (or one value for all)"
            )
    values = {str(n): _loss(kind, loss_value(kind, value, known)) for n, value in losses.items()}
    return {name: values.get(name, S.Zero) for name in names}


def _equations(lattice: Lattice, printed: Printed, dots: tuple[str, str]) -> Iterator[str]:
    """Yield equations and forces; ``dots`` are formats of first and second time derivatives."""
    rate, acceleration = dots
    numbers = range(1, len(lattice.bonds) + 1)
    names = [f"F{number}" for number in numbers] if len(numbers) > 1 else ["F"]
    labels = [printed(Symbol(unused(name, lattice.names))) for name in names]
    here = _cell((0,) * lattice.dimension)
    for index, name in enumerate(lattice.fields):
        mass = lattice.masses[index]
        forces = [
            (entry.weight, f"{force}({_stretch(lattice, bond, entry)})")
            for force, bond in zip(labels, lattice.bonds, strict=True)
            for entry in bond.action
            if entry.field == index
        ]
        loss = lattice.site_losses[index]
        if loss:
            forces.append((-1, _times(loss, rate.format(f"{name}_{here}"), printed)))
        moving = _times(mass, acceleration.format(f"{name}_{here}"), printed)
        yield f"{moving} = {notation.weighted_sum(forces)}"
    for force, bond in zip(labels, lattice.bonds, strict=True):
        dashpot = f" + {_times(bond.loss, rate.format('x'), printed)}" if bond.loss else ""
        if not bond.is_polynomial:
            yield f"{force}(x) = {printed(bond.force)}{dashpot}"
            continue
        terms = enumerate(reversed(bond.coefficients()))
        law = (_law_term(value, power, printed) for power, value in terms if value != 0)
        yield f"{force}(x) = {notation.signed_sum(law)}{dashpot}"


def _law_term(value: Expr, power: int, printed: Printed) -> tuple[bool, str]:
    """Return whether the term ``value x**power`` of a force is negative, and the unsigned term."""
    is_negative = bool(value.as_coeff_Mul()[0] < 0)
    magnitude = -value if is_negative else value
    return is_negative, _times(magnitude, notation.power_of(x, power, printed), printed).rstrip()


def _times(factor: Expr, product: str, printed: Printed) -> str:
    prefix = "" if factor == 1 and product else f"{notation.bracketed(factor, printed)} "
    return prefix + product


def _stretch(lattice: Lattice, bond: Bond, at: Stencil) -> str:
    """Return the stretch of the bond whose force acts through ``at``, as text."""
    parts = []
    for entry in bond.stretch:
        cell = [i + j for i, j in zip(entry.shift, at.shift, strict=True)]
        parts.append((entry.weight, f"{lattice.fields[entry.field]}_{_cell(cell)}"))
    return notation.weighted_sum(parts)


def _cell(shift: Sequence[int]) -> str:
    """Return the cell at an offset as a subscript, with further axes after a comma.

    >>> _cell((0,)), _cell((1,)), _cell((1, 0))
    ('n', '{n+1}', '{n+1,m}')
    """
    names = [f"{axis}{step:+d}" if step else axis for axis, step in zip("nml", shift, strict=False)]
    joined = ",".join(names)
    return joined if len(joined) == 1 else f"{{{joined}}}"
