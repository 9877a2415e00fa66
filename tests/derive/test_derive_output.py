"""Text, LaTeX, JSON and the command line."""

import json
import subprocess
import sys
from typing import Any

import pytest

from longwave.derive import LATTICES, Reduction, Scaling, reduce
from longwave.derive.__main__ import main
from longwave.derive.algebra.jets import DifferentialPolynomial
from longwave.derive.algebra.rational_functions import RationalFunction, RationalFunctions
from longwave.derive.output.notation import Notation


def polynomial_from_data(data: Any, field: RationalFunctions) -> DifferentialPolynomial:
    """Return the polynomial of its JSON data, over the same field."""
    items = (
        (
            tuple(tuple(jet) for jet in term["jets"]),
            element(term["numerator"], field) / element(term["denominator"], field),
        )
        for term in data["terms"]
    )
    return DifferentialPolynomial.collect(field, items)


def element(data: list[list[Any]], field: RationalFunctions) -> RationalFunction:
    return field.from_terms([(tuple(exponents), int(number)) for exponents, number in data])


@pytest.fixture(scope="module")
def mkdv() -> Reduction:
    return reduce(LATTICES["fput_strain"])


def test_json_round_trip(mkdv: Reduction) -> None:
    data = json.loads(mkdv.json())
    field = mkdv.pde.flow.field

    def read(entry: Any) -> DifferentialPolynomial:
        return polynomial_from_data(entry, field)

    assert {int(o): read(e) for o, e in data["orders"].items()} == {
        o: equation.polynomial for o, equation in mkdv.orders.items()
    }
    assert read(data["pde"]) == mkdv.pde.polynomial
    assert {int(p): read(e) for p, e in data["corrections"].items()} == mkdv.corrections
    assert {int(o): read(e) for o, e in data["remainders"].items()} == mkdv.remainders
    assert data["sound_condition"] == "c^2 = K2"
    assert data["conditions"][0]["vanishes"] == "K3"


def test_json_of_an_equation_without_normal_form() -> None:
    linear = reduce(LATTICES["fput_strain"], Scaling(amplitude=3), orders=7)
    assert "normal_form" not in json.loads(linear.json())


def test_json_of_a_normal_form() -> None:
    kdv = reduce(LATTICES["fput_strain"], Scaling(amplitude=2), orders=6)
    assert json.loads(kdv.json(K2=4, K3=2))["normal_form"] == {
        "equation": "KdV",
        "normal_form": "U_tau + 6 U U_xi + U_xixixi = 0",
        "map": "Y(X, T) = h U(a X, b T)",
        "a": "1",
        "b": "1/12",
        "h": "1/2",
        "c": "2",
    }


def test_latex_of_the_orders(mkdv: Reduction) -> None:
    assert mkdv.orders[3].latex() == r"\left(c^{2} - K_{2}\right) Y_{XX} = 0"
    assert mkdv.orders[4].latex() == r"K_{3} \left(Y^{2}\right)_{XX} = 0"
    expected = r"Y_{T} + \frac{3 K_{4}}{2 c} Y^{2} Y_{X} + \frac{c}{24} Y_{XXX} = 0"
    assert mkdv.pde.latex() == expected
    assert r"Y_{X}^{3}" in mkdv.latex_correction(2)
    assert mkdv.latex().count("{") == mkdv.latex().count("}")


def test_zero_prints_as_zero(mkdv: Reduction) -> None:
    zero = mkdv.pde.flow - mkdv.pde.flow
    assert Notation().text(zero) == Notation().latex(zero) == "0"


def test_report_shows_orders_condition_and_equation(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    out = capsys.readouterr().out
    for line in (
        "eps^4: K3 (Y^2)_XX = 0",
        "condition: K3 = 0: order eps^4 reads K3 (Y^2)_XX = 0",
        "Y_T + (3 K4/(2 c)) Y^2 Y_X + (c/24) Y_XXX = 0",
        "same as the reduced equation's linear part to k^3: yes",
    ):
        assert line in out


def test_numbers_on_the_command_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--k2", "4", "--k4", "-1/2", "--orders", "5"]) == 0
    out = capsys.readouterr().out
    assert "of Y^2 Y_X: -3/8" in out
    assert "s = -1" in out
    assert "eps^7" not in out


@pytest.mark.parametrize("option", ["--latex", "--json"])
def test_other_formats_take_the_numbers(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([option, "--k2", "4", "--k3", "0", "--k4", "1"]) == 0
    out = capsys.readouterr().out
    if option == "--json":
        assert json.loads(out)["coefficients"]["terms"]["Y^2 Y_X"] == "3/4"
    else:
        assert r"a = \frac{\sqrt{6}}{2}" in out
        assert "$" not in out


@pytest.mark.parametrize(
    "arguments",
    [
        ["--k2", "0"],
        ["--k2", "nan"],
        ["--k3", "1", "--amplitude", "1", "--time", "3"],
        ["--k3", "0", "--k4", "0"],
        ["--k4", "1/0"],
        ["--orders", "4"],
        ["--orders", "99"],
        ["--orders", "-1"],
        ["--orders", "seven"],
        ["--k2"],
        ["--nonsense"],
        ["--latex", "--json"],
    ],
)
def test_wrong_input_is_one_line_and_status_two(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert not out
    assert err.count("\n") == 1
    assert err.startswith("error: ")


@pytest.mark.parametrize(
    ("imported", "unwanted"),
    [
        ("derive, longwave.derive.__main__", "{'sympy', 'mpmath'}"),
        (
            "longwave.derive.output.printout",
            "{'numpy', 'scipy', 'numba', 'matplotlib', 'solutions', 'verify', 'reports'}",
        ),
    ],
)
def test_import_is_light(imported: str, unwanted: str) -> None:
    code = f"import sys, {imported}; sys.exit(len({unwanted} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_objects_show_themselves_in_one_line_and_as_formulas(mkdv: Reduction) -> None:
    """A whole tree of records would fill the screen."""
    objects: list[tuple[Any, str]] = [
        (
            mkdv,
            "Reduction(fput_strain: Y_T + (3 K4/(2 c)) Y^2 Y_X + (c/24) Y_XXX = 0, c^2 = K2, "
            "K3 = 0)",
        ),
        (
            mkdv.lattice,
            "Lattice(fput_strain: y_n'' = F(y_{n+1}) - 2 F(y_n) + F(y_{n-1}); "
            "F(x) = K2 x + K3 x^2 + K4 x^3)",
        ),
        (mkdv.scaling, "Scaling(y = eps Y(X, T), X = eps (n - c t), T = eps^3 t)"),
        (mkdv.pde, "EvolutionEquation(Y_T + (3 K4/(2 c)) Y^2 Y_X + (c/24) Y_XXX = 0)"),
        (mkdv.conditions[0], "Condition(K3 = 0: order eps^4 reads K3 (Y^2)_XX = 0)"),
        (mkdv.orders[4], "OrderEquation(K3 (Y^2)_XX = 0)"),
        (mkdv.normal_form(K2=4, K4=1), "NormalForm(a=sqrt(6)/2, b=sqrt(6)/16, s=1, c=2)"),
    ]
    for thing, line in objects:
        assert repr(thing) == line
        formula = thing._repr_latex_()
        assert formula.startswith(r"$\displaystyle ")
        assert formula.endswith("$")
        assert formula.count("{") == formula.count("}")
    assert r"\ddot{y_n} = F(y_{n+1})" in mkdv.lattice._repr_latex_()
    assert r"X = \epsilon (n - c t)" in mkdv.scaling._repr_latex_()
    assert r"c^{2} = K_{2}" in mkdv._repr_latex_()
