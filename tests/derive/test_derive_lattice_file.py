"""Lattices from files: their meaning; nothing else is read or evaluated, and none hangs."""

from pathlib import Path
from typing import Any

import pytest
from sympy import simplify

from longwave.derive import LATTICES, Scaling, envelope, lattice_of, read_lattice, reduce
from longwave.derive.__main__ import main
from longwave.derive.balances import find_scaling

DIMER = """
name = "two_masses"
fields = ["u", "v"]
masses = ["m1", "m2"]
positive = ["K2", "m1", "m2"]

[[spring]]
between = ["u[n]", "v[n]"]
force = "K2*x + K3*x**2 + K4*x**3"

[[spring]]
between = ["v[n]", "u[n+1]"]
force = "K2*x + K3*x**2 + K4*x**3"
"""

STRAIN = """
fields = ["y"]
positive = ["K2"]
[[bond]]
stretch = "y[n]"
action = {y = "F[n+1] - 2*F[n] + F[n-1]"}
force = "K2*x + K3*x**2 + K4*x**3"
"""

SQUARE = """
fields = ["u"]
positive = ["K2", "H2"]
[[spring]]
between = ["u[n, m]", "u[n+1, m]"]
force = "K2*x + K3*x**2 + K4*x**3"
[[spring]]
between = ["u[n, m]", "u[n, m+1]"]
force = "H2*x + H3*x**2 + H4*x**3"
"""


def written(folder: Path, text: str, name: str = "lattice.toml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("text", "name"), [(DIMER, "mass_dimer"), (STRAIN, "fput_strain"), (SQUARE, "square")]
)
def test_a_file_is_the_lattice_of_the_catalogue(text: str, name: str, tmp_path: Path) -> None:
    found, known = read_lattice(written(tmp_path, text)), LATTICES[name]
    assert (found.fields, found.masses, found.bonds) == (known.fields, known.masses, known.bonds)


def test_masses_are_numbers_as_they_are_written(tmp_path: Path) -> None:
    of_numbers, of_text = (
        read_lattice(written(tmp_path, DIMER.replace('["m1", "m2"]', masses)))
        for masses in ("[0.02, 1e-3]", '["1/50", "1/1000"]')
    )
    assert of_numbers.masses == of_text.masses


@pytest.mark.parametrize("force", ["-A*contact(-x)**(3/2)", "A*x**3"])
def test_a_lattice_without_sound_is_refused(force: str, tmp_path: Path) -> None:
    """Catches: grains without compression, of which the conditions of the expansion were told."""
    spring = f'[[spring]]\nbetween = ["u[n]", "u[n+1]"]\nforce = "{force}"\n'
    found = read_lattice(written(tmp_path, f'fields = ["u"]\npositive = ["A"]\n{spring}'))
    with pytest.raises(ValueError, match="there is no sound: the linear stiffness at rest is 0"):
        find_scaling(found)


def test_any_smooth_force_is_read_and_reduced(tmp_path: Path) -> None:
    text = 'fields = ["u"]\npositive = ["a"]\n[[spring]]\nbetween = ["u[n]", "u[n+1]"]\n'
    lattice = read_lattice(written(tmp_path, text + 'force = "sinh(a*x) + tanh(x)**2"\n'))
    found = reduce(lattice, Scaling(1), 5).coefficients(a=4)
    assert (found.c, found.terms["Y Y_X"]) == (2, simplify(1 / found.c))


def test_a_site_is_tied_to_its_place() -> None:
    spring = {"between": ["u[n]", "u[n+1]"], "force": "K2*x"}
    tie = {"field": "u", "force": "g*sin(x)"}
    lattice = lattice_of({"fields": ["u"], "spring": [spring], "site": [tie]})
    assert lattice.equations()[0] == "u_n'' = F1(u_{n+1} - u_n) - F1(u_n - u_{n-1}) - F2(u_n)"


def test_a_site_of_a_plane_is_tied_to_its_place() -> None:
    """Catches: a site force with one axis on a lattice with two."""
    springs = [{"between": ["u[n, m]", end], "force": "K2*x"} for end in ("u[n+1, m]", "u[n, m+1]")]
    tie = {"field": "u", "force": "g*sin(x)"}
    lattice = lattice_of({"fields": ["u"], "spring": springs, "site": [tie]})
    assert lattice.dimension == 2
    assert lattice.equations()[0].endswith("- F3(u_{n,m})")


def test_the_command_derives_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, DIMER)
    assert main([str(path), "--set", "m1=1,m2=3,K2=1,K3=1/4,K4=0"]) == 0
    assert "of Y_XXX: 7 sqrt(2)/1536" in capsys.readouterr().out
    assert main(["check", str(path)]) == 0
    assert capsys.readouterr().out.count("agrees: ") == 3


