"""Lines of ``longwave derive --envelope``: an envelope, its numbers, checks, or a map of k."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from sympy import Expr, Rational, pi

from longwave.derive.algebra.exact_numbers import Number
from longwave.derive.algebra.formula_printing import latex_of, text_of
from longwave.derive.carrier import NLS
from longwave.derive.carrier_envelope import (
    COEFFICIENT_LATEX,
    NEXT_ORDER,
    Envelope,
    EnvelopeNumbers,
    envelope,
    modulation_map,
    wavenumber,
)
from longwave.derive.checks import Check, checks_of_envelope, simple_numbers
from longwave.derive.expected_derivation import CHEAPER_CARRIER, envelope_seconds
from longwave.derive.intervals import Interval, Intervals
from longwave.derive.lattice import Lattice
from longwave.derive.normal_form import NormalForm, normal_form_of
from longwave.derive.output.derive_options import (
    DeriveOptions,
    count,
    given_constants,
    measured_with_options,
)
from longwave.derive.output.notation import aligned
from longwave.derive.output.own_names import marked, unused
from longwave.derive.output.report import form_data, head_lines
from longwave.derive.symbols import eps
from longwave.support.command_line import check_and_announce
from longwave.support.user_files import shown

if TYPE_CHECKING:
    Values = Mapping[str, Number]

MOST_POINTS = 200
"""Largest value of --map, the number of wavenumbers."""


def carrier_lines(lattice: Lattice, options: DeriveOptions) -> Iterator[str]:
    """Yield the lines that the options request. Raises ValueError for wrong options."""
    for option in ("background", "amplitude", "time", "direction"):
        if (given := getattr(options, option)) is not None:
            raise ValueError(f"--{option} must be left out with --envelope, got {given!r}")
    if options.orders not in (None, "3", "4"):
        raise ValueError(
            f"--order must be 3 (the NLS equation) or 4 (its correction) with --envelope, got "
            f"{options.orders!r}"
        )
    constants = given_constants(lattice, options)
    lattice = lattice.with_values({n: value for n, value in constants.items() if value.has(eps)})
    values = {name: value for name, value in constants.items() if not value.has(eps)}
    angle = _carrier(options.carrier or "")
    text = options.branch or "acoustic"
    branch = int(text) if text.isdecimal() and len(text) < 4 else text
    at_pi = angle == pi and options.points is None and not options.check
    constants_known = len(lattice.constants) if options.check else len(values)
    seconds = envelope_seconds(lattice, at_pi, 0 if lattice.definitions else constants_known)
    check_and_announce(f"envelope of {lattice.name}", seconds, cheaper=CHEAPER_CARRIER)
    if options.points is not None:
        yield from _map_lines(lattice, options, angle, branch, values)
    elif options.check:
        yield from _check_lines(lattice, branch, values)
    else:
        yield from _lines(lattice, options, angle, branch, values)


def _check_lines(lattice: Lattice, branch: str | int, values: Values) -> Iterator[str]:
    """Yield lines of an envelope's checks, with k a symbol.

    Without ``values``, the constants are small primes if a cell has several fields.
    """
    values_used = values
    if len(lattice.fields) > 1 and not values:
        values_used = {str(s): value for s, value in simple_numbers(lattice.constants).items()}
    result = envelope(lattice, branch=branch, **({} if lattice.definitions else values_used))
    values_text = ", ".join(f"{name} = {value}" for name, value in values_used.items())
    yield f"{lattice.name}: {result.equation}{' at ' + values_text if values_text else ''}"
    yield from map(Check.text, checks_of_envelope(result))


def _lines(
    lattice: Lattice, options: DeriveOptions, angle: Expr | None, branch: str | int, values: Values
) -> Iterator[str]:
    substituted = {} if lattice.definitions else values
    result = envelope(lattice, k=angle, branch=branch, **substituted)
    names = [n for n in result.parts if options.orders != str(NLS) or n not in NEXT_ORDER]
    numbers = None
    if angle is not None and (values or not lattice.basic_constants):
        result = result.regular(angle, None, **values)
        numbers = result.coefficients(angle, None, **values)
    has_form = numbers and numbers.q and not lattice.has_losses
    form = result.normal_form(angle, None, **values) if has_form else None
    intervals, word = _intervals(lattice, result, values, options) if numbers else ({}, "")
    if options.form == "json":
        data = _data(result, names, numbers, form)
        if intervals:
            data["intervals"] = {name: asdict(interval) for name, interval in intervals.items()}
        yield json.dumps(data, indent=2)
    elif options.form == "latex":
        yield _latex(result, names, numbers)
    else:
        yield from _texts(result, names, numbers, form, angle, intervals, word)


def _intervals(
    lattice: Lattice, result: Envelope, values: Values, options: DeriveOptions
) -> tuple[dict[str, Interval], str]:
    """Return the coefficients' intervals by name, and a note on them or on why there are none."""
    if lattice.measured is None:
        return {}, ""
    if len(lattice.fields) > 1:
        return {}, "(no intervals: they are for one field in a cell)"
    measured, word = measured_with_options(lattice, lattice.basic_constants, values, options)
    if measured is None:
        return {}, word
    symbolic = envelope(lattice, k=result.wavenumber) if result.constants else result
    numbers = symbolic.in_constants
    form = normal_form_of(numbers["v"], {"A_XX": numbers["p"], "|A|^2 A": numbers["q"]})
    intervals = Intervals(measured, lattice.basic_constants)
    return {name: intervals.of(value) for name, value in {**numbers, **form.values}.items()}, word


