"""``longwave wave``: exact waves of a chain, with the verdict and every number's error."""

from __future__ import annotations

import json
from collections.abc import Mapping
from decimal import (
    ROUND_CEILING,
    ROUND_FLOOR,
    ROUND_HALF_EVEN,
    Context,
    Decimal,
    localcontext,
)
from pathlib import Path
from typing import Any

from longwave.derive.lattice_file import find_lattice
from longwave.derive.symbols import constant_value
from longwave.support import console
from longwave.support.atomic_file import write_atomically
from longwave.support.command_line import command_name, fail
from longwave.support.interruption import interrupted
from longwave.waves.exact_wave import ExactWave, Exponent, exact_wave, waves_of_all_eps
from longwave.waves.proved import Existence, Interval
from longwave.waves.rings import RingStability, Stability

CATALOGUE_NAMES = {"wave_dn": "dn", "wave_cn": "cn", "wave_sn": "sn", "kdv_cnoidal": "cnoidal"}
"""Forms of exact waves, by their names in the catalogue of closed forms."""

LARGEST_ERROR = 1e-10


def wave_and_print(
    model: str,
    constants: Mapping[str, str],
    *,
    near: str | None,
    every_eps_to: str | None,
    stability: str | None,
    ring: int | None,
    certificate: str | None,
    digits: int,
    force: bool,
    json_wanted: bool,
    **numbers: str | None,
) -> int:
    """Find a wave, print its verdict and write its certificate; return the exit status.

    The status is 0 if the wave exists, 1 if it is not proved or is refused, 2 for wrong input.
    """
    try:
        console.check_output(certificate, "w.json", force=force)
        lattice = find_lattice(model).with_values(
            {name: constant_value(name, text) for name, text in constants.items()}
        )
        given = {name: text for name, text in numbers.items() if text is not None}
        form = CATALOGUE_NAMES.get(near or "", near or "")
        if every_eps_to is None:
            wave = exact_wave(lattice, near=form, error=LARGEST_ERROR, **given)
        else:
            extra = {"stability": stability, "ring": ring}
            chosen = {name: str(text) for name, text in extra.items() if text is not None}
            wave = _all_eps(lattice, form, every_eps_to, given | chosen)
        exists = wave.verdict is Existence.EXISTS
        exponents = []
        if stability is not None and exists:
            exponents = [(stability, wave.exponent(stability))]
        rings = [wave.ring(ring)] if ring is not None and exists else []
        if certificate is not None and wave.certificate:
            text = json.dumps(_written(wave, exponents, rings), indent=1) + "\n"
            path = Path(certificate)
            write_atomically(path, lambda draft: draft.write_text(text, encoding="utf-8"), force)
    except KeyboardInterrupt:
        return interrupted(command_name(), "nothing was saved")
    except (ValueError, OSError) as error:
        return fail(error)
    if json_wanted:
        console.print_json(wave.to_json() | _exponents_as_json(exponents) | _rings_as_json(rings))
    else:
        console.print_lines(console.plain_console(), _lines(wave, exponents, rings, digits))
    return int(wave.verdict is not Existence.EXISTS)


def _all_eps(lattice: Any, form: str, eps: str, given: Mapping[str, str]) -> ExactWave:
    """Return the wave for every eps up to ``eps``.

    Raises ValueError if ``given`` has options that are not allowed with it.
    """
    if {*given} - {"k"}:
        others = ", ".join(f"--{name.replace('_', '-')}" for name in {*given} - {"k"})
        raise ValueError(
            f"--every-eps-to must be given with --near and --k alone, got {others} as well"
        )
    return waves_of_all_eps(lattice, near=form, k=given.get("k", 0), eps=eps)


def _written(
    wave: ExactWave, exponents: list[tuple[str, Exponent]], rings: list[RingStability]
) -> Any:
    """Return the wave's certificate, or a list of it and those of ``exponents`` and ``rings``."""
    others = [dict(exponent.certificate) for _, exponent in exponents]
    others += [dict(ring.certificate) for ring in rings if ring.certificate]
    return [dict(wave.certificate), *others] if others else dict(wave.certificate)


def _exponents_as_json(exponents: list[tuple[str, Exponent]]) -> dict[str, Any]:
    if not exponents:
        return {}
    return {
        "exponents": [
            {
                "bloch": bloch,
                "growth": vars(exponent.growth),
                "frequency": vars(exponent.frequency),
                "proved": True,
            }
            for bloch, exponent in exponents
        ]
    }


def _rings_as_json(rings: list[RingStability]) -> dict[str, Any]:
    return {"ring": rings[0].to_json()} if rings else {}


def _ring_line(ring: RingStability, digits: int) -> tuple[str, str]:
    """Return the name and the verdict of a ring, with the proved or the computed growth."""
    if ring.proved_growth is None:
        text = f"growth {ring.growth:.1e}, computed, not proved: {ring.reason}"
    elif ring.verdict is Stability.STABLE:
        text = "STABLE, proved: no perturbation grows exponentially"
    else:
        growth = number_text(ring.proved_growth, digits)
        text = f"UNSTABLE, proved: growth {growth} at kappa P/(2 pi) = {ring.bloch}"
    return f"ring of {ring.wavelengths} wavelengths", text


def _lines(
    wave: ExactWave,
    exponents: list[tuple[str, Exponent]],
    rings: list[RingStability],
    digits: int,
) -> list[str]:
    """Return the lines to print: the verdict, the theorem, and each number with its error."""
    if wave.verdict is not Existence.EXISTS:
        return [f"{wave.verdict}: {wave.reason}"]
    rows = [(name, number_text(value, digits)) for name, value in wave.numbers.items()]
    lines = [f"{wave.verdict}: {wave.statement.splitlines()[0]}"]
    for bloch, exponent in exponents:
        at = f"kappa P/(2 pi) = {bloch}"
        state = "UNSTABLE, proved" if exponent.is_unstable else "no growth proved"
        rows += [
            (f"growth at {at}", f"{number_text(exponent.growth, digits)}  ({state})"),
            (f"frequency at {at}", number_text(exponent.frequency, digits)),
        ]
    rows += [_ring_line(ring, digits) for ring in rings]
    width = max(len(name) for name, _ in rows)
    return [*lines, *(f"  {name:<{width}}  {text}" for name, text in rows)]


def number_text(interval: Interval, digits: int) -> str:
    """Return a number with its error, rounded up, or both ends of a wide interval.

    >>> number_text(Interval("0.1234560", "0.1234565"), 5), number_text(Interval("0.25", "0.5"), 4)
    ('0.12346 +- 4.0e-6', '0.25 to 0.5')
    """
    low, high = Decimal(interval.lower), Decimal(interval.upper)
    if high - low > abs(high) / 1000:
        return f"{_rounded(low, digits, ROUND_FLOOR)} to {_rounded(high, digits, ROUND_CEILING)}"
    with localcontext(Context(prec=60)):
        shown = _rounded((low + high) / 2, digits, ROUND_HALF_EVEN)
        error = _rounded(max(high - shown, shown - low), 2, ROUND_CEILING)
    return f"{shown} +- {error:.1e}" if error else str(shown)


def _rounded(value: Decimal, digits: int, rounding: str) -> Decimal:
    return Context(prec=digits, rounding=rounding).plus(value)