SPRING = '[[spring]]\nbetween = ["u[n]", "u[n+1]"]\nforce = "K*x"\n'
HEAD = 'fields = ["u"]\n'
HOSTILE: dict[str, tuple[str, str]] = {
    "title": (HEAD + 'title = "\\u001b"\n' + SPRING, "title must be one printable line of 200"),
    "name": (HEAD + "name = 5\n" + SPRING, "name must be one printable line of 200 .* got 5"),
    "empty": ("", "fields must be a list of names, got None"),
    "no toml": ("fields = [", "lattice must be a TOML file, got"),
    "no utf-8": ("fields = ['\udcff']", "lattice must be a text in UTF-8, got"),
    "deep toml": ("x = " + "[" * 5000, "lattice must be nested at most 100 deep, got"),
    "no bonds": (HEAD, "bonds must be given"),
    "key": (HEAD + "mass = [1]\n" + SPRING, "got 'mass' .did you mean masses"),
    "key of a spring": (HEAD + SPRING + "law = 1\n", r"\[\[spring\]\] 1: keys|keys must be known"),
    "field text": ("fields = 'u'\n" + SPRING, "fields must be a list of names"),
    "long name": (f'fields = ["{"u" * 99}"]\n' + SPRING, "fields must be a list of names"),
    "field name": ('fields = ["u_1"]\n' + SPRING, "must be among u_1, got 'u'"),
    "masses": (HEAD + "masses = [1, 2]\n" + SPRING, "masses must be a list of 1"),
    "mass 0": (HEAD + "masses = [0]\n" + SPRING, "mass must satisfy mass > 0"),
    "mass inf": (HEAD + "masses = [inf]\n" + SPRING, "must be a finite real number"),
    "mass float": (HEAD + "masses = [-1.5]\n" + SPRING, "mass must satisfy mass > 0"),
    "one site": (HEAD + SPRING.replace(', "u[n+1]"', ""), "between must be two sites"),
    "three": (HEAD + SPRING.replace('"u[n]",', '"u[n] + u[n-1]",'), "between must be two sites"),
    "site": (HEAD + SPRING.replace("u[n]", "u[k]"), "must be a sum of sites"),
    "site far": (HEAD + SPRING.replace("u[n]", "u[n+9999999]"), "must be a sum of sites"),
    "other field": (HEAD + SPRING.replace("u[n]", "w[n]"), "between must be among u, got 'w'"),
    "call": (HEAD + SPRING.replace("K*x", "__import__('os')"), "expected a formula"),
    "attribute": (HEAD + SPRING.replace("K*x", "x.evalf()"), "expected"),
    "tower": (HEAD + SPRING.replace("K*x", "9**9**9**9*x"), "exponents must be at most"),
    "brackets": (HEAD + SPRING.replace("K*x", "(" * 10000), "at most 40 deep"),
    "long": (HEAD + SPRING.replace("K*x", "x+" * 20000 + "x"), "at most 20000 characters"),
    "huge": (HEAD + "#" * 200_000, "lattice must have at most 100000 bytes, got"),
    "root": (HEAD + SPRING.replace("K*x", "sqrt(x)"), "smooth about zero stretch"),
    "pole": (HEAD + SPRING.replace("K*x", "1/x"), "smooth about zero stretch"),
    "complex": (HEAD + SPRING.replace("K*x", "I*x"), "must be a finite real number"),
    "mass x": (HEAD + 'masses = ["x"]\n' + SPRING, "mass must not depend on the stretch x"),
    "reserved": (HEAD + SPRING.replace("K*x", "T*x"), "must have names other than"),
    "axes": (
        HEAD + SPRING + SPRING.replace("u[n]", "u[n, m]").replace("u[n+1]", "u[n, m+1]"),
        "must name one of 1 fields and shift along 1 axes",
    ),
    "many": (HEAD + SPRING * 51, "at most 50"),
    "action": (
        HEAD + '[[bond]]\nstretch = "u[n]"\naction = {u = "G[n]"}\nforce = "x"\n',
        "action must be a sum of F",
    ),
    "no action": (HEAD + '[[bond]]\nstretch = "u[n]"\nforce = "x"\n', "action must name fields"),
    "no force": (HEAD + '[[site]]\nfield = "u"\n', "force must be text, got None"),
    "number of a list": ("fields = [1]\n" + SPRING, "fields must be a list of names"),
    "spring text": (HEAD + 'spring = "u"\n', r"spring must be \[\[spring\]\] tables"),
    "spring entry": (HEAD + "spring = [1]\n", r"must be a table"),
}  # fmt: skip


