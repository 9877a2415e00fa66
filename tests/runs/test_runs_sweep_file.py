import math
from pathlib import Path
from typing import Any

import pytest

from longwave.runs.sweep_file import load_sweep, shipped_sweeps, sweep_of
from longwave.scenes.description.named_scenes import load_scene


def test_a_grid_combines_every_value_with_every_other() -> None:
    grid = {"eps": [0.1, 0.2], "parameters": {"kappa": {"from": 0.5, "to": 1.5, "count": 3}}}
    sweep = sweep_of({"scene": "toda_soliton", "grid": grid})
    assert [d.name for d in sweep.dimensions] == ["eps", "kappa"]
    assert sweep.shape == (2, 3)
    base = load_scene("toda_soliton")
    expected = [
        base.changed(eps=eps, parameters={"kappa": kappa})
        for eps in (0.1, 0.2)
        for kappa in (0.5, 1.0, 1.5)
    ]
    assert [sweep.scene(cell) for cell in range(len(sweep))] == expected


def test_columns_of_a_list_vary_together_and_with_the_grid() -> None:
    columns = {"wave": ["rogue_cn", "wave_sn"], "lattice.K4": [1, -1]}
    sweep = sweep_of({"scene": "rogue_cn_k_0.5", "list": columns, "grid": {"eps": [0.1, 0.05]}})
    assert [d.name for d in sweep.dimensions] == ["eps", "case"]
    scenes = [sweep.scene(cell) for cell in range(4)]
    assert [(s.eps, s.wave, s.model.K4) for s in scenes] == [
        (0.1, "rogue_cn", 1.0),
        (0.1, "wave_sn", -1.0),
        (0.05, "rogue_cn", 1.0),
        (0.05, "wave_sn", -1.0),
    ]


def test_samples_follow_the_seed_and_no_other_field() -> None:
    def drawn(**fields: Any) -> list[dict[str, Any]]:
        sweep = sweep_of({"scene": "rogue_cn_k_0.5", "random": {"count": 50, **fields}})
        return [sweep.values(cell) for cell in range(50)]

    eps = {"from": 0.01, "to": 0.1, "log": True}
    one = [row["eps"] for row in drawn(seed=1, eps=eps)]
    more = drawn(seed=1, lattice={"K3": {"from": -1, "to": 1}}, eps=eps)
    assert one == [row["eps"] for row in more]
    assert one != [row["eps"] for row in drawn(seed=2, eps=eps)]
    assert all(0.01 <= value <= 0.1 for value in one)
    assert 10 < sum(value < math.sqrt(0.001) for value in one) < 40
    whole = {
        row["domain.sites"] for row in drawn(seed=1, **{"domain.sites": {"choose": [64, 128]}})
    }
    assert whole == {64, 128}
    counted = drawn(seed=1, curve_points={"from": 3, "to": 5, "whole": True})
    assert {row["curve_points"] for row in counted} == {3, 4, 5}
    sites = {"from": 64, "to": 6400, "whole": True, "log": True}
    logs = [row["domain.sites"] for row in drawn(seed=1, **{"domain.sites": sites})]
    assert all(isinstance(value, int) and 64 <= value <= 6400 for value in logs)
    assert 10 < sum(value < 640 for value in logs) < 40
    with pytest.raises(ValueError, match=r"must have whole ends where it is whole, got 0.5 and 3"):
        drawn(seed=1, curve_points={"from": 0.5, "to": 3, "whole": True})


def test_ranges_have_both_ends_and_round_values() -> None:
    def values(**given: Any) -> tuple[Any, ...]:
        return tuple(row[0] for row in sweep_of(_grid(given)).dimensions[0].rows)

    assert values(**{"from": 0.1, "to": 0.5, "count": 5}) == (0.1, 0.2, 0.3, 0.4, 0.5)
    assert values(**{"from": 0.001, "to": 0.1, "count": 3, "log": True}) == (0.001, 0.01, 0.1)
    whole = values(**{"from": 1, "to": 7, "count": 3})
    assert whole == (1, 4, 7)
    assert all(isinstance(value, int) for value in whole)


