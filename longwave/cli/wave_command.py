"""``longwave wave``: exact waves of a chain, with the verdict and every number's error."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from longwave.cli.proved_motion import LARGEST_ERROR, Finding, find_and_print, number_text
from longwave.derive.lattice import Lattice
from longwave.waves.exact_wave import ExactWave, Exponent, exact_wave, waves_of_all_eps
from longwave.waves.proved import Existence
from longwave.waves.rings import RingStability, Stability

CATALOGUE_NAMES = {"wave_dn": "dn", "wave_cn": "cn", "wave_sn": "sn", "kdv_cnoidal": "cnoidal"}
"""Forms of exact waves, by their names in the catalogue of closed forms."""


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

    The status is that of `find_and_print`.
    """
    given = {name: text for name, text in numbers.items() if text is not None}
    form = CATALOGUE_NAMES.get(near or "", near or "")

    def find(lattice: Lattice) -> Finding:
        if every_eps_to is None:
            wave = exact_wave(lattice, near=form, error=LARGEST_ERROR, **given)
        else:
            extra = {"stability": stability, "ring": ring}
            chosen = {name: str(text) for name, text in extra.items() if text is not None}
            wave = _all_eps(lattice, form, every_eps_to, given | chosen)
        exists = wave.verdict is Existence.EXISTS
        exponent = wave.exponent(stability) if stability is not None and exists else None
        verdict = wave.ring(ring) if ring is not None and exists else None
        return _finding(wave, stability or "", exponent, verdict, digits)

    return find_and_print(
        model,
        constants,
        find,
        certificate=certificate,
        example="w.json",
        force=force,
        json_wanted=json_wanted,
    )


def _all_eps(lattice: Lattice, form: str, eps: str, given: Mapping[str, str]) -> ExactWave:
    """Return the wave for every eps up to ``eps``.

    Raises ValueError if ``given`` has options that are not allowed with it.
    """
    if {*given} - {"k"}:
        others = ", ".join(f"--{name.replace('_', '-')}" for name in {*given} - {"k"})
        raise ValueError(
            f"--every-eps-to must be given with --near and --k alone, got {others} as well"
        )
    return waves_of_all_eps(lattice, near=form, k=given.get("k", 0), eps=eps)


def _finding(
    wave: ExactWave,
    bloch: str,
    exponent: Exponent | None,
    ring: RingStability | None,
    digits: int,
) -> Finding:
    """Return what is printed and written of a wave, its exponent at ``bloch``, and its ring."""
    rows = [(name, number_text(value, digits)) for name, value in wave.numbers.items()]
    data: dict[str, Any] = {}
    certificates = []
    if exponent:
        rows += _exponent_rows(bloch, exponent, digits)
        ends = {"growth": vars(exponent.growth), "frequency": vars(exponent.frequency)}
        data["exponents"] = [{"bloch": bloch, **ends, "proved": True}]
        certificates.append(exponent.certificate)
    if ring:
        rows.append(_ring_row(ring, digits))
        data["ring"] = ring.to_json()
        if ring.certificate:
            certificates.append(ring.certificate)
    return Finding(wave, rows, data=data, certificates=certificates)


def _exponent_rows(bloch: str, exponent: Exponent, digits: int) -> list[tuple[str, str]]:
    at = f"kappa P/(2 pi) = {bloch}"
    state = "UNSTABLE, proved" if exponent.is_unstable else "no growth proved"
    return [
        (f"growth at {at}", f"{number_text(exponent.growth, digits)}  ({state})"),
        (f"frequency at {at}", number_text(exponent.frequency, digits)),
    ]


def _ring_row(ring: RingStability, digits: int) -> tuple[str, str]:
    """Return the name and the verdict of a ring, with the proved or the computed growth."""
    if ring.proved_growth is None:
        text = f"growth {ring.growth:.1e}, computed, not proved: {ring.reason}"
    elif ring.verdict is Stability.STABLE:
        text = "STABLE, proved: no perturbation grows exponentially"
    else:
        growth = number_text(ring.proved_growth, digits)
        text = f"UNSTABLE, proved: growth {growth} at kappa P/(2 pi) = {ring.bloch}"
    return f"ring of {ring.wavelengths} wavelengths", text
