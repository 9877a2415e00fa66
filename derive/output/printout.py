"""Lines of ``longwave derive`` for long waves: a reduction, linear waves, numbers, checks."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from typing import Any

from sympy import Expr, I, S, Symbol

from longwave.derive.algebra.formula_printing import latex_of, text_of
from longwave.derive.balances import about_mean, best_balance, find_scaling
from longwave.derive.direction import DRIFT, read_direction, slow_variables
from longwave.derive.dispersion import (
    agrees_with_reduction,
    dispersion_relation,
    long_wave_of_reduction,
)
from longwave.derive.expected_derivation import CHEAPER_ORDER, reduction_seconds
from longwave.derive.intervals import Interval, intervals_of_reduction
from longwave.derive.lattice import Lattice
from longwave.derive.lattice_file import find_lattice
from longwave.derive.linear_waves import LinearWaves
from longwave.derive.models.lattices import FPUT_STRAIN
from longwave.derive.models.mkdv import initial_velocity, initial_velocity_latex
from longwave.derive.multiscale import FURTHER_ORDERS, ReductionError, reduce
from longwave.derive.output import derive_options
from longwave.derive.output.notation import aligned
from longwave.derive.output.own_names import unused
from longwave.derive.output.report import head_lines
from longwave.derive.reduction import Reduction, reduction_data
from longwave.derive.scaling import Scaling, SlowVariable
from longwave.derive.symbols import eps
from longwave.support.command_line import check_and_announce, fail
from longwave.support.user_files import shown

MOST_ORDERS = 13
"""Largest value of --order."""

LARGEST_DENOMINATOR = 1000
"""Largest denominator of a measured value that is printed as a fraction."""


def print_derivation(options: derive_options.DeriveOptions) -> int:
    """Print a derivation; return the exit status (1 if a check differs, 2 for wrong input)."""
    try:
        if options.check and options.form != "text":
            raise ValueError(f"--{options.form} must be left out with check (it prints text only)")
        lattice = _with_losses(find_lattice(options.model or FPUT_STRAIN.name), options.losses)
        if options.carrier is not None:
            from longwave.derive.output.carrier_printout import carrier_lines

            lines = list(carrier_lines(lattice, options))
        else:
            for option, given in (("--branch", options.branch), ("--map", options.points)):
                if given is not None:
                    raise ValueError(f"{option} must come with --envelope, got {given!r} alone")
            lines = list(_reduction_lines(lattice, options))
    except (ValueError, OSError) as error:
        return fail(error)
    if options.form == "latex":
        lines = [*(f"% not an energy: {line}" for line in lattice.missing_energies), *lines]
    print("\n".join(lines))
    return int(options.check and any(line.startswith("DIFFERS") for line in lines))


def _with_losses(lattice: Lattice, texts: Mapping[str, str]) -> Lattice:
    """Return the lattice with the losses in ``texts``: site, bond, site.FIELD or bond.NUMBER."""
    losses: dict[str, Any] = {}
    for name, value in texts.items():
        kind, dot, target = name.partition(".")
        if kind not in ("site", "bond") or (kind in losses and not (dot and kind not in texts)):
            raise ValueError(
                f"--losses must name site and bond, or site.FIELD and bond.NUMBER, each once, got "
                f"{shown(name)} (such as site=eps^3*gamma,bond=eps*eta)"
            )
        losses[kind] = {**losses.get(kind, {}), target: value} if dot else value
    return lattice.with_losses(**losses) if losses else lattice


# long waves


def _linear_lattice_lines(lattice: Lattice, options: derive_options.DeriveOptions) -> Iterator[str]:
    """Yield the waves of a linear chain: formulas, and numbers if all constants have values."""
    waves, given = LinearWaves.of(lattice), derive_options.given_constants(lattice, options)
    known = {*map(str, lattice.basic_constants)} == {*given}
    if unknown := sorted({*given} - {*map(str, lattice.basic_constants)}):
        waves.table({unknown[0]: given[unknown[0]]})
    rows = waves.table(given) if known else []
    if options.form == "json":
        branches = [text_of(value) for value in waves.branches]
        data = {"lattice": lattice.name, "equations": list(lattice.equations())}
        data |= {"relation": waves.relation(), "omega_squared": branches}
        waves_data = [[text_of(wavenumber), values] for wavenumber, values in rows]
        yield json.dumps({**data, "waves": waves_data}, indent=2)
    elif options.form == "latex":
        yield aligned([("", line) for line in waves.lines(latex_of)])
    else:
        yield from head_lines(lattice)
        yield "a linear lattice has no reduced equation; its waves exp(i (k n - omega t)):"
        yield from (f"  {line}" for line in waves.lines())
        if rows:
            branch_numbers = range(len(rows[0][1]))
            heads = ["k", *(h for i in branch_numbers for h in (f"omega {i}", f"d omega {i}/dk"))]
            yield "  " + "  ".join(f"{head:>14}" for head in heads)
        for wavenumber, pairs in rows:
            cells = ("meet" if v is None else f"{v:.10g}" for pair in pairs for v in pair)
            yield "  " + "  ".join(f"{cell:>14}" for cell in (text_of(wavenumber), *cells))


def _reduction_lines(lattice: Lattice, options: derive_options.DeriveOptions) -> Iterator[str]:
    is_plain = lattice.dimension == 1 and not (lattice.has_losses or options.check)
    if lattice.is_linear and is_plain:
        yield from _linear_lattice_lines(lattice, options)
        return
    try:
        reduction, values, refusal = _long_wave(lattice, options)
    except ReductionError as error:
        if lattice.missing_energies:
            raise ReductionError(
                f"{error}; not an energy: {lattice.missing_energies[0]} (forces without an energy "
                "drift or grow: let the action be minus the mirror of the stretch, or run the "
                "lattice itself)"
            ) from None
        is_printed = options.form == "text" and not options.check
        is_formula = lattice.dimension == len(lattice.fields) == 1
        if not (is_printed and is_formula and _has_finite_losses(lattice)):
            raise
        yield from head_lines(lattice)
        yield from _frequency_lines(lattice, S.Zero)
        yield f"no reduced equation: {error}"
        return
    if options.check:
        from longwave.derive.checks import Check, checks_of_reduction

        yield f"{lattice.name}: {reduction.pde.kind}: {reduction.pde.text()}"
        yield from map(Check.text, checks_of_reduction(reduction))
        return
    remaining = reduction.lattice.basic_constants
    measured, note = derive_options.measured_with_options(lattice, remaining, values, options)
    intervals = {} if measured is None else intervals_of_reduction(reduction, measured)
    numbers = list(_number_lines(reduction, values, intervals, note))
    is_paper = reduction.lattice == FPUT_STRAIN and reduction.scaling == Scaling()
    if options.form == "json":
        data = reduction_data(reduction, values)
        if intervals:
            data["intervals"] = {name: asdict(found) for name, found in intervals.items()}
        yield json.dumps(data, indent=2)
    elif options.form == "latex":
        yield reduction.latex(**values)
        if is_paper:
            rows = (*dispersion_relation(reduction.lattice).latex(), initial_velocity_latex())
            yield aligned([("", row) for row in rows])
    else:
        yield reduction.text()
        if is_paper:
            yield from _linear_lines(reduction)
        yield from _decay_lines(reduction)
        if law := reduction.amplitude_law(**values):
            taken = reduction.lattice.names
            crest = unused("a", taken)
            yield f"amplitude law of a soliton's crest {crest}: {law.text_beside(taken)}"
        yield from numbers
        if refusal:
            scaling = reduction.scaling
            yield f"found: amplitude {scaling.amplitude}, time {scaling.time}, as the usual ansatz"
            yield f"  is refused: {refusal}"


def _long_wave(
    lattice: Lattice, options: derive_options.DeriveOptions
) -> tuple[Reduction, Mapping[str, Expr], str]:
    """Return the reduction, values of its symbols, and why the usual ansatz failed, or "".

    Under the usual ansatz constants are symbols, except small ones.  If the values contradict it,
    they are all substituted first, as in a scene, and a balanced ansatz is searched.
    """
    given = derive_options.given_constants(lattice, options)
    space, direction_values = _space(lattice, options, given)
    unfelt = {*map(str, lattice.unfelt_constants)}
    substituted = {n: value for n, value in given.items() if value.has(eps) or n in unfelt}
    remaining = {n: value for n, value in given.items() if n not in substituted}
    remaining |= direction_values
    symbolic = _Ansatz.of(lattice, options, space, substituted)
    usual, refusal = None, ""
    try:
        is_paper = options.model in (None, FPUT_STRAIN.name)
        usual = _admitted(symbolic.usual(is_paper=is_paper), remaining)
    except ValueError as error:
        if symbolic.is_given or not given:
            raise
        refusal = str(error)
    if usual is None or not (usual.is_balanced or symbolic.is_given or not given):
        with suppress(ValueError):
            numeric = _Ansatz.of(lattice, options, space, given)
            return numeric.found(direction_values), direction_values, refusal
    if usual is None:
        raise ValueError(refusal)
    return usual, remaining, ""


def _admitted(reduction: Reduction, values: Mapping[str, Expr]) -> Reduction:
    """Return the reduction. Raises ValueError if the values violate its conditions."""
    reduction.coefficients(**values)
    if reduction.has_normal_form:
        reduction.normal_form(**values)
    return reduction


@dataclass(frozen=True)
class _Ansatz:
    """A lattice about a mean, and its ansatz; parts of the ansatz that are None are sought."""

    lattice: Lattice
    mean: Expr
    space: tuple[SlowVariable, ...]
    amplitude: int | None
    time: int | None
    orders: int | None

    @classmethod
    def of(
        cls,
        lattice: Lattice,
        options: derive_options.DeriveOptions,
        space: tuple[SlowVariable, ...],
        constants: Mapping[str, Expr],
    ) -> _Ansatz:
        """Return the ansatz that the options give, with constants substituted."""
        return cls(
            *about_mean(lattice, options.background or 0, constants),
            space,
            derive_options.count("--amplitude", options.amplitude, 8),
            derive_options.count("--time", options.time, 9),
            derive_options.count("--order", options.orders, MOST_ORDERS),
        )

    @property
    def is_given(self) -> bool:
        """Whether both amplitude and time are given."""
        return self.amplitude is not None and self.time is not None

    def usual(self, *, is_paper: bool) -> Reduction:
        """Reduce under the given ansatz, else the paper's (if ``is_paper``) or the best balance.

        If only one of amplitude and time is given, the other has its usual value.
        """
        nothing_given = self.amplitude is None and self.time is None
        if is_paper and nothing_given and not self.mean:
            return reduce(self.lattice, orders=self.orders)
        _check_cost(self.lattice, FURTHER_ORDERS)
        if nothing_given:
            further = FURTHER_ORDERS if self.orders is None else 0
            balanced = best_balance(self.lattice, self.mean, further, self.space)
            return balanced if self.orders is None else self._reduced(balanced.scaling)
        scaling = Scaling()
        if self.lattice.dimension > 1:
            scaling = best_balance(self.lattice, self.mean, space=self.space).scaling
        amplitude = scaling.amplitude if self.amplitude is None else self.amplitude
        time = scaling.time if self.time is None else self.time
        background = ((0, self.mean),) if self.mean else ()
        return self._reduced(Scaling(amplitude, scaling.space, time, background))

    def found(self, values: Mapping[str, Expr]) -> Reduction:
        """Return the first balanced reduction that admits the values. Raises ValueError if none."""
        arguments = (self.mean, self.amplitude, self.time)
        for candidate in find_scaling(self.lattice, *arguments, space=self.space):
            with suppress(ValueError):
                return _admitted(self._reduced(candidate.scaling), values)
        raise ReductionError(f"no ansatz of {self.lattice.name} admits the constants")

    def _reduced(self, scaling: Scaling) -> Reduction:
        further = 0 if self.orders is None else self.orders - scaling.leading_order
        _check_cost(self.lattice, further)
        return reduce(self.lattice, scaling, self.orders)


def _space(
    lattice: Lattice, options: derive_options.DeriveOptions, values: Mapping[str, Expr]
) -> tuple[tuple[SlowVariable, ...], Mapping[str, Expr]]:
    """Return the slow variables of the requested direction, and values of the symbols in them."""
    if options.direction is None:
        return (), {}
    space, direction_values = slow_variables(lattice, read_direction(options.direction))
    for name in (*direction_values, *([str(DRIFT)] if direction_values else [])):
        if name in values:
            raise ValueError(f"{name} must not be given, got {values[name]} (--direction gives it)")
    return space, direction_values


def _check_cost(lattice: Lattice, further: int) -> None:
    seconds = reduction_seconds(lattice, further)
    check_and_announce(f"derivation of {lattice.name}", seconds, cheaper=CHEAPER_ORDER)


def _linear_lines(reduction: Reduction) -> Iterator[str]:
    relation = dispersion_relation(reduction.lattice)
    yield ""
    yield "linear waves about the uniform strain ybar:"
    yield f"  omega^2 = {text_of(relation.omega_squared)}"
    yield f"  omega_+ = {text_of(relation.omega_plus)}"
    yield f"          = {text_of(relation.long_wave())} + O(k^5)"
    agrees = agrees_with_reduction(reduction.lattice, reduction)
    yield f"  same as the reduced equation's linear part to k^3: {'yes' if agrees else 'NO'}"
    yield f"initial velocity: s = {text_of(initial_velocity())}"


def _decay_lines(reduction: Reduction) -> Iterator[str]:
    """Yield lines of a chain with losses: complex frequencies, and whether the reduction agrees."""
    if not reduction.lattice.has_losses or reduction.lattice.dimension > 1:
        return
    yield from _frequency_lines(reduction.lattice, reduction.scaling.mean)
    with suppress(ValueError):
        omega = long_wave_of_reduction(reduction)
        decay = text_of(-omega.coeff(I))
        yield f"  omega = {text_of(omega.xreplace({I: S.Zero}))} - i ({decay}) of long waves"
        agrees = agrees_with_reduction(reduction.lattice, reduction)
        yield f"  same as the reduced equation's linear part: {'yes' if agrees else 'NO'}"


def _frequency_lines(lattice: Lattice, mean: Expr) -> Iterator[str]:
    """Yield a heading and, for a lattice with one field, formulas of the complex frequencies."""
    yield ""
    yield "linear waves with losses, exp(i (k n - omega t)):"
    if len(lattice.fields) > 1:
        return
    relation, gamma = dispersion_relation(lattice).at(mean), Symbol("Gamma(k)")
    yield f"  omega^2 + i {gamma} omega = {text_of(relation.omega_squared)}"
    yield f"  {gamma} = {text_of(relation.damping)}"
    if _has_finite_losses(lattice):
        root = replace(relation, damping=gamma).omega + I * gamma / 2
        yield f"  omega = {text_of(root)} - i {gamma}/2"
    else:
        yield f"  omega = {text_of(relation.omega_plus)} - i {gamma}/2 + O({gamma}^2)"


def _has_finite_losses(lattice: Lattice) -> bool:
    return any(power == 0 for _, power in lattice.leading_losses.values())


def _number_lines(
    reduction: Reduction, values: Mapping[str, Expr], intervals: Mapping[str, Interval], note: str
) -> Iterator[str]:
    def written(name: str, value: Expr) -> str:
        return intervals[name].text() if name in intervals else text_of(value)

    coefficients = reduction.coefficients(**values)
    format_value = _decimal if note else str
    given = ", ".join(f"{name} = {format_value(value)}" for name, value in values.items())
    yield ""
    yield f"coefficients{' at ' + given if given else ''}:"
    if note:
        yield f"  {note}"
    yield f"  c = {written('c', coefficients.c)}"
    for name, value in coefficients.terms.items():
        yield f"  of {name}: {written(name, value)}"
    if reduction.has_normal_form:
        form = reduction.normal_form(**values)
        yield from form.lines(reduction.lattice.names, written)
        if form.name not in (form.equation, reduction.pde.kind):
            yield f"  {form.name}"


def _decimal(value: Expr) -> str:
    """Format a value; a ratio with a denominator above `LARGEST_DENOMINATOR` gets 6 digits."""
    is_long = value.is_Rational and value.q > LARGEST_DENOMINATOR
    return f"{float(value):.6g}" if is_long else str(value)
