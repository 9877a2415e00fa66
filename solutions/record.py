"""The record of one closed-form solution: its parameters, and the equation that it solves.

A parameter has a domain, and says what happens at its ends.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property, partial
from typing import Any

import sympy as sp

from longwave.derive.algebra.exact_numbers import exact_number, instance
from longwave.solutions.equation import Equation
from longwave.support.known_names import did_you_mean

COMPARISON_DIGITS = 60

LONGEST_FORMULA = 5000
"""Signs of a formula in LaTeX that a notebook still sets; that of rogue_cn has 200 000."""


@dataclass(frozen=True)
class Bound:
    """One end of a domain: its value, the neighbouring limit in words, open or closed.

    ``value`` may contain the symbols of other parameters (``elliptic_k(k**2)`` for alpha).
    """

    value: sp.Expr
    limit: str
    is_open: bool = True


@dataclass(frozen=True)
class Parameter:
    """A real parameter: symbol, bounds (None is unbounded) and default (None is required).

    >>> k = sp.Symbol("k")
    >>> modulus = Parameter(
    ...     k, Bound(sp.S.Zero, "the constant"), Bound(sp.S.One, "the sech soliton")
    ... )
    >>> modulus.check({"k": 0.7})
    7/10
    >>> modulus.check({"k": 1.2})
    Traceback (most recent call last):
    ...
    ValueError: k must satisfy 0 < k < 1, got 1.2 (k = 1 is the sech soliton)
    """

    symbol: sp.Symbol
    lower: Bound | None = None
    upper: Bound | None = None
    default: sp.Expr | None = None

    def __post_init__(self) -> None:
        instance("symbol", self.symbol, sp.Symbol, "longwave.solutions.symbols holds k, A, ...")

    @property
    def name(self) -> str:
        """The keyword by which the parameter is given."""
        return str(self.symbol.name)

    @property
    def domain(self) -> str:
        """The domain in words: ``0 < k < 1``, or ``X_0 real``."""
        if self.lower is None and self.upper is None:
            return f"{self.name} real"
        left = f"{self.lower.value} {_sign(self.lower)} " if self.lower else ""
        right = f" {_sign(self.upper)} {self.upper.value}" if self.upper else ""
        return f"{left}{self.name}{right}"

    def check(self, values: Mapping[str, object]) -> sp.Expr:
        """This parameter's exact value out of ``values`` (name to number).

        Raises ValueError if it is missing, no finite real number or outside the domain.
        """
        if self.name not in values:
            if self.default is not None:
                return self.default
            raise ValueError(
                f"{self.name} must satisfy {self.domain}, got nothing (give {self.name})"
            )
        exact = exact_number(self.name, values[self.name])
        if self.lower is not None:
            self._check_bound(self.lower, exact, values, side=+1)
        if self.upper is not None:
            self._check_bound(self.upper, exact, values, side=-1)
        return exact

    def _check_bound(
        self, bound: Bound, exact: sp.Expr, values: Mapping[str, object], side: int
    ) -> None:
        end = bound.value.subs(
            {
                symbol: exact_number(symbol.name, values[symbol.name])
                for symbol in sorted(bound.value.free_symbols, key=str)
            }
        )
        distance = sp.N(side * (exact - end), COMPARISON_DIGITS)
        if distance > 0 or (distance == 0 and not bound.is_open):
            return
        about = f" ({bound.value} = {sp.N(end, 6)})" if bound.value.free_symbols else ""
        got = values[self.name]
        raise ValueError(
            f"{self.name} must satisfy {self.domain}{about}, got {got} "
            f"({self.name} = {bound.value} is {bound.limit})"
        )


def _sign(bound: Bound) -> str:
    return "<" if bound.is_open else "<="


@dataclass(frozen=True)
class Reference:
    """Where a formula is printed: a citation, and the paper's label of the equation or section.

    An equation without a label is called by its number, as in "(27)". Of what the paper does not
    have, the citation is written out and there is no label.
    """

    citation: str
    label: str = ""

    def __str__(self) -> str:
        return f"{self.citation}, {self.label}" if self.label else self.citation


@dataclass(frozen=True)
class FarFields:
    """What the wave tends to as X goes to -infinity (``left``) and +infinity (``right``)."""

    left: sp.Expr
    right: sp.Expr


class _Deferred:
    """A field that takes an expression, or a function that makes it when it is first asked for."""

    def __get__(self, form: object, _: type | None = None) -> sp.Expr:
        if form is None:
            raise AttributeError("expression")  # the field has no default
        held = vars(form)["expression"]
        if not isinstance(held, sp.Basic) and callable(held):
            held = vars(form)["expression"] = held()
        found: sp.Expr = held
        return found

    def __set__(self, form: object, value: sp.Expr | Callable[[], sp.Expr]) -> None:
        vars(form)["expression"] = value


@dataclass(frozen=True, kw_only=True)
class ClosedForm:
    """A solution ``U(xi, tau)``, or ``U(xi, zeta, tau)``, of ``equation``, written once.

    ``expression`` is the canonical form, as printed, or a function that makes it at first use; it
    is complex where the equation is, with I in sums, products and exponentials alone.
    ``background`` is the bare wave of the same phase that the figures subtract (zero for a bare
    wave itself); ``period`` is the background's period in ``xi``, None if it is constant.
    ``stabilise`` makes the form that is evaluated in floating point from the canonical one.
    ``evaluator`` makes, from exact parameters, what evaluates the form where that is not the
    stable expression
    (``solutions.run.program.PointEvaluator``). ``potential`` is an
    integral of U by xi that is constant on the left, of waves with zeta: the displacements of a
    lattice follow it. ``module`` is where the catalogue has it from.
    """

    name: str
    title: str
    expression: _Deferred = _Deferred()
    equation: Equation
    parameters: tuple[Parameter, ...]
    reference: Reference
    background: sp.Expr = sp.S.Zero
    far_fields: FarFields = FarFields(sp.S.Zero, sp.S.Zero)
    period: sp.Expr | None = None
    stabilise: Callable[[], sp.Expr] | None = field(default=None, compare=False, repr=False)
    evaluator: Callable[[Mapping[sp.Symbol, sp.Expr]], Any] | None = field(
        default=None, compare=False, repr=False
    )
    potential: sp.Expr | None = None
    module: str = field(default="", init=False, compare=False, repr=False)
    _found: tuple[Any, ...] | None = field(default=None, init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        for name in ("name", "title"):
            instance(name, getattr(self, name), str, "such as 'kink'")
        instance("equation", self.equation, Equation, "FOCUSING_MKDV is one")
        for parameter in self.parameters:
            instance(
                "each of parameters",
                parameter,
                Parameter,
                "Parameter(longwave.solutions.symbols.k)",
            )

    def found_by(self, maker: "Callable[..., ClosedForm]", *of: object) -> "ClosedForm":
        """This form, which pickles as a call of ``maker`` with ``of``."""
        object.__setattr__(self, "_found", (maker, of))
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        if self._found is not None:
            return self._found
        own = {entry.name: getattr(self, entry.name) for entry in fields(self) if entry.init}
        return partial(ClosedForm, **own), ()

    def __repr__(self) -> str:
        domains = "".join(f", {parameter.domain}" for parameter in self.parameters)
        return f"<ClosedForm {self.name}: {self.title}{domains}>"

    def _repr_latex_(self) -> str | None:
        """The formula, as notebooks show it; None for a long one, which they show as one line."""
        formula = sp.latex(self.expression)
        return rf"$\displaystyle U = {formula}$" if len(formula) <= LONGEST_FORMULA else None

    @cached_property
    def stable(self) -> sp.Expr:
        """The same function in a form that neither overflows nor cancels."""
        return self.expression if self.stabilise is None else self.stabilise()

    @property
    def residual(self) -> sp.Expr:
        """The equation's left-hand side at this form, unsimplified."""
        return self.equation.residual(self.expression)

    def check(self, values: Mapping[str, object]) -> dict[sp.Symbol, sp.Expr]:
        """Exact parameter values, or a ValueError naming what is missing, unknown or outside."""
        known = [parameter.name for parameter in self.parameters]
        for name in values:
            if name not in known:
                accepted = f"it takes {', '.join(known) or 'no parameters'}"
                raise ValueError(
                    f"parameters must be those of {self.name}, got {name!s:.60} "
                    f"({' '.join(filter(None, (did_you_mean(name, known), accepted)))})"
                )
        return {parameter.symbol: parameter.check(values) for parameter in self.parameters}
