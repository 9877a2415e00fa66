"""Catches: an error for a misspelt name that does not suggest the right one, or is long."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

import longwave
from longwave.__main__ import main
from longwave.derive import lattice_of
from longwave.lattice import scheme_named
from longwave.lattice.numeric_lattice import numeric_lattice
from longwave.runs.sweep_file import load_sweep, sweep_of
from longwave.scenes.description.named_scenes import scene_of_toml
from longwave.verify.problem_file import problem_texts
from longwave.verify.published import chosen

FPUT = longwave.LATTICES["fput_strain"]
SCENE = """
lattice = "toda"
wave = "kdv_soliton"
eps = 0.1
slow_times = [0, 0.1]
half_width = 4
tolerance = 1e-3
[constants]
a = 1
b = 1
[parameters]
kappa = 1
"""


def scene(old: str, new: str, run: bool = False) -> object:
    """Return a scene with one name changed; run it if the name is looked up only then."""
    assert old in SCENE
    found = scene_of_toml(SCENE.replace(old, new))
    return longwave.run(found) if run else found


def table(text: str) -> object:
    return scene_of_toml(f"{SCENE}{text}\n")


def of(**given: Any) -> longwave.Scene:
    usual = {"name": "x", "wave": "kink", "eps": 0.1, "times": [0, 1], "K2": 1, "K4": 1}
    return longwave.Scene.of(**{**usual, "compared": 9, "tolerance": 1e-3, **given})


def wave(**given: float) -> longwave.Wave:
    return longwave.Wave(longwave.closed_form("soliton_dn"), NORMAL, **given)


CHAIN: Mapping[str, Any] = {"name": "mine", "fields": ["u"], "masses": [1]}
BOND = {"between": ["u[n]", "u[n+1]"], "force": "x"}
NORMAL = longwave.mkdv_normal_form(1, 1)

MISSPELT: Mapping[str, tuple[Callable[[], Any], str]] = {
    "lattice": (lambda: longwave.LATTICES["todda"], "toda"),
    "lattice, letters exchanged": (lambda: longwave.LATTICES["ganrular"], "granular"),
    "lattice, capitals": (lambda: longwave.LATTICES["Klein-Gordon"], "klein_gordon"),
    "lattice of a scene": (lambda: scene('"toda"', '"tooda"', run=True), "toda"),
    "lattice, its beginning": (lambda: longwave.LATTICES["next"], "next_nearest"),
    "wave": (lambda: longwave.closed_form("rogue_cm"), "rogue_cn"),
    "wave of the catalogue": (lambda: longwave.CATALOGUE["kinck"], "kink"),
    "wave of a scene": (lambda: scene("kdv_soliton", "kdv_solition", run=True), "kdv_soliton"),
    "parameter of a wave": (lambda: wave(kk=0.5), "k"),
    "shipped scene": (lambda: longwave.load_scene("toda_solitn"), "toda_soliton"),
    "scene to be run": (lambda: longwave.run("chain_in_bath"), "chain_in_a_bath"),
    "scene to be drawn": (lambda: longwave.plot("granular_drak"), "granular_dark"),
    "folder of scenes": (lambda: longwave.shipped_scenes("latices"), "lattices"),
    "shipped sweep": (lambda: load_sweep("growth_over_kk"), "growth_over_k"),
    "noun": (lambda: longwave.scence, "Scene"),
    "noun of a room": (lambda: longwave.derive.Lattise, "Lattice"),  # type: ignore[attr-defined]
    "key": (lambda: scene("half_width", "halfwidth"), "half_width"),
    "key, one letter": (lambda: scene("eps", "esp"), "eps"),
    "table": (lambda: scene("[constants]", "[constant]"), "constants"),
    "key of a table": (lambda: table("[envelope]\nk = 1\nbrunch = 1"), "branch"),
    "key of losses": (lambda: table("[losses]\nbnod = 0.1"), "bond"),
    "key of disorder": (lambda: table("[disorder]\nof = 'mass'\nspred = 1"), "spread"),
    "keyword": (lambda: of(tolerence=1e-3), "tolerance"),
    "engine": (lambda: of(engine="spectrall"), "spectral"),
    "order": (lambda: of(order="leadnig"), "leading"),
    "observable": (lambda: of(observables=["strain", "crest_trak"]), "crest_track"),
    "scheme": (lambda: scheme_named("kahan_li8"), "kahan_li_8"),
    "scheme of a scene": (lambda: of(scheme="stoermer"), "stoermer_verlet"),
    "domain": (lambda: of(tolerance=None, step=0.1, sites=64, domain="rign"), "ring"),
    "constant": (lambda: longwave.reduce(longwave.LATTICES["granular"]).coefficients(a=1), "A"),
    "constant of numbers": (
        lambda: numeric_lattice(longwave.LATTICES["mass_dimer"], {"K22": 1}),
        "K2",
    ),
    "equation": (lambda: longwave.NormalForm(1, 1, 1, 1, "mKDV_"), "mKdV"),
    "swept field": (lambda: sweep_of({"scene": "toda_soliton", "grid": {"epss": [1]}}), "eps"),
    "key of a sweep": (lambda: sweep_of({"scene": "toda_soliton", "gird": {}}), "grid"),
    "kind of picture": (lambda: longwave.plot("toda_soliton", kind="snapshot"), "snapshots"),
    "function": (lambda: lattice_of({**CHAIN, "spring": [BOND | {"force": "thanh(x)"}]}), "tanh"),
    "key of a lattice": (lambda: lattice_of({**CHAIN, "sprign": [BOND]}), "spring"),
    "function of a statement": (lambda: longwave.prove("u_t + u_x", "u = sehc(x - t)"), "sech"),
    "published solution": (lambda: chosen(["kdv_one_solition"]), "kdv_one_soliton"),
    "key of a problem": (lambda: problem("equation = 'u_t'\nsoluton = 'u = 0'"), "solution"),
}
"""What is called, and the name that was meant."""

MISSPELT_WORDS: Mapping[str, str] = {
    "lits waves": "list",
    "derive tooda": "toda",
    "run toda_soliton --outptu x.nc": "--output",
    "plot toda_soliton --kind spectrum": "spectra",
    "verify --only kinck": "kink",
    "converge toda_solitn": "toda_soliton",
    "list lattice": "lattices",
    "library kdv_positn": "kdv_positon",
}
"""Words of the command line."""


def problem(text: str) -> object:
    path = Path("problems.toml")
    path.write_text(f"[[problem]]\n{text}\n", "utf-8")
    return problem_texts(path)


def check(message: str, meant: str) -> None:
    assert "\n" not in message.strip()
    assert f"did you mean {meant}?" in message or f"did you mean {meant}," in message
    assert len(message) < 500, message


@pytest.mark.parametrize("case", MISSPELT)
def test_a_misspelt_name_is_answered_with_the_one_that_was_meant(
    case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    call, meant = MISSPELT[case]
    with pytest.raises((ValueError, AttributeError)) as refused:
        call()
    check(str(refused.value), meant)


@pytest.mark.parametrize("words", MISSPELT_WORDS)
def test_a_misspelt_word_is_answered_with_the_one_that_was_meant(
    words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words.split()) == 2
    check(capsys.readouterr().err, MISSPELT_WORDS[words])


def test_a_catalogue_of_names_is_a_mapping_like_any_other() -> None:
    assert "todda" not in longwave.LATTICES
    assert longwave.LATTICES.get("todda") is None
    with pytest.raises(KeyError):
        longwave.LATTICES["todda"]


def test_there_are_forty_names() -> None:
    assert len(MISSPELT) + len(MISSPELT_WORDS) >= 40
