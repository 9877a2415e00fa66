"""What ``longwave derive`` prints of long waves: a reduction, linear waves, numbers, checks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from sympy import S

from longwave.derive.algebra.exact_numbers import Number, exact, parse_rational
from longwave.derive.balances import best_balance
from longwave.derive.direction import DRIFT, read_direction, slow_variables
from longwave.derive.dispersion import agrees_with_reduction, dispersion_relation
from longwave.derive.expected_derivation import CHEAPER_ORDER, reduction_seconds
from longwave.derive.lattice import Lattice
from longwave.derive.lattice_file import read_lattice
from longwave.derive.models.lattices import FPUT_STRAIN, LATTICES
from longwave.derive.models.mkdv import initial_velocity, initial_velocity_latex
from longwave.derive.multiscale import FURTHER_ORDERS, reduce
from longwave.derive.normal_form import NORMAL_EQUATIONS
from longwave.derive.output.notation import aligned, text_of
from longwave.derive.reduction import Reduction
from longwave.derive.scaling import Scaling, SlowVariable
from longwave.support.command_line import check_and_announce, fail
from longwave.support.known_names import one_of
from longwave.support.user_files import STANDARD_INPUT, shown

MOST_ORDERS = 13


@dataclass(frozen=True)
class Wanted:
    """What the command line asks for, as text: None where it says nothing."""

    model: str | None = None
    constants: Mapping[str, str] = field(default_factory=dict)
    background: str | None = None
    amplitude: str | None = None
    time: str | None = None
    orders: str | None = None
    carrier: str | None = None
    branch: str | None = None
    points: str | None = None
    direction: str | None = None
    form: str = "text"
    check: bool = False


def print_derivation(wanted: Wanted) -> int:
    """Print it; returns the exit status (1 if a check differs, 2 for wrong input)."""
    try:
        if wanted.check and wanted.form != "text":
            raise ValueError(f"--{wanted.form} must be left out with check, got it (it is text)")
        lattice = _lattice(wanted.model)
        values: dict[str, Number] = {n: parse_rational(n, t) for n, t in wanted.constants.items()}
        if wanted.carrier is not None:
            from longwave.derive.output.carrier_printout import carrier_lines

            lines = list(carrier_lines(lattice, wanted, values))
        else:
            _check_carrier_options(wanted)
            lines = list(_reduction_lines(lattice, wanted, values))
    except (ValueError, OSError) as error:
        return fail(error)
    print("\n".join(lines))
    return int(wanted.check and any(line.startswith("DIFFERS") for line in lines))


def _lattice(model: str | None) -> Lattice:
    if model is None:
        return FPUT_STRAIN
    if model in LATTICES:
        return LATTICES[model]
    if model.endswith(".toml") or model == STANDARD_INPUT:
        return read_lattice(Path(model))
    raise ValueError(
        f"MODEL must be a lattice or a file of one, got {shown(model)} "
        f"({one_of(model, LATTICES)}; or FILE.toml)"
    )


# long waves


def _reduction_lines(lattice: Lattice, wanted: Wanted, values: dict[str, Number]) -> Iterator[str]:
    space, along = _space(lattice, wanted, values)
    values = {**values, **along}
    reduction = _reduction(lattice, wanted, space)
    if wanted.check:
        from longwave.derive.checks import Check, checks_of_reduction

        yield f"{lattice.name}: {reduction.pde.kind}: {reduction.pde.text()}"
        yield from map(Check.text, checks_of_reduction(reduction))
        return
    numbers = list(_number_lines(reduction, values))
    is_paper = lattice is FPUT_STRAIN and reduction.scaling == Scaling()
    if wanted.form == "json":
        yield reduction.json(**values)
    elif wanted.form == "latex":
        yield reduction.latex(**values)
        if is_paper:
            yield _linear_latex(reduction)
    else:
        yield reduction.text()
        if is_paper:
            yield from _linear_lines(reduction)
        yield from numbers


def _space(
    lattice: Lattice, wanted: Wanted, values: Mapping[str, Number]
) -> tuple[tuple[SlowVariable, ...], Mapping[str, Number]]:
    """The slow variables of the direction that is asked for, and the values that it has."""
    if wanted.direction is None:
        return (), {}
    space, along = slow_variables(lattice, read_direction(wanted.direction))
    for name in (*along, *([str(DRIFT)] if along else [])):
        if name in values:
            raise ValueError(f"{name} must not be given, got {values[name]} (--direction gives it)")
    return space, along


def _reduction(lattice: Lattice, wanted: Wanted, space: tuple[SlowVariable, ...]) -> Reduction:
    """The reduction that is asked for, or else the first that balances the lattice."""
    orders = None if wanted.orders is None else count("--order", wanted.orders, MOST_ORDERS)
    mean = exact("background", wanted.background or 0)
    asked = (wanted.amplitude, wanted.time)
    if lattice is FPUT_STRAIN and asked == (None, None) and not mean:
        return reduce(lattice, orders=orders)
    _check_cost(lattice, FURTHER_ORDERS)
    if mean and len(lattice.fields) == 1 and lattice.is_displacement:
        lattice, mean = lattice.strained(mean), S.Zero
    if asked == (None, None):
        found = best_balance(lattice, mean, FURTHER_ORDERS if orders is None else 0, space)
        if orders is None:
            return found
        usual = found.scaling
    else:
        is_line = lattice.dimension == 1
        usual = Scaling() if is_line else best_balance(lattice, mean, space=space).scaling
    amplitude = count("--amplitude", wanted.amplitude or str(usual.amplitude), 8)
    time = count("--time", wanted.time or str(usual.time), 9)
    background = ((0, mean),) if mean else ()
    scaling = Scaling(amplitude, usual.space, time, background)
    _check_cost(lattice, 0 if orders is None else orders - scaling.leading_order)
    return reduce(lattice, scaling, orders)


def _check_cost(lattice: Lattice, further: int) -> None:
    seconds = reduction_seconds(lattice, further)
    check_and_announce(f"derivation of {lattice.name}", seconds, cheaper=CHEAPER_ORDER)


def _check_carrier_options(wanted: Wanted) -> None:
    for option, given in (("--branch", wanted.branch), ("--map", wanted.points)):
        if given is not None:
            raise ValueError(f"{option} must come with --envelope, got {given!r} alone")


def count(option: str, text: str, most: int) -> int:
    """The number of an option; ValueError unless it is one up to ``most``."""
    if not (text.isascii() and text.isdigit() and len(text) < 4 and int(text) <= most):
        raise ValueError(
            f"{option} must be an integer <= {most}, got {text!r} (leave it for the default)"
        )
    return int(text)


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


def _linear_latex(reduction: Reduction) -> str:
    rows = [*dispersion_relation(reduction.lattice).latex(), initial_velocity_latex()]
    return aligned([("", row) for row in rows])


def _number_lines(reduction: Reduction, values: dict[str, Number]) -> Iterator[str]:
    coefficients = reduction.coefficients(**values)
    given = ", ".join(f"{name} = {value}" for name, value in values.items())
    yield ""
    yield f"coefficients{' at ' + given if given else ''}:"
    yield f"  c = {text_of(coefficients.c)}"
    yield from (f"  of {name}: {text_of(value)}" for name, value in coefficients.terms.items())
    if reduction.has_normal_form:
        form = reduction.normal_form(**values)
        yield f"normal form {NORMAL_EQUATIONS[form.equation].text}, {form.map_text}:"
        yield from (f"  {name} = {text_of(value)}" for name, value in form.values.items())
