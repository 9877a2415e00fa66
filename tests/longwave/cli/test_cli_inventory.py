"""`longwave list`: every object is listed, tables and JSON agree, texts are printed unchanged."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

import longwave.cli.inventory as inventory
from longwave.__main__ import main
from longwave.cli.command_tree import INVENTORY_KINDS
from longwave.derive import LATTICES
from longwave.lattice.schemes import SCHEMES
from longwave.runs.sweep_file import shipped_sweeps
from longwave.scenes.description.named_scenes import (
    load_scene,
    rational_family_scenes,
    shipped_scenes,
)
from longwave.scenes.observed.observables import OBSERVABLES
from longwave.solutions import CATALOGUE

Output = pytest.CaptureFixture[str]
NAMES = {
    "lattices": list(LATTICES),
    "waves": [form.name for form in CATALOGUE],
    "schemes": [scheme.name for scheme in SCHEMES],
    "scenes": [*shipped_scenes(), *shipped_scenes("further"), *rational_family_scenes()],
    "lattice-scenes": list(shipped_scenes("lattices")),
    "bench-scenes": list(shipped_scenes("bench")),
    "sweeps": list(shipped_sweeps()),
    "observables": [*OBSERVABLES],
}


@pytest.mark.parametrize("kind", INVENTORY_KINDS)
def test_table_and_json_have_every_object(kind: str, capsys: Output) -> None:
    assert main(["list", kind, "--json"]) == 0
    records = json.loads(capsys.readouterr().out)
    assert [record["name"] for record in records] == NAMES[kind]
    assert main(["list", kind]) == 0
    rows = [line for line in capsys.readouterr().out.splitlines() if line.startswith("│")]
    shown = [row.split("│")[1].strip() for row in rows]
    assert [name for name in shown if name] == NAMES[kind]


def test_without_a_kind_all_are_listed(capsys: Output) -> None:
    assert main(["list", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {kind: [record["name"] for record in found[kind]] for kind in found} == NAMES


def test_waves_have_domains_and_backgrounds(capsys: Output) -> None:
    assert main(["list", "waves", "--json"]) == 0
    found = {record["name"]: record for record in json.loads(capsys.readouterr().out)}
    assert found["breather_sn"]["background"] == "wave_sn"
    assert found["soliton_dn"]["background"] == "wave_dn"
    assert found["rogue_cn"]["background"] == "wave_cn"
    assert found["rogue_cn"]["parameters"] == [{"name": "k", "domain": "0 < k < 1"}]
    assert found["rational_2"]["background"] == "1"
    assert found["kink_antikink"]["background"] == "A"


def test_lattice_scenes_are_listed_as_their_files_state_them(capsys: Output) -> None:
    assert main(["list", "lattice-scenes", "--json"]) == 0
    for record in json.loads(capsys.readouterr().out):
        scene = load_scene(record["name"])
        assert (record["lattice"], record["eps"]) == (scene.lattice, scene.eps)
        assert (record["carrier"] or "") == scene.carrier


def test_markup_is_printed_as_text(capsys: Output) -> None:
    lattice = {"name": "[/nope]", "title": "[red]x", "fields": [], "constants": [], "forces": []}
    inventory.print_tables({"lattices": [lattice]})
    printed = capsys.readouterr().out
    assert "[/nope]" in printed
    assert "[red]x" in printed


def test_a_scenes_markup_is_printed_as_text(tmp_path: Path, capsys: Output) -> None:
    path = tmp_path / "[red].toml"
    path.write_text(
        'title = "[/nope] \\\\[bold]"\nwave = "soliton_dn"\neps = 0.05\nt0 = -10\n'
        "snapshots = [0]\ncurve_points = 2\nlattice = { K2 = 1, K4 = 1 }\n"
        "parameters = { k = 0.7 }\nscheme = { step = 0.5 }\n"
        'domain = { kind = "ring", sites = 512, compared = 100 }\n',
        encoding="utf-8",
    )
    assert main(["run", str(path)]) == 0
    assert "[/nope]" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("kind", "unwanted"),
    [
        (
            "lattices",
            "numpy numba longwave.solutions.wave longwave.lattice.model longwave.scenes.engines",
        ),
        ("waves", "numba matplotlib longwave.lattice.model longwave.scenes.engines.lattice_run"),
        ("schemes", "sympy xarray pandas longwave.scenes.engines.lattice_run"),
        ("scenes", "sympy xarray pandas ducc0 longwave.verify.proof"),
        ("lattice-scenes", "numba matplotlib xarray longwave.scenes.engines.lattice_run"),
        ("observables", "sympy xarray pandas ducc0 numba"),
    ],
)
def test_a_list_imports_no_more_than_it_shows(kind: str, unwanted: str) -> None:
    """Importing the other rooms would take seconds."""
    code = (
        f"import sys; from longwave.cli.inventory import inventory; inventory([{kind!r}]);"
        f"sys.exit(' '.join(set(sys.modules) & set({unwanted.split()!r})) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
