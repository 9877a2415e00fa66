"""Catches: an array whose imaginary part or mask is dropped silently; an error of many lines."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

import longwave
from longwave.lattice import FieldRing, Model, State, integrate, spectral_integrate
from longwave.lattice.sensitivities import Sensor
from longwave.scenes.description.time_functions import Samples
from longwave.scenes.fits.sensor_records import SensorRecord
from longwave.scenes.modulation import modulation_grid

SENSOR = Sensor("displacement", 0, 0)
CHAIN = Model(1.0, 0.0, 1.0).lattice
WAVE = longwave.Wave(longwave.closed_form("soliton_dn"), longwave.mkdv_normal_form(1, 1), k=0.5)
ROW = np.linspace(0.1, 0.8, 8)
FORCE = 1.1 * ROW + 1e-3 * np.cos(np.arange(8))


def ring(f: Any, v: Any) -> FieldRing:
    return FieldRing(0.0, (0.0,), (8.0,), f, v)


def row(values: Any) -> Any:
    """Return the values as the only field of a chain; return anything but an array unchanged."""
    return values[np.newaxis] if isinstance(values, np.ndarray) else values


def scene(times: Any) -> longwave.Scene:
    usual = {"name": "x", "wave": "kink", "eps": 0.1, "K2": 1, "K4": -1, "compared": 9}
    return longwave.Scene.of(**usual, times=times, tolerance=1e-3)


STILL = np.zeros((1, 8))

CALLS: Mapping[str, Callable[[Any], Any]] = {
    "f of a state": lambda a: integrate(CHAIN, State(0.0, row(a), STILL), [1.0], 1e-3),
    "v of a state": lambda a: integrate(CHAIN, State(0.0, STILL, row(a)), [1.0], 1e-3),
    "times": lambda a: integrate(CHAIN, State(-1.0, STILL, STILL), a, 1e-3),
    "f of a ring": lambda a: spectral_integrate(CHAIN, ring(row(a), STILL), [1.0], 1e-3),
    "v of a ring": lambda a: spectral_integrate(CHAIN, ring(STILL, row(a)), [1.0], 1e-3),
    "X": lambda a: WAVE(a, 0.0),
    "T": lambda a: WAVE(0.0, a),
    "n": lambda a: WAVE.at(a, 0.0, 0.1),
    "jets": lambda a: WAVE.jets(a, 0.0, 1),
    "stretch": lambda a: longwave.fit_force(a, FORCE, law="K2*x"),
    "force": lambda a: longwave.fit_force(ROW, a, law="K2*x"),
    "deviation": lambda a: longwave.fit_force(ROW, FORCE, a, law="K2*x"),
    "readings": lambda a: SensorRecord(ROW, (SENSOR,), column(a), None),
    "k": lambda a: modulation_grid(longwave.LATTICES["fput"], a, K2=1, K3=0, K4=1),
    "drive": lambda a: Samples.of("value", {"t": range(8), "value": a}),
    "times of a scene": lambda a: scene(a),
    "strains": lambda a: longwave.relative_sup_error(a, 2 * ROW, ROW),
}
"""Calls of an array of eight increasing numbers."""


def column(values: Any) -> Any:
    return values[:, np.newaxis] if isinstance(values, np.ndarray) else values


THIRD = np.arange(8) == 3
OBJECTS = np.array([*ROW[:-1], None], dtype=object)

WRONG: Mapping[str, Any] = {
    "complex": ROW + 1e-3j,
    "complex without imaginary part": ROW + 0j,
    "NaN": np.where(THIRD, np.nan, ROW),
    "infinite": np.where(THIRD, np.inf, ROW),
    "masked": np.ma.masked_array(ROW, mask=THIRD),
    "objects": OBJECTS,
    "texts": ROW.astype(str),
    "truth values": ROW > 0.35,
    "dates": np.arange("2020-01-01", "2020-01-09", dtype="datetime64[D]"),
}


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("kind", WRONG)
def test_a_wrong_array_is_refused_in_one_line(call: str, kind: str) -> None:
    with pytest.raises(ValueError, match="must") as refused:
        CALLS[call](WRONG[kind])
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("call", CALLS)
def test_an_array_of_real_numbers_is_taken(call: str) -> None:
    assert CALLS[call](ROW) is not None


def test_integers_are_numbers() -> None:
    whole = np.array([[0, 1, 0, -1, 0, 0, 0, 0]])
    found = integrate(CHAIN, State(0.0, whole, np.zeros_like(whole)), [1, 2], 1e-3)
    floats = integrate(CHAIN, State(0.0, whole * 1.0, STILL), [1.0, 2.0], 1e-3)
    assert np.array_equal(found.f, floats.f)
    assert whole.dtype.kind == "i"


@pytest.mark.parametrize("shape", [(8,), (2, 8), (1, 8, 2), (1, 0)])
def test_a_state_of_another_shape_is_refused_in_one_line(shape: tuple[int, ...]) -> None:
    with pytest.raises(
        ValueError, match=r"state.f must have the shape .fields, \*cells."
    ) as message:
        integrate(CHAIN, State(0.0, np.zeros(shape), np.zeros(shape)), [1.0], 1e-3)
    assert "\n" not in str(message.value)


def test_readings_of_another_shape_are_refused() -> None:
    with pytest.raises(ValueError, match=r"values must have the shape \(8, 1\), got \(8, 2\)"):
        SensorRecord(ROW, (SENSOR,), np.zeros((8, 2)), None)