def _data(
    result: Envelope, names: list[str], numbers: EnvelopeNumbers | None, form: NormalForm | None
) -> dict[str, Any]:
    data = {
        "lattice": result.lattice.name,
        "equation": result.equation,
        "missing_energies": list(result.lattice.missing_energies),
        "k": None if result.wavenumber is None else text_of(result.wavenumber),
        "branch": result.branch,
        "fixed": str(result.carrier.fixed),
        "constants": {str(s): text_of(value) for s, value in result.constants.items()},
    }
    if numbers is None:
        wave = {"wave": result.frequency_text()} if len(result.carrier.waves) > 1 else {}
        formulas = result.expressions_of(names).items()
        return {**data, **wave, **{name: text_of(value) for name, value in formulas}}
    items = ((name, v) for name, v in asdict(numbers).items() if name in ("omega", *names))
    values = {name: [v.real, v.imag] if isinstance(v, complex) else v for name, v in items}
    normal = {"normal_form": {**form_data(form), "digits": form.digits}} if form else {}
    return {**data, "numbers": values, **normal}


def _latex(result: Envelope, names: list[str], numbers: EnvelopeNumbers | None) -> str:
    taken = result.lattice.names - {*result.lattice.fields}
    equation = marked(result.equation_latex, ("A", "i", "p", "q"), taken)
    rows = [("", re.sub(r"(\w)~", r"\\tilde{\1}", equation))]
    if numbers is None:
        values = {name: latex_of(value) for name, value in result.expressions_of(names).items()}
        if len(result.carrier.waves) > 1:
            rows.append(("", result.frequency_text(latex_of)))
    else:
        rounded = {name: _rounded(value) for name, value in asdict(numbers).items()}
        values = {name: rounded[name] for name in ("omega", *names)}
    for name, value in values.items():
        label = COEFFICIENT_LATEX[name]
        label = rf"\tilde{{{label}}}" if name in taken else label
        rows.append(("", f"{label} = {value}"))
    return aligned(rows)


