"""Lines of ``longwave derive --envelope``: an envelope, its numbers, checks, or a map of k."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from sympy import Expr, Rational, pi

from longwave.derive.algebra.exact_numbers import Number
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
from longwave.derive.output.derive_options import DeriveOptions, count, given_constants, varied
from longwave.derive.output.notation import aligned, latex_of, text_of
from longwave.derive.output.own_names import marked, unused
from longwave.derive.output.report import form_data, head_lines
from longwave.derive.symbols import eps
from longwave.support.command_line import check_and_announce
from longwave.support.user_files import shown

if TYPE_CHECKING:
    Values = Mapping[str, Number]

MOST_POINTS = 200

NLS_ORDER, HIGHEST_ORDER = 3, 4
"""Powers of eps at which the NLS equation and its correction stand."""


def carrier_lines(lattice: Lattice, options: DeriveOptions) -> Iterator[str]:
    """The lines that are asked for; raises ValueError for wrong input."""
    for option, given in (
        ("--background", options.background),
        ("--amplitude", options.amplitude),
        ("--time", options.time),
        ("--direction", options.direction),
    ):
        if given is not None:
            raise ValueError(f"{option} must be left out with --envelope, got {given!r}")
    if options.orders not in (None, "3", "4"):
        raise ValueError(
            f"--order must be 3 (the NLS equation) or 4 (its correction) with --envelope, got "
            f"{options.orders!r}"
        )
    constants = given_constants(lattice, options)
    lattice = lattice.with_values({n: value for n, value in constants.items() if value.has(eps)})
    values = {name: value for name, value in constants.items() if not value.has(eps)}
    chosen = _carrier(options.carrier or "")
    text = options.branch or "acoustic"
    branch = int(text) if text.isdecimal() and len(text) < 4 else text
    _check_cost(lattice, options, chosen, values)
    if options.points is not None:
        yield from _map_lines(lattice, options, chosen, branch, values)
    elif options.check:
        yield from _checked(lattice, branch, values)
    else:
        yield from _lines(lattice, options, chosen, branch, values)


def _check_cost(
    lattice: Lattice, options: DeriveOptions, chosen: Expr | None, values: Values
) -> None:
    at_pi = chosen == pi and options.points is None and not options.check
    known = len(lattice.constants) if options.check else len(values)
    seconds = envelope_seconds(lattice, at_pi, 0 if lattice.definitions else known)
    check_and_announce(f"envelope of {lattice.name}", seconds, cheaper=CHEAPER_CARRIER)


def _checked(lattice: Lattice, branch: str | int, values: Values) -> Iterator[str]:
    """The identities at all wavenumbers; with several fields at simple values of the constants."""
    given = values
    if len(lattice.fields) > 1 and not values:
        given = {str(s): value for s, value in simple_numbers(lattice.constants).items()}
    found = envelope(lattice, branch=branch, **({} if lattice.definitions else given))
    at = ", ".join(f"{name} = {value}" for name, value in given.items())
    yield f"{lattice.name}: {found.equation}{' at ' + at if at else ''}"
    yield from map(Check.text, checks_of_envelope(found))


def _lines(
    lattice: Lattice, options: DeriveOptions, chosen: Expr | None, branch: str | int, values: Values
) -> Iterator[str]:
    given = {} if lattice.definitions else values
    found = envelope(lattice, k=chosen, branch=branch, **given)
    names = [n for n in found.parts if options.orders != str(NLS_ORDER) or n not in NEXT_ORDER]
    numbers = None
    if chosen is not None and (values or not lattice.basic_constants):
        found = found.regular(chosen, None, **values)
        numbers = found.coefficients(chosen, None, **values)
    has_form = numbers and numbers.q and not lattice.has_losses
    form = found.normal_form(chosen, None, **values) if has_form else None
    intervals, word = _intervals(lattice, found, values, options) if numbers else ({}, "")
    if options.form == "json":
        data = _data(found, names, numbers, form)
        if intervals:
            data["intervals"] = {name: asdict(interval) for name, interval in intervals.items()}
        yield json.dumps(data, indent=2)
    elif options.form == "latex":
        yield _latex(found, names, numbers)
    else:
        yield from _texts(found, names, numbers, form, chosen, intervals, word)


def _intervals(
    lattice: Lattice, found: Envelope, values: Values, options: DeriveOptions
) -> tuple[dict[str, Interval], str]:
    """The intervals of what follows from the lattice's measured constants, and a word on them."""
    if lattice.measured is None:
        return {}, ""
    if len(lattice.fields) > 1:
        return {}, "(no intervals: they are for one field in a cell)"
    measured, word = varied(lattice, lattice.basic_constants, values, options)
    if measured is None:
        return {}, word
    symbolic = envelope(lattice, k=found.wavenumber) if found.constants else found
    numbers = symbolic.in_constants
    form = normal_form_of(numbers["v"], {"A_XX": numbers["p"], "|A|^2 A": numbers["q"]})
    intervals = Intervals(measured, lattice.basic_constants)
    return {name: intervals.of(value) for name, value in {**numbers, **form.values}.items()}, word


