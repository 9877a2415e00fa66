"""Names of constants and of the output's own, and bonds without an energy."""

from typing import Any

import pytest
from sympy import Symbol

from longwave.derive import LATTICES, reduce
from longwave.derive.__main__ import main
from longwave.derive.lattice import Lattice, on_site, spring
from longwave.derive.lattice_file import lattice_of
from longwave.derive.symbols import x
from searches.output_names import NAMES, collisions, document
from tests.families import family

CHAIN: dict[str, Any] = {
    "fields": ["u"],
    "positive": ["K"],
    "spring": [{"between": ["u[n]", "u[n+1]"], "force": "K*x + x**3"}],
}
TURNED: dict[str, Any] = {
    "fields": ["u", "phi"],
    "masses": ["m", "J"],
    "positive": ["m", "J", "ks", "kr", "kt"],
    "spring": [
        {"between": ["u[n]", "u[n+1]"], "force": "ks*x + x**3"},
        {"between": ["phi[n]", "phi[n+1]"], "force": "kt*x"},
    ],
    "bond": [
        {
            "stretch": "u[n+1] - u[n] + phi[n] + phi[n+1]",
            "force": "kr*x + x**2",
            "action": {"u": "F[n] - F[n-1]", "phi": "-F[n] - F[n-1]"},
        }
    ],
}
"""Masses that turn: bending acts on the angles by minus the mirror of its stretch."""


def chain_file(tmp_path: Any, text: str) -> str:
    """Write a lattice file with that text; return its path."""
    path = tmp_path / "chain.toml"
    path.write_text(text)
    return str(path)


@pytest.mark.parametrize("name", family(NAMES, quick=("F2",)))
def test_no_name_of_an_output_is_a_constants_too(name: str) -> None:
    """Catches: b = sqrt(a) b/24, F2 of a force inside F2 of a correction."""
    assert list(collisions(name)) == []


def test_names_that_are_taken_are_marked(tmp_path: Any, capsys: pytest.CaptureFixture[str]) -> None:
    path = chain_file(tmp_path, document("h", "power", pinned=False))
    assert main([path]) == 0
    output = capsys.readouterr().out
    assert "Y(X, T) = h~ U(a X, b T):" in output
    assert "\n  h~ = " in output
    assert main([path, "--latex"]) == 0
    assert r"\tilde{h} = " in capsys.readouterr().out
    assert main(["toda"]) == 0
    assert "b~ = sqrt(a) sqrt(b)/24" in capsys.readouterr().out
    assert main(["granular", "--envelope", "k=pi"]) == 0
    assert "carrier: u_n = eps A~(X, T)" in capsys.readouterr().out


@pytest.mark.parametrize("kind", ["spring", "site", "mass", "loss"])
def test_a_field_is_no_constant(kind: str) -> None:
    """Catches: a field in a force that silently becomes a constant."""
    changes: dict[str, Any] = {
        "spring": {"spring": [{**CHAIN["spring"][0], "force": "K*x + g*u**3*x**3"}]},
        "site": {"site": [{"field": "u", "force": "-w2*u"}]},
        "mass": {"masses": ["u"]},
        "loss": {},
    }
    with pytest.raises(ValueError, match=r"got u \(u is a field: .* write x, its stretch\)"):
        lattice_of({**CHAIN, **changes[kind]}).with_losses(site="eps^3*u")


def test_a_reserved_name_is_refused_with_its_meaning() -> None:
    """Catches: a spring constant k refused with a bracket on other names."""
    spring_of_k = {**CHAIN["spring"][0], "force": "k*x + x**3"}
    with pytest.raises(ValueError, match=r"got k \(k is the wavenumber: .* such as k1\)$"):
        lattice_of({**CHAIN, "positive": [], "spring": [spring_of_k]})
    for word, meaning in {"x": "stretch", "u": "a field", "I": "a number"}.items():
        with pytest.raises(ValueError, match=f"got {word}.*{meaning}"):
            lattice_of({**CHAIN, "positive": [word]})
    with pytest.raises(ValueError, match=r"fields must have names other than .* got x"):
        lattice_of({"fields": ["x"], "site": [{"field": "x", "force": "x"}]})


