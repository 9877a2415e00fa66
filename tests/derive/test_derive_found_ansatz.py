"""For values of the constants `longwave derive` finds the same ansatz as a scene."""

import json
from typing import Any

import pytest

from longwave.derive import LATTICES, find_scaling
from longwave.derive.__main__ import main
from longwave.derive.algebra.formula_printing import text_of
from longwave.scenes.description.scene import Scene
from longwave.scenes.starts.lattice_derivation import derivation
from tests.families import family

Output = pytest.CaptureFixture[str]

NEXT = {"K2": 1, "K3": 1, "K4": 1, "L2": "-1/16", "L3": 0, "L4": 0}
KAWAHARA = {"K2": "4/3 - eps**2/3", "K3": 1, "K4": 0, "L2": "-1/12 + eps**2/12", "L3": 0, "L4": 0}
FPUT = {"K2": 1, "K3": 0, "K4": 1}
DIMER = FPUT | {"m1": 1, "m2": 3}

CASES: dict[str, tuple[str, dict[str, Any], dict[str, Any], str]] = {
    "small": ("fput_strain", FPUT | {"K3": "5*eps"}, {}, "gardner_soliton"),
    "small, displacement": ("fput", FPUT | {"K3": "eps/2"}, {}, "gardner_soliton"),
    "smaller": ("fput_strain", FPUT | {"K3": "5*eps**2"}, {}, "rational_2"),
    "quadratic": ("fput_strain", FPUT | {"K3": "1/2"}, {}, "kdv_soliton"),
    "nearly quadratic": ("fput_strain", FPUT | {"K3": "1 + eps"}, {}, "kdv_soliton"),
    "cubic": ("fput", FPUT, {}, "rational_2"),
    "dimer": ("mass_dimer", DIMER, {}, "rational_2"),
    "Kawahara": ("next_nearest", KAWAHARA, {}, "kawahara_soliton"),
    "mean": ("fput_strain", FPUT | {"K3": "1/2"}, {"background": "-K3/(3*K4)"}, "rational_2"),
    "small mean": (
        "fput_strain",
        FPUT | {"K3": "eps/2"},
        {"background": "-K3/(3*K4)"},
        "rational_2",
    ),
}
PARAMETERS = {"gardner_soliton": {"kappa": 1}, "kdv_soliton": {"kappa": 1}}


def words(lattice: str, constants: dict[str, Any], ansatz: dict[str, Any]) -> list[str]:
    values = ",".join(f"{name}={value}" for name, value in constants.items())
    return [lattice, "--set", values, *(f"--{name}={value}" for name, value in ansatz.items())]