def _grid(given: Any) -> dict[str, Any]:
    return {"scene": "rogue_cn_k_0.5", "grid": {"eps": given}}


def test_a_tolerance_takes_the_place_of_what_it_determines() -> None:
    sweep = sweep_of({"scene": "rogue_cn_k_0.5", "grid": {"tolerance": [1e-3]}})
    assert sweep.scene(0) == load_scene("rogue_cn_k_0.5").with_tolerance(1e-3)


def test_setting_one_of_two_exclusive_fields_removes_the_other() -> None:
    changes = {"times": [0, 10], "compared": 20}
    scene = sweep_of({"scene": "toda_soliton", "set": changes, **_eps()}).scene(0)
    assert (scene.snapshots, scene.slow_times, scene.half_width) == ((0.0, 10.0), (), None)


def _eps() -> dict[str, Any]:
    return {"grid": {"eps": [0.1]}}


def test_a_member_of_a_family_and_tables_are_bases() -> None:
    from longwave.scenes.description.named_scenes import load_scene

    member = sweep_of({"scene": "Y2_eps_0.05", **_eps()}).scene(0)
    assert member == load_scene("Y2_eps_0.05").changed(eps=0.1)
    tables = {
        "lattice": "toda",
        "wave": "kdv_soliton",
        "eps": 0.2,
        "slow_times": [0, 1],
        "half_width": 8,
        "tolerance": 1e-4,
        "constants": {"a": 1, "b": 1},
        "parameters": {"kappa": 1},
    }
    found = sweep_of({"scene": tables, **_eps()}).scene(0)
    expected = load_scene("toda_soliton").changed(
        name="scene", title="", slow_times=[0, 1], order="leading"
    )
    assert found == expected


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ({"scene": "nope", **_eps()}, "scene must be a TOML file or a shipped scene, got 'nope'"),
        ({"scene": 3, **_eps()}, "scene must be a name, a file or a table, got 3"),
        (_eps(), "scene must be stated, got nothing"),
        ({"scene": "toda_soliton"}, r"\[grid\], \[list\] or \[random\] must be stated"),
        ({"scene": "toda_soliton", "grids": {}}, "keys must be known ones, got grids"),
        ({"scene": "toda_soliton", "grid": {"esp": [1]}}, "fields must be known ones, got 'esp'"),
        (
            {"scene": "toda_soliton", "grid": {"lattice.K5": [1]}},
            "fields must be known ones, got 'lattice.K5'",
        ),
        (
            {"scene": "rogue_cn_k_0.5", "grid": {"domain.size": [1]}},
            "fields must be known ones, got 'domain.size'",
        ),
        ({"scene": "toda_soliton", "grid": {"eps": []}}, "eps must be a list of values or a range"),
        ({"scene": "toda_soliton", "grid": {"eps": 0.1}}, "eps must be a list of values"),
        (
            {"scene": "toda_soliton", "grid": {"parameters.kappa": [1, 2, 1.0]}},
            r"parameters.kappa in \[grid\] must have different values, got 1.0 twice",
        ),
        (
            {"scene": "toda_soliton", "grid": {"slow_times": [[0, 1], [0, 2], [0, 1]]}},
            r"slow_times in \[grid\] must have different values, got \[0, 1\] twice",
        ),
        (
            {"scene": "toda_soliton", "grid": {"eps": [0.1, float("nan")]}},
            "eps must be finite numbers or texts, got nan",
        ),
        (
            {"scene": "toda_soliton", "list": {"slow_times": [[0, float("inf")]]}},
            "slow_times must be finite numbers or texts, got inf",
        ),
        (
            {"scene": "toda_soliton", "grid": {"order": ["leading", "a\0b"]}},
            "order must be a text without NUL, got 'a",
        ),
        (_grid({"from": 1, "to": 0, "count": 2}), "eps must have from < to, got 1 and 0"),
        (_grid({"from": 0, "to": 1, "count": 2, "log": True}), "eps must have from > 0 with log"),
        (_grid({"from": 0, "to": 1, "count": 1}), "count of eps must be at least 2, got 1"),
        (_grid({"from": 0, "to": 1, "cuont": 5}), "keys of eps must be known ones, got cuont"),
        (_grid({"from": 0, "to": 1}), "eps must have a count, got none"),
        (_grid({"from": 0.1, "to": 1, "count": 10**7}), "count must be at most 1000000"),
        (
            {"scene": "toda_soliton", "set": {"eps": 0.1}, **_eps()},
            "eps must be given in one table, got it in two",
        ),
        (
            {"scene": "toda_soliton", "list": {"eps": [0.1, 0.2], "order": ["leading"]}},
            r"columns in \[list\] must have one length, got 2 of eps and 1 of order",
        ),
        (
            {"scene": "toda_soliton", "random": {"count": 3, "eps": {"from": 0, "to": 1}}},
            r"seed in \[random\] must be stated",
        ),
        (
            {"scene": "toda_soliton", "random": {"count": 3, "seed": 1}},
            r"\[random\] must name a field",
        ),
        (
            {
                "scene": "toda_soliton",
                "grid": {
                    "eps": {"from": 0.01, "to": 0.1, "count": 2000},
                    "tolerance": {"from": 1e-4, "to": 1e-3, "count": 2000},
                },
            },
            "cells must be at most 1000000, got 4000000",
        ),
    ],
)
def test_a_file_that_is_no_sweep_is_a_one_line_error(
    document: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message) as caught:
        sweep_of(document)
    assert "\n" not in str(caught.value)


