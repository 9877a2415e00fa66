"""Wave of a scene on its lattice; results from SymPy are cached for other processes."""

from __future__ import annotations

from dataclasses import astuple
from functools import partial
from typing import TYPE_CHECKING, Any, cast

from longwave.lattice.force_program import ForceProgram
from longwave.lattice.numeric_lattice import Entry, NumericBond, NumericLattice
from longwave.scenes.description.scene import Scene
from longwave.scenes.starts.first_correction import correction_interval
from longwave.scenes.starts.jet_polynomial import JetPolynomial
from longwave.scenes.starts.lattice_wave import LatticeWave
from longwave.scenes.starts.long_wave_data import LongWaveData, LongWaveNumbers, SlowFrame
from longwave.scenes.starts.start_entries import WaveStart
from longwave.solutions import kept_data, kept_wave

if TYPE_CHECKING:
    from longwave.derive import Reduction
    from longwave.solutions import Wave


def scene_lattice_wave(scene: Scene) -> LatticeWave:
    """Return the wave of a scene, from the cache if possible, else by `lattice_wave`."""
    if isinstance(start := scene.start, WaveStart):
        return start.wave(scene)
    if not _is_cached(scene):
        from longwave.scenes.starts.lattice_derivation import lattice_wave  # slow import

        return lattice_wave(scene)
    key = _key(scene)
    wave = kept_wave(__name__, key, partial(_derived_wave, scene))
    numbers = _numbers_of(kept_data(__name__, f"numbers {key}", partial(_derived_parts, scene)))
    interval = correction_interval(scene, wave)
    return LongWaveData(numbers, wave, scene.eps, scene.order, interval)


def equation_of(scene: Scene) -> tuple[str, bool]:
    """Return the reduced equation in one line, and whether the lattice has displacements."""
    if isinstance(start := scene.start, WaveStart):
        return start.equation, scene.symbolic_lattice.has_displacements
    derive = partial(_derived_equation, scene)
    return kept_data(__name__, f"equation {_key(scene)}", derive) if _is_cached(scene) else derive()


def _is_cached(scene: Scene) -> bool:
    """Return whether results are cached: for named long waves without losses or disorder."""
    needs_more = scene.is_envelope or scene.losses or scene.disorder or scene.named_start
    return isinstance(scene.wave, str) and not needs_more


def _key(scene: Scene) -> str:
    """Return a cache key: the scene's JSON without fields that do not affect wave or equation."""
    unused: dict[str, Any] = {"name": "", "title": "", "observables": None, "curve_points": 201}
    times = {"times": (0.0, 1.0), "slow_times": (), "look_points": None}
    return scene.with_tolerance(1.0).changed(**unused, **times).json()


def _derived_wave(scene: Scene) -> Wave:
    from longwave.scenes.starts.lattice_derivation import wave_of

    return cast("Wave", wave_of(scene))


def _derived_parts(scene: Scene) -> tuple[Any, ...]:
    """Derive the wave's `LongWaveNumbers` and return them as nested tuples for the cache."""
    from longwave.scenes.starts.lattice_derivation import derivation
    from longwave.scenes.starts.long_wave_numbers import long_wave_numbers

    derived = derivation(scene)
    source = cast("Reduction", derived.source)
    return astuple(long_wave_numbers(source, {}, scene.eps, scene.order, derived.lattice))


def _numbers_of(parts: tuple[Any, ...]) -> LongWaveNumbers:
    """Rebuild the `LongWaveNumbers` from the nested tuples of `_derived_parts`."""
    (name, fields, masses, bonds), frames, series, correction, *plain = parts
    return LongWaveNumbers(
        NumericLattice(name, fields, masses, tuple(map(_bond_of, bonds))),
        tuple(SlowFrame(*frame) for frame in frames),
        tuple((JetPolynomial(*field), JetPolynomial(*rate)) for field, rate in series),
        correction and (correction[0], *(JetPolynomial(*terms) for terms in correction[1:])),
        *plain,
    )


def _bond_of(parts: tuple[Any, ...]) -> NumericBond:
    ends, (force, offset) = parts[:2], parts[2:]
    stretch, action = (tuple(Entry(*entry) for entry in entries) for entries in ends)
    return NumericBond(stretch, action, ForceProgram(*force), offset)


def _derived_equation(scene: Scene) -> tuple[str, bool]:
    from longwave.scenes.starts.lattice_derivation import derivation

    derived = derivation(scene)
    return derived.text(), derived.lattice.has_displacements