@pytest.mark.parametrize("name", family(CASES, slow=("Kawahara",)))
def test_the_command_finds_the_same_ansatz_as_a_scene(name: str, capsys: Output) -> None:
    """Catches: a formula, an ansatz or a background that one of the two reads in another way."""
    lattice, constants, ansatz, wave = CASES[name]
    given: dict[str, Any] = {"name": "one", "lattice": lattice, "constants": constants}
    given |= {"wave": wave, "parameters": PARAMETERS.get(wave, {}), "eps": 0.1}
    scene = Scene.of(**given, **ansatz, slow_times=[0, 1], half_width=4, tolerance=1e-3)
    expected = derivation(scene)
    assert main([*words(lattice, constants, ansatz), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    form = expected.normal_form
    names = {name: found["normal_form"][name] for name in form.values}
    assert found["normal_form"]["equation"] == form.equation
    assert names == {name: text_of(value) for name, value in form.values.items()}
    scaling = expected.source.scaling  # type: ignore[union-attr]
    assert (found["scaling"]["amplitude"], found["scaling"]["time"]) == (
        scaling.amplitude,
        scaling.time,
    )


@pytest.mark.parametrize("ansatz", [{}, {"amplitude": 4}, {"time": 5}])
def test_a_slower_time_is_found_where_dispersion_vanishes(
    ansatz: dict[str, int], capsys: Output
) -> None:
    assert main(words("next_nearest", NEXT, ansatz)) == 0
    out = capsys.readouterr().out
    assert "reduced equation (order eps^10), fifth-order KdV:\n" in out
    assert "  Y_T + (1/c) Y Y_X - (1/(240 c)) Y_5X = 0\n" in out


def test_the_chosen_ansatz_is_printed_with_the_refused_ones(capsys: Output) -> None:
    assert main(["--k3", "1/2"]) == 0
    out = capsys.readouterr().out
    assert "  F(x) = K2 x + 1/2 x^2 + K4 x^3\n" in out
    assert "  Y_T + (1/(2 c)) Y Y_X + (c/24) Y_XXX = 0\n" in out
    assert "found: amplitude 2, time 3, as the usual ansatz\n  is refused: constants must" in out


def test_a_small_constant_is_put_in_and_the_others_stay_symbols(capsys: Output) -> None:
    assert main(["--set", "K3=5*eps,K4=-1"]) == 0
    out = capsys.readouterr().out
    assert "  Y_T + (3 K4/(2 c)) Y^2 Y_X + (5/c) Y Y_X + (c/24) Y_XXX = 0\n" in out
    assert "coefficients at K4 = -1:\n" in out
    assert out.endswith("  defocusing Gardner\n")
    assert "found" not in out


def test_an_envelope_takes_a_small_constant(capsys: Output) -> None:
    """It changes nothing but later orders: K3 = eps/2 has the NLS equation of K3 = 0."""
    given = ["fput", "--envelope", "k=1", "--order", "3", "--json", "--set"]
    assert main([*given, "K2=1,K4=1,K3=eps/2"]) == 0
    small = json.loads(capsys.readouterr().out)["numbers"]
    assert main([*given, "K2=1,K4=1,K3=0"]) == 0
    assert small == json.loads(capsys.readouterr().out)["numbers"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--k3", "5*esp"], "K3: expected a known name, got 'esp' (did you mean eps?)"),
        (["--k3", "1/2", "--amplitude", "1", "--time", "3"], "small, such as 5*eps, a background"),
        (["--set", "K3=0,K4=0"], "the coefficient of Y^2 Y_X must not vanish"),
        (["--background", "K5"], "background: expected a known name, got 'K5'"),
        (["toda", "--set", "b=eps"], "b must satisfy b > 0, got eps (toda)"),
        (["granular", "--set", "A=1,d=0"], "a sonic vacuum without linear waves to expand about: "),
    ],
)
def test_an_ansatz_that_cannot_be_found_is_refused(
    arguments: list[str], message: str, capsys: Output
) -> None:
    assert main(arguments) == 2
    assert message in capsys.readouterr().err


def test_find_scaling_takes_constants_a_background_and_part_of_an_ansatz() -> None:
    chain = LATTICES["fput_strain"]
    [gardner] = find_scaling(chain, K2=1, K3="5*eps", K4=1)
    assert gardner.pde.text() == "Y_T + (3/(2 c)) Y^2 Y_X + (5/c) Y Y_X + (1/(24 c)) Y_XXX = 0"
    [shifted] = find_scaling(chain, "-K3/(3*K4)", K2=1, K3="1/2", K4=1)
    assert (shifted.pde.kind, shifted.scaling.amplitude) == ("mKdV", 1)
    [mkdv] = find_scaling(chain, amplitude=1)
    assert mkdv.pde.kind == "mKdV"
    displacement = find_scaling(LATTICES["fput"], "1/3", K2=1, K3=1, K4=1)[0]
    assert displacement.lattice.equations()[1] == "F(x) = 2 x + 2 x^2 + x^3"
    with pytest.raises(ValueError, match=r"got amplitude 3 \(what balances: amplitude 2, time 3"):
        find_scaling(chain, amplitude=3, K3=1)


def test_a_small_constant_is_refused_where_it_is_too_late() -> None:
    [found] = find_scaling(LATTICES["fput_strain"], amplitude=1)
    with pytest.raises(ValueError, match=r"with_values\({'K3': '5\*eps'}\)"):
        found.coefficients(K3="5*eps")