def test_powers_of_one_symbol_are_joined() -> None:
    """Catches: h = -d^(-1 - p) d^(2 + p)/(2 (1 + p)) for -d/(2 (1 + p))."""
    A, d, M, p = (Symbol(name, positive=True) for name in "AdMp")
    law = spring(-A * (d + x) ** (-p), ((0,), 0), ((1,), 0))
    form = reduce(Lattice("power", "power", ("u",), (M,), (law,))).normal_form()
    assert str(form.h) == "-d/(2*(p + 1))"


def test_a_force_is_printed_without_a_factor_of_one() -> None:
    tied = Lattice("tied", "tied", ("u",), (1,), (on_site(x - x**3),))
    assert tied.equations()[1] == "F(x) = x - x^3"
    assert on_site(x - 1).force == x - 1


def test_an_action_that_is_no_mirror_of_its_stretch_is_reported(
    tmp_path: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    """Catches: a sign slip that derives an equation without a word."""
    assert lattice_of(TURNED).missing_energies == ()
    slip = {"u": "F[n] - F[n-1]", "phi": "F[n] + F[n-1]"}
    bond = {**TURNED["bond"][0], "action": slip}
    word = "F3 acts on phi by F[n] + F[n-1], an energy of its stretch by -F[n] - F[n-1]"
    assert lattice_of({**TURNED, "bond": [bond]}).missing_energies == (word,)
    text = (
        'fields = ["u", "phi"]\npositive = ["kt"]\n'
        '[[spring]]\nbetween = ["u[n]", "u[n+1]"]\nforce = "x + x**3"\n'
        '[[spring]]\nbetween = ["phi[n]", "phi[n+1]"]\nforce = "kt*x"\n'
        '[[bond]]\nstretch = "u[n+1] - u[n] + phi[n] + phi[n+1]"\nforce = "x + x**2"\n'
        'action = {u = "F[n] - F[n-1]", phi = "F[n] + F[n-1]"}\n'
    )
    path = chain_file(tmp_path, text)
    for words, begin in (([], "  not an energy: "), (["--latex"], "% not an energy: ")):
        assert main([path, *words]) == 0
        assert begin + word in capsys.readouterr().out
    assert main([path, "--json"]) == 0
    assert word in capsys.readouterr().out


def test_springs_that_push_and_pull_unequally_are_named_where_refused(
    tmp_path: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    head = 'fields = ["u"]\n[[bond]]\nstretch = "u[n+1] - u[n]"\nforce = "x + x**3"\n'
    path = chain_file(tmp_path, head + 'action = {u = "2*F[n] - F[n-1]"}\n')
    assert main([path]) == 2
    error = capsys.readouterr().err
    assert "F acts on u by 2*F[n] - F[n-1], an energy of its stretch by F[n] - F[n-1]" in error
    path = chain_file(tmp_path, head + 'action = {u = "3/2*F[n] - 1/2*F[n-1]"}\n')
    assert main([path]) == 2
    assert "weights are whole numbers: put a factor into the force" in capsys.readouterr().err


@pytest.mark.parametrize("name", sorted(LATTICES))
def test_every_lattice_of_the_catalogue_has_an_energy(name: str) -> None:
    """Strains too: their stencils are a common one, the second difference, times mirrors."""
    assert LATTICES[name].missing_energies == ()


def test_a_sign_slip_in_strains_is_reported() -> None:
    """Catches: a common stencil that is taken for positive or symmetric without a look."""
    strains = {"fields": ["y"], "bond": [{"stretch": "y[n]", "force": "x + x**2"}]}
    for action in ("-F[n+1] + 2*F[n] - F[n-1]", "F[n+1] - F[n] + F[n-1]", "F[n+1] - F[n]"):
        bond = {**strains["bond"][0], "action": {"y": action}}
        assert lattice_of({**strains, "bond": [bond]}).missing_energies != (), action