def _texts(
    result: Envelope,
    names: list[str],
    numbers: EnvelopeNumbers | None,
    form: NormalForm | None,
    angle: Expr | None,
    intervals: Mapping[str, Interval],
    word: str,
) -> Iterator[str]:
    lattice, names_taken = result.lattice, result.lattice.names - {*result.lattice.fields}

    def renamed(text: str) -> str:
        return marked(text, ("A", "i", "X", "T", "omega", *result.parts), names_taken)

    yield from head_lines(lattice)
    carried = "eps A(X, T) exp(i (k n - omega t)) + c.c. + ..."
    yield renamed(f"carrier: {lattice.fields[result.carrier.leader]}_n = {carried}")
    yield renamed("  X = eps (n - v t), T = eps^2 t")
    if numbers is None:
        location = "" if angle is None else f" at k = {text_of(angle)}"
        yield renamed(f"{result.equation}{location}:")
        yield from (f"  {message}" for message in result.idle_losses)
        if (count_of_waves := len(result.carrier.waves)) > 1:
            yield f"  of the wave with {result.frequency_text()}, one of {count_of_waves}: on which"
            yield "  branch it is depends on the constants (--branch takes another)"
        yield f"  {renamed('omega')}^2 gives {result.carrier.fixed}, which is eliminated"
        formulas = result.expressions_of(names).items()
        yield from (f"  {renamed(name)} = {text_of(value)}" for name, value in formulas)
        for symbol, value in result.carrier.lattice.definitions:
            yield f"  where {symbol} = {text_of(value.subs(result.constants))}"
        return
    yield f"{renamed(result.equation)} at k = {angle}:"
    yield from (f"  {message}" for message in result.idle_losses)
    if word:
        yield f"  {word}"
    values = asdict(numbers)

    def written(name: str, value: Any) -> str:
        return intervals[name].text() if name in intervals else _rounded(value)

    yield from (f"  {renamed(name)} = {written(name, values[name])}" for name in ("omega", *names))
    kind = "unstable, solitons bright" if numbers.is_focusing else "stable, solitons dark"
    if not numbers.q:
        yield "q = 0: waves do not interact at this order, there are no solitons"
        return
    if form is None:
        if numbers.is_focusing:
            crest, law = unused("a", names_taken), result.amplitude_law.text_beside(names_taken)
            yield f"amplitude law of a bright soliton's crest {crest}: {law}"
        return
    yield f"plane waves are {kind}: {renamed('p q')} {'>' if numbers.is_focusing else '<'} 0"
    yield from form.lines(names_taken, lambda name, value: written(name, float(value)))


# the map


def _map_lines(
    lattice: Lattice, options: DeriveOptions, angle: Expr | None, branch: str | int, values: Values
) -> Iterator[str]:
    """Yield p, q and the growth rate at equally spaced wavenumbers up to pi."""
    points = count("--map", options.points, MOST_POINTS)
    if angle is not None or not points:
        raise ValueError(
            f"--map must be 1 or more, with --envelope k, got --map {points} with --envelope "
            f"{options.carrier} (it takes the wavenumbers i pi/{points or 'N'})"
        )
    wavenumbers = [pi * Rational(i, points) for i in range(1, points + 1)]
    rows = modulation_map(lattice, wavenumbers, branch, 1.0, **values)
    if options.form == "json":
        data = {"lattice": lattice.name, "map": [_row_data(*row) for row in rows]}
        yield json.dumps(data, indent=2)
        return
    table: list[tuple[str, ...]] = [("k", "omega", "p", "q", "growth rate at |A| = 1")]
    for k, numbers, rate in rows:
        values_of_row = (numbers.omega, numbers.p, numbers.q, rate) if numbers else ()
        table.append((f"{k:.6g}", *(f"{value:.6g}" for value in values_of_row)))
    if options.form == "latex":
        lines = [" & ".join(row if len(row) == 5 else (*row, *["-"] * 4)) for row in table]
        yield r"\begin{tabular}{rrrrr}"
        yield " \\\\\n".join(lines).replace("omega", r"$\omega$").replace("|A|", "$|A|$")
        yield r"\end{tabular}"
        return
    for row in table:
        cells = row if len(row) == 5 else (*row, "resonance: no NLS equation")
        yield "  ".join(f"{cell:>12}" for cell in cells)


def _row_data(k: float, numbers: EnvelopeNumbers | None, rate: float) -> dict[str, Any]:
    if numbers is None:
        return {"k": k, "resonance": True}
    named = {"omega": numbers.omega, "p": numbers.p, "q": numbers.q}
    return {"k": k, **named, "focusing": numbers.is_focusing, "growth_rate": rate}


# numbers


def _carrier(text: str) -> Expr | None:
    """Return the wavenumber of ``k=pi``, ``k=pi/2`` or ``k=1.2``; None for ``k``."""
    name, sign, value = text.replace(" ", "").partition("=")
    if name != "k" or (sign and not value):
        raise ValueError(f"--envelope must be k or k=NUMBER, got {shown(text)} (such as k=pi)")
    if not value:
        return None
    try:
        return wavenumber(value)
    except ValueError as error:
        raise ValueError(f"--envelope: {error}") from None


def _rounded(value: complex) -> str:
    if not isinstance(value, complex):
        return f"{value:.12g}"
    return f"{value.imag:.12g} i" if not value.real else f"{value.real:.12g} {value.imag:+.12g} i"