def test_an_error_names_the_file(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text('scene = "toda_soliton"\n[grid]\nesp = [1]\n')
    with pytest.raises(ValueError, match=r"^mine\.toml: fields must be known ones, got 'esp'"):
        load_sweep(tmp_path / "mine.toml")
    with pytest.raises(ValueError, match="sweep must be a TOML file or a shipped sweep, got 'x'"):
        load_sweep("x")


def test_a_base_scene_next_to_the_sweep_is_found(tmp_path: Path) -> None:
    text = load_scene("toda_soliton")
    assert text.name == "toda_soliton"
    (tmp_path / "base.toml").write_text(
        'lattice = "toda"\nwave = "kdv_soliton"\neps = 0.1\nslow_times = [0, 1]\nhalf_width = 8\n'
        "tolerance = 1e-4\nconstants = {a = 1, b = 1}\nparameters = {kappa = 1}\n"
    )
    (tmp_path / "sweep.toml").write_text('scene = "base.toml"\n[grid]\nparameters.kappa = [1, 2]\n')
    sweep = load_sweep(tmp_path / "sweep.toml")
    assert [dict(sweep.scene(i).parameters) for i in (0, 1)] == [{"kappa": 1}, {"kappa": 2}]


@pytest.mark.parametrize("name", shipped_sweeps())
def test_every_shipped_sweep_has_admissible_ends(name: str) -> None:
    sweep = load_sweep(name)
    assert sweep.title
    for cell in (0, len(sweep) - 1):
        sweep.scene(cell)


def test_an_error_in_the_toml_names_a_sweep(tmp_path: Path) -> None:
    (tmp_path / "broken.toml").write_text("x = [", encoding="utf-8")
    with pytest.raises(ValueError, match=r"^sweep must be a TOML file, got .*broken\.toml"):
        load_sweep(str(tmp_path / "broken.toml"))


def test_a_table_of_the_chain_is_not_swept_but_its_constants_are() -> None:
    """Catches: cells that all run the constants of the base."""
    tables = [{"K2": 1, "K4": 1}, {"K2": 4, "K4": 1}]
    sweep = sweep_of({"scene": "rogue_cn_k_0.5", "grid": {"lattice": tables}})
    with pytest.raises(ValueError, match=r"lattice must be a name or a declared lattice in a swe"):
        sweep.scene(1)
    sweep = sweep_of({"scene": "rogue_cn_k_0.5", "grid": {"lattice.K2": [1, 4]}})
    assert [sweep.scene(cell).model.K2 for cell in (0, 1)] == [1.0, 4.0]