@pytest.mark.parametrize("name", HOSTILE)
def test_an_invalid_lattice_is_refused_in_one_line(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text, message = HOSTILE[name]
    path = tmp_path / "lattice.toml"
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(ValueError, match=message):
        read_lattice(path)
    assert main([str(path)]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ")
    assert "lattice.toml" in error
    assert error.count("\n") == 1
    assert len(error) < 500


COMMANDS: dict[str, tuple[list[str], str]] = {
    "no such model": (["nothing"], "MODEL must be a lattice or a file of one, got 'nothing'"),
    "two models": (["fput", "toda"], "MODEL must be one"),
    "no such file": (["nothing.toml"], "nothing.toml: No such file"),
    "set": (["fput", "--set", "K2"], "--set must be NAME=VALUE, got 'K2'"),
    "set unknown": (["fput", "--set", "K9=1"], "constants must be among"),
    "set text": (["fput", "--set", "K2=one"], "K2: expected a known name, got 'one'"),
    "orders": (["fput", "--orders", "99"], "--order must be a whole number from 0 to 13"),
    "amplitude": (["fput", "--amplitude", "-1"], "--amplitude must be a whole number"),
    "pinned": (["klein_gordon"], "no scaling fits klein_gordon"),
    "background": (["mass_dimer", "--background", "1/2"], "background must be left out"),
    "carrier": (["fput", "--envelope", "q=1"], "--envelope must be k or k=NUMBER"),
    "carrier 9": (["fput_strain", "--envelope", "k=9"], "k must satisfy 0 <= k <= pi"),
    "carrier text": (["fput", "--envelope", "k=exit()"], "--envelope: k: expected"),
    "branch": (["fput", "--envelope", "k=1", "--branch", "high"], "branch must be acoustic"),
    "both": (
        ["fput", "--envelope", "k", "--orders", "5"],
        "--order must be 3 (the NLS equation) or 4",
    ),
    "square": (["square", "--envelope", "k"], "lattice must have one axis"),
}


@pytest.mark.parametrize("name", COMMANDS)
def test_wrong_arguments_are_refused_in_one_line(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    words, message = COMMANDS[name]
    assert main(words) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ")
    assert message in error
    assert error.count("\n") == 1


def test_an_envelope_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    words: list[Any] = ["fput_strain", "--envelope", "k=pi/2", "--set", "K2=1,K3=0,K4=1"]
    assert main(words) == 0
    out = capsys.readouterr().out
    assert "at k = pi/2:" in out
    assert "unstable, solitons bright" in out
    assert main(["fput_strain", "--envelope", "k", "--json"]) == 0
    assert '"p": "-omega/8"' in capsys.readouterr().out
    assert main(["check", "fput_strain", "--envelope", "k"]) == 0
    assert "agrees: a1 + a2 = -dq/dk (exactly" in capsys.readouterr().out


def test_a_small_constant_is_read(tmp_path: Path) -> None:
    force = "K2*x + eps*k3*x**2 + K4*x**3"
    lattice = read_lattice(written(tmp_path, STRAIN.replace("K2*x + K3*x**2 + K4*x**3", force)))
    assert reduce(lattice).pde.kind == "Gardner"


@pytest.mark.parametrize("name", ["z", "w", "s", "omega"])
def test_a_constant_may_be_called_as_any_of_the_carriers_own(name: str) -> None:
    """A constant s was taken for sin(k/2)."""
    found = []
    for called in (name, "K3"):
        spring = {"between": ["u[n]", "u[n+1]"], "force": f"K*x + {called}*x**2"}
        lattice = lattice_of({"fields": ["u"], "positive": ["K"], "spring": [spring]})
        found.append(envelope(lattice).coefficients(1, **{"K": 2, called: 3}))
    assert found[0] == found[1]


def test_maps_and_orders_are_printed_in_every_form(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["fput", "--envelope", "k", "--map", "2", "--set", "K2=1,K3=0,K4=1"]
    for form, fragment in (
        ([], "growth rate"),
        (["--json"], '"focusing": true'),
        (["--latex"], "tabular"),
    ):
        assert main([*words, *form]) == 0
        assert fragment in capsys.readouterr().out
    at = ["fput", "--envelope", "k=pi", "--set", "K2=1,K3=0,K4=1", "--order", "3"]
    for form in ([], ["--json"], ["--latex"]):
        assert main([*at, *form]) == 0
        out = capsys.readouterr().out
        assert "a1" not in out
        assert "-0.25" in out


def test_a_background_strains_a_chain_of_displacements(capsys: pytest.CaptureFixture[str]) -> None:
    """It only shifted them, and nothing changed."""
    assert main(["fput", "--background", "1/2", "--order", "5"]) == 0
    assert "c^2 = K3 + K2 + 3 K4/4" in capsys.readouterr().out
