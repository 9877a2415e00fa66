"""What ``longwave derive`` prints: a reduction or an envelope, linear waves, numbers, checks."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from sympy import Expr

from derive.algebra.exact_numbers import Number, exact, parse_rational, shown
from derive.algebra.formula_text import Vocabulary, read_formula
from derive.balances import find_scaling
from derive.command_line import fail
from derive.dispersion import agrees_with_reduction, dispersion_relation
from derive.lattice import Lattice
from derive.lattice_file import read_lattice
from derive.models.lattices import FPUT_STRAIN, LATTICES
from derive.models.mkdv import initial_velocity, initial_velocity_latex
from derive.multiscale import reduce
from derive.normal_form import NORMAL_EQUATIONS
from derive.output.notation import aligned, text_of
from derive.reduction import Reduction
from derive.scaling import Scaling

if TYPE_CHECKING:
    from derive.carrier_envelope import Envelope, EnvelopeNumbers

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
    form: str = "text"
    check: bool = False


def print_derivation(wanted: Wanted) -> int:
    """Print it; returns the exit status (1 if a check differs, 2 for wrong input)."""
    try:
        lattice = _lattice(wanted.model)
        values: dict[str, Number] = {n: parse_rational(n, t) for n, t in wanted.constants.items()}
        if wanted.carrier is not None:
            lines = list(_envelope_lines(lattice, wanted, values))
        else:
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
    if model.endswith(".toml"):
        return read_lattice(Path(model))
    raise ValueError(
        f"MODEL must be a lattice or a file of one, got {shown(model)} (one of "
        f"{', '.join(LATTICES)}; or FILE.toml)"
    )


# long waves


def _reduction_lines(lattice: Lattice, wanted: Wanted, values: dict[str, Number]) -> Iterator[str]:
    reduction = _reduction(lattice, wanted)
    if wanted.check:
        from derive.checks import Check, checks_of_reduction

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


def _reduction(lattice: Lattice, wanted: Wanted) -> Reduction:
    """The reduction that is asked for, or else the first that balances the lattice."""
    orders = None if wanted.orders is None else _count("--orders", wanted.orders, MOST_ORDERS)
    mean: tuple[tuple[int, Expr], ...] = ()
    if wanted.background is not None:
        value = exact("background", wanted.background)
        mean = ((0, value),) if value else ()
    asked = (wanted.amplitude, wanted.time)
    if lattice is FPUT_STRAIN and asked == (None, None) and not mean:
        return reduce(lattice, orders=orders)
    scalings = [Scaling()]
    if lattice.dimension > 1 or (asked == (None, None) and not mean):
        scalings = [found.scaling for found in find_scaling(lattice)]
    chosen = scalings[0]
    amplitude = _count("--amplitude", wanted.amplitude or str(chosen.amplitude + bool(mean)), 8)
    time = _count("--time", wanted.time or str(chosen.time), 9)
    return reduce(lattice, Scaling(amplitude, chosen.space, time, mean), orders)


def _count(option: str, text: str, most: int) -> int:
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


# envelopes


def _envelope_lines(lattice: Lattice, wanted: Wanted, values: dict[str, Number]) -> Iterator[str]:
    from derive.carrier_envelope import envelope
    from derive.checks import Check, checks_of_envelope

    for option, given in (
        ("--background", wanted.background),
        ("--amplitude", wanted.amplitude),
        ("--time", wanted.time),
        ("--orders", wanted.orders),
    ):
        if given is not None:
            raise ValueError(f"{option} must be left out with --envelope, got {given!r}")
    chosen = _carrier(wanted.carrier or "")
    branch = wanted.branch or "acoustic"
    found = envelope(
        lattice,
        k=chosen,
        branch=int(branch) if branch.isdecimal() and len(branch) < 4 else branch,
        **(values if chosen is not None and not lattice.definitions else {}),
    )
    if wanted.check:
        yield found.text()
        yield from map(Check.text, checks_of_envelope(found))
        return
    numbers = found.coefficients(chosen, None, **values) if chosen is not None and values else None
    if wanted.form == "json":
        data = json.loads(found.json())
        if numbers:
            data["numbers"] = {name: _plain(value) for name, value in asdict(numbers).items()}
        yield json.dumps(data, indent=2)
    elif wanted.form == "latex":
        yield found.latex()
    else:
        yield lattice.title
        yield from (f"  {line}" for line in lattice.equations())
        yield f"carrier: {lattice.fields[0]} = eps A(X, T) exp(i (k n - omega t)) + c.c. + ..."
        yield "  X = eps (n - v t), T = eps^2 t"
        yield from _carrier_lines(found, numbers, chosen)


def _carrier_lines(
    found: Envelope, numbers: EnvelopeNumbers | None, at: Expr | None
) -> Iterator[str]:
    if numbers is None:
        yield from found.lines()
        return
    yield f"i A_T + p A_XX + q |A|^2 A = 0 at k = {at}:"
    yield from (f"  {name} = {_rounded(value)}" for name, value in asdict(numbers).items())
    kind = "unstable, solitons bright" if numbers.is_focusing else "stable, solitons dark"
    yield f"plane waves are {kind}: p q {'>' if numbers.is_focusing else '<'} 0"


def _carrier(text: str) -> Expr | None:
    """The wavenumber of ``k=pi``, ``k=pi/2`` or ``k=1.2``; None for ``k``."""
    name, _, value = text.replace(" ", "").partition("=")
    if name != "k":
        raise ValueError(f"--envelope must be k or k=NUMBER, got {shown(text)} (such as k=pi)")
    if not value:
        return None
    try:
        found = read_formula(value, Vocabulary({}), "k")
    except ValueError as error:
        raise ValueError(f"--envelope: {error}") from None
    from derive.carrier_envelope import wavenumber

    return wavenumber(found)


def _plain(value: complex) -> float | list[float]:
    return [value.real, value.imag] if isinstance(value, complex) else value


def _rounded(value: complex) -> str:
    return f"{value:.12g}"
