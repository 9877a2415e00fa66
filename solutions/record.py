"""Record of one closed-form solution: its parameters and the equation that it solves.

A parameter has a domain, with the limit of the solution at each end.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property, partial
from typing import Any

import sympy as sp

from longwave.derive.algebra.exact_numbers import exact_number, instance
from longwave.derive.algebra.formula_printing import latex_of
from longwave.solutions.equation import Equation
from longwave.support.known_names import did_you_mean

COMPARISON_DIGITS = 60

LONGEST_FORMULA = 5000
"""Longest formula in LaTeX that a notebook shows, in characters; that of rogue_cn has 200 000."""


@dataclass(frozen=True)
class Bound:
    """One end of a domain: its value, the limit of the solution in words, open or closed.

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
        """Keyword of the parameter."""
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
        """Return this parameter's exact value from ``values`` (name to number).

        Raises ValueError if it is missing, not a finite real number, or outside the domain.
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
        symbols = sorted(bound.value.free_symbols, key=str)
        end = bound.value.subs({s: exact_number(s.name, values[s.name]) for s in symbols})
        distance = sp.N(side * (exact - end), COMPARISON_DIGITS)
        if distance > 0 or (distance == 0 and not bound.is_open):
            return
        end_text = f" ({bound.value} = {sp.N(end, 6)})" if bound.value.free_symbols else ""
        got = values[self.name]
        raise ValueError(
            f"{self.name} must satisfy {self.domain}{end_text}, got {got} "
            f"({self.name} = {bound.value} is {bound.limit})"
        )


def _sign(bound: Bound) -> str:
    return "<" if bound.is_open else "<="


def positive(
    symbol: sp.Symbol, limit: str, upper: Bound | None = None, default: sp.Expr | None = None
) -> Parameter:
    """Return a parameter ``symbol`` > 0 with the upper bound ``upper``, if that is given.

    ``limit`` names the limit of the solution at 0.
    """
    return Parameter(symbol, Bound(sp.S.Zero, limit), upper, default)


def real(symbol: sp.Symbol, default: sp.Expr = sp.S.Zero) -> Parameter:
    """Return a parameter that may be any real number."""
    return Parameter(symbol, default=default)


@dataclass(frozen=True)
class Reference:
    """Source of a formula: a citation, and the paper's label of the equation or section.

    An equation without a label is cited by its number, as in "(27)". A source that the paper does
    not cite is written out in full, without a label.
    """

    citation: str
    label: str = ""

    def __str__(self) -> str:
        return f"{self.citation}, {self.label}" if self.label else self.citation


@dataclass(frozen=True)
class FarFields:
    """Limits of the wave as X goes to -infinity (``left``) and +infinity (``right``)."""

    left: sp.Expr
    right: sp.Expr


class _Deferred:
    """Descriptor of an expression, or of a function that builds it on first access."""

    def __get__(self, form: object, _: type | None = None) -> sp.Expr:
        if form is None:
            raise AttributeError("expression")  # the field has no default
        value = vars(form)["expression"]
        if not isinstance(value, sp.Basic) and callable(value):
            value = vars(form)["expression"] = value()
        expression: sp.Expr = value
        return expression

    def __set__(self, form: object, value: sp.Expr | Callable[[], sp.Expr]) -> None:
        vars(form)["expression"] = value


@dataclass(frozen=True, kw_only=True)
class ClosedForm:
    """A solution ``U(xi, tau)``, or ``U(xi, zeta, tau)``, of ``equation``, written once.

    ``expression`` is the canonical form, as printed, or a function that builds it on first use. It
    is complex if the equation is, with I only in sums, products and exponentials. ``background`` is
    the bare wave of the same phase that the figures subtract (zero for a bare wave itself);
    ``period`` is the background's period in ``xi``, None if it is constant. ``stabilise`` returns
    the form for floating-point evaluation. ``evaluator`` returns, from exact parameters, an
    evaluator (``solutions.run.evaluator.PointEvaluator``) if the stable expression is not used.
    ``potential`` is an integral of U over xi that is constant on the left, for waves with zeta: the
    displacements of a lattice follow it. ``module`` is the form's module in the catalogue.
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
    _pickle_call: tuple[Any, ...] | None = field(
        default=None, init=False, compare=False, repr=False
    )

    def __post_init__(self) -> None:
        for name in ("name", "title"):
            instance(name, getattr(self, name), str, "such as 'kink'")
        instance("equation", self.equation, Equation, "FOCUSING_MKDV is one")
        for parameter in self.parameters:
            remedy = "Parameter(longwave.solutions.symbols.k)"
            instance("each of parameters", parameter, Parameter, remedy)

    def with_pickle_call(self, maker: "Callable[..., ClosedForm]", *args: object) -> "ClosedForm":
        """Set the call ``maker(*args)`` that rebuilds this form on unpickling; return the form."""
        object.__setattr__(self, "_pickle_call", (maker, args))
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        if self._pickle_call is not None:
            return self._pickle_call
        names = (entry.name for entry in fields(self) if entry.init)
        return partial(ClosedForm, **{name: getattr(self, name) for name in names}), ()

    def __repr__(self) -> str:
        domains = "".join(f", {parameter.domain}" for parameter in self.parameters)
        return f"<ClosedForm {self.name}: {self.title}{domains}>"

    def _repr_latex_(self) -> str | None:
        """Return the LaTeX for notebooks; None if it is too long, so that the repr is shown."""
        formula = latex_of(self.expression)
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
        """Return the exact parameter values. Raises ValueError for missing, unknown or bad ones."""
        known = [parameter.name for parameter in self.parameters]
        for name in values:
            if name not in known:
                accepted = f"it takes {', '.join(known) or 'no parameters'}"
                raise ValueError(
                    f"parameters must be those of {self.name}, got {name!s:.60} "
                    f"({' '.join(filter(None, (did_you_mean(name, known), accepted)))})"
                )
        return {parameter.symbol: parameter.check(values) for parameter in self.parameters}