def _data(
    found: Envelope, names: list[str], numbers: EnvelopeNumbers | None, form: NormalForm | None
) -> dict[str, Any]:
    data = {
        "lattice": found.lattice.name,
        "equation": found.equation,
        "missing_energies": list(found.lattice.missing_energies),
        "k": None if found.wavenumber is None else text_of(found.wavenumber),
        "branch": found.branch,
        "fixed": str(found.carrier.fixed),
        "constants": {str(s): text_of(value) for s, value in found.constants.items()},
    }
    if numbers is None:
        wave = {"wave": found.frequency_text()} if found.waves > 1 else {}
        formulas = found.expressions_of(names).items()
        return {**data, **wave, **{name: text_of(value) for name, value in formulas}}
    values = {
        n: [v.real, v.imag] if isinstance(v, complex) else v
        for n, v in asdict(numbers).items()
        if n in ("omega", *names)
    }
    normal = {"normal_form": {**form_data(form), "digits": form.digits}} if form else {}
    return {**data, "numbers": values, **normal}


def _latex(found: Envelope, names: list[str], numbers: EnvelopeNumbers | None) -> str:
    taken = found.lattice.names - {*found.lattice.fields}
    equation = marked(found.equation_latex, ("A", "i", "p", "q"), taken)
    rows = [("", re.sub(r"(\w)~", r"\\tilde{\1}", equation))]
    if numbers is None:
        values = {name: latex_of(value) for name, value in found.expressions_of(names).items()}
        if found.waves > 1:
            rows.append(("", found.frequency_text(latex_of)))
    else:
        rounded = {name: _rounded(value) for name, value in asdict(numbers).items()}
        values = {name: rounded[name] for name in ("omega", *names)}
    for name, value in values.items():
        label = COEFFICIENT_LATEX[name]
        label = rf"\tilde{{{label}}}" if name in taken else label
        rows.append(("", f"{label} = {value}"))
    return aligned(rows)


def _texts(
    found: Envelope,
    names: list[str],
    numbers: EnvelopeNumbers | None,
    form: NormalForm | None,
    chosen: Expr | None,
    intervals: Mapping[str, Interval],
    word: str,
) -> Iterator[str]:
    lattice, names_taken = found.lattice, found.lattice.names - {*found.lattice.fields}

    def own(text: str) -> str:
        return marked(text, ("A", "i", "X", "T", "omega", *found.parts), names_taken)

    yield from head_lines(lattice)
    yield own(f"carrier: {found.leading_field}_n = eps A(X, T) exp(i (k n - omega t)) + c.c. + ...")
    yield own("  X = eps (n - v t), T = eps^2 t")
    if numbers is None:
        at = "" if chosen is None else f" at k = {text_of(chosen)}"
        yield own(f"{found.equation}{at}:")
        yield from (f"  {idle}" for idle in found.idle_losses)
        if found.waves > 1:
            yield f"  of the wave with {found.frequency_text()}, one of {found.waves}: on which"
            yield "  branch it is depends on the constants (--branch takes another)"
        yield f"  {own('omega')}^2 gives {found.carrier.fixed}, which is eliminated"
        formulas = found.expressions_of(names).items()
        yield from (f"  {own(name)} = {text_of(value)}" for name, value in formulas)
        for symbol, value in found.carrier.lattice.definitions:
            yield f"  where {symbol} = {text_of(value.subs(found.constants))}"
        return
    yield f"{own(found.equation)} at k = {chosen}:"
    yield from (f"  {idle}" for idle in found.idle_losses)
    if word:
        yield f"  {word}"
    values = asdict(numbers)

    def written(name: str, value: Any) -> str:
        return intervals[name].text() if name in intervals else _rounded(value)

    yield from (f"  {own(name)} = {written(name, values[name])}" for name in ("omega", *names))
    kind = "unstable, solitons bright" if numbers.is_focusing else "stable, solitons dark"
    if not numbers.q:
        yield "q = 0: waves do not interact at this order, there are no solitons"
        return
    if form is None:
        if numbers.is_focusing:
            crest, law = unused("a", names_taken), found.amplitude_law.text_beside(names_taken)
            yield f"amplitude law of a bright soliton's crest {crest}: {law}"
        return
    yield f"plane waves are {kind}: {own('p q')} {'>' if numbers.is_focusing else '<'} 0"
    yield from form.lines(names_taken, lambda name, value: written(name, float(value)))


# the map


def _map_lines(
    lattice: Lattice, options: DeriveOptions, chosen: Expr | None, branch: str | int, values: Values
) -> Iterator[str]:
    """p, q and the growth rate at equally spaced wavenumbers up to pi."""
    points = count("--map", options.points, MOST_POINTS)
    if chosen is not None or not points:
        raise ValueError(
            f"--map must be 1 or more, with --envelope k, got --map {points} with --envelope "
            f"{options.carrier} (it takes the wavenumbers i pi/{points or 'N'})"
        )
    wavenumbers = [pi * Rational(i, points) for i in range(1, points + 1)]
    rows = modulation_map(lattice, wavenumbers, branch, 1.0, **values)
    if options.form == "json":
        yield json.dumps(
            {"lattice": lattice.name, "map": [_row_data(*row) for row in rows]}, indent=2
        )
        return
    table: list[tuple[str, ...]] = [("k", "omega", "p", "q", "growth rate at |A| = 1")]
    for k, numbers, rate in rows:
        found = (numbers.omega, numbers.p, numbers.q, rate) if numbers else ()
        table.append((f"{k:.6g}", *(f"{value:.6g}" for value in found or ())))
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
    """The wavenumber of ``k=pi``, ``k=pi/2`` or ``k=1.2``; None for ``k``."""
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
