"""Catches: a killed and resumed run that differs in any bit from one without interruption."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from longwave.scenes.engines import scene_run
from longwave.support.checkpoint import checkpoints_in
from tests.runs.unfinished_scenes import SCENES, Killed, KillingFolder, bits

ENDLESS = 10**9


@pytest.fixture(autouse=True)
def _no_flushes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Save every checkpoint, without waiting for the disk."""
    monkeypatch.setattr(os, "fsync", lambda _: None)


def resumed_bits(name: str, folder: Path, kills: list[int]) -> tuple[dict[str, object], list[str]]:
    """Return the contents, and their names, of a run killed after every few checkpoints."""
    for writes in [*kills, ENDLESS]:
        keeper = KillingFolder(folder, writes)
        try:
            with checkpoints_in(keeper):
                found = bits(scene_run.run(SCENES[name]))
        except Killed:
            continue
        return found, keeper.names
    raise AssertionError


def check_resumed(name: str, folder: Path, rng: np.random.Generator, times: int) -> None:
    whole, names = resumed_bits(name, folder / "whole", [])
    assert whole == bits(scene_run.run(SCENES[name]))
    for attempt in range(times):
        kills = rng.integers(0, len(names), 3).tolist()
        found, left = resumed_bits(name, folder / f"{attempt}", kills)
        assert found == whole, kills
        assert len(left) < len(names) or not any(kills)


@pytest.mark.parametrize(
    "name",
    [
        "stated window, refined",
        pytest.param("bench", marks=pytest.mark.slow),
        pytest.param("bath", marks=pytest.mark.slow),
    ],
)
def test_a_killed_run_resumes_to_the_same_bits(
    name: str, tmp_path: Path, rng: np.random.Generator
) -> None:
    check_resumed(name, tmp_path, rng, 1)


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_a_run_of_any_engine_resumes_to_the_same_bits(
    name: str, tmp_path: Path, rng: np.random.Generator
) -> None:
    check_resumed(name, tmp_path, rng, 2)
