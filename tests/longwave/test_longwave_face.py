"""The package `longwave`: every public name is the object of its room, an unknown one is reported,
and wrong calls end in one line with argument, condition, value and remedy."""

import re
from collections.abc import Callable
from importlib import import_module
from importlib.metadata import version

import pytest

import longwave
from longwave.derive import Bond, SlowVariable, Stencil
from longwave.derive.symbols import K2, c, x

FPUT = longwave.LATTICES["fput_strain"]
NORMAL_FORM = longwave.mkdv_normal_form(1, 1)
DN = longwave.closed_form("soliton_dn")
HERE = (Stencil((0,)),)

WRONG_CALLS: dict[str, tuple[Callable[[], object], str]] = {
    "reduce(3)": (lambda: longwave.reduce(3), "lattice"),
    "reduce, name": (lambda: longwave.reduce("fput_strain"), "lattice"),
    "reduce, scaling": (lambda: longwave.reduce(FPUT, 3), "scaling"),
    "reduce, orders": (lambda: longwave.reduce(FPUT, orders="7"), "orders"),
    "Lattice, name": (lambda: longwave.Lattice(3, "t", ("y",), (1,), FPUT.bonds), "name"),
    "Lattice, title": (lambda: longwave.Lattice("n", None, ("y",), (1,), FPUT.bonds), "title"),
    "Lattice, fields": (lambda: longwave.Lattice("n", "t", "y", (1,), FPUT.bonds), "fields"),
    "Lattice, field 3": (lambda: longwave.Lattice("n", "t", (3,), (1,), FPUT.bonds), "fields"),
    "Lattice, field 3y": (lambda: longwave.Lattice("n", "t", ("3y",), (1,), FPUT.bonds), "fields"),
    "Lattice, mass": (lambda: longwave.Lattice("n", "t", ("y",), ("m m",), FPUT.bonds), "mass"),
    "Lattice, masses": (lambda: longwave.Lattice("n", "t", ("y",), 1, FPUT.bonds), "masses"),
    "Lattice, no mass": (lambda: longwave.Lattice("n", "t", ("y",), (), FPUT.bonds), "masses"),
    "Lattice, a bond": (
        lambda: longwave.Lattice("n", "t", ("y",), (1,), FPUT.bonds[0]),
        "bonds",
    ),
    "Lattice, force": (lambda: longwave.Lattice("n", "t", ("y",), (1,), ("K2 x",)), "bonds"),
    "Bond, force": (lambda: Bond(HERE, "K2*x", HERE), "force"),
    "Bond, float": (lambda: Bond(HERE, 0.1 * x, HERE), "force"),
    "Bond, stretch": (lambda: Bond((0,), K2 * x, HERE), "stretch"),
    "Stencil, shift": (lambda: Stencil(1), "shift"),
    "Stencil, text": (lambda: Stencil(("1",)), "shift"),
    "Scaling, amplitude": (lambda: longwave.Scaling("1"), "amplitude"),
    "Scaling, time": (lambda: longwave.Scaling(time=None), "time"),
    "Scaling, space": (lambda: longwave.Scaling(space="X"), "space"),
    "Scaling, names": (lambda: longwave.Scaling(space=("X",)), "space"),
    "Scaling, background": (lambda: longwave.Scaling(background=3), "background"),
    "Scaling, no pair": (lambda: longwave.Scaling(background=(3,)), "background"),
    "Scaling, triple": (lambda: longwave.Scaling(background=((0, K2, 1),)), "background"),
    "SlowVariable, speed": (lambda: SlowVariable("X", 1, (1,), "fast"), "speed"),
    "SlowVariable, direction": (lambda: SlowVariable("X", 1, "n", c), "direction"),
    "mkdv_normal_form, text": (lambda: longwave.mkdv_normal_form("x", 1), "K2"),
    "mkdv_normal_form, None": (lambda: longwave.mkdv_normal_form(1, None), "K4"),
    "mkdv_normal_form, list": (lambda: longwave.mkdv_normal_form([1], 1), "K2"),
    "NormalForm, text": (lambda: longwave.NormalForm("a", 1, 1, 1), "a"),
    "NormalForm, None": (lambda: longwave.NormalForm(1, None, 1, 1), "b"),
    "NormalForm, sign": (lambda: longwave.NormalForm(1, 1, 3, 1), "s"),
    "coefficients, list": (lambda: longwave.reduce(FPUT).coefficients(K2=[1]), "K2"),
    "normal_form, name": (lambda: longwave.reduce(FPUT).normal_form(K5=1), "constants"),
    "closed_form, number": (lambda: longwave.closed_form(3), "name"),
    "closed_form, name": (lambda: longwave.closed_form("peakon"), "name"),
    "Equation, number": (lambda: longwave.Equation(3, 3), "name"),
    "Equation, sign": (lambda: longwave.Equation("mkdv", 3), "s"),
    "Parameter, number": (lambda: longwave.Parameter(3), "symbol"),
    "Wave, numbers": (lambda: longwave.Wave(1, NORMAL_FORM), "form"),
    "Wave, name": (lambda: longwave.Wave("peakon", NORMAL_FORM), ""),
    "Wave, normal form": (lambda: longwave.Wave(DN, 3, k=0.5), "normal_form"),
    "Wave, text": (lambda: longwave.Wave(DN, NORMAL_FORM, k="x"), "k"),
    "Wave, None": (lambda: longwave.Wave(DN, NORMAL_FORM, k=None), "k"),
    "Wave, domain": (lambda: longwave.Wave(DN, NORMAL_FORM, k=2), "k"),
    "Wave, missing": (lambda: longwave.Wave(DN, NORMAL_FORM), ""),
    "wave at text": (lambda: longwave.Wave(DN, NORMAL_FORM, k=0.5)("a", 0), "every position"),
    "wave at None": (lambda: longwave.Wave(DN, NORMAL_FORM, k=0.5)(0, None), "every "),
    "prove, equation": (lambda: longwave.prove(3, 3), ""),
    "prove, formula": (lambda: longwave.prove(DN.equation, "tanh(xi)"), ""),
    "prove_equal, text": (lambda: longwave.prove_equal("a", "b", ()), ""),
    "check_certificate, number": (lambda: longwave.check_certificate(3), ""),
    "check_certificate, text": (lambda: longwave.check_certificate("nope"), ""),
    "load_scene, number": (lambda: longwave.load_scene(3), "scene"),
    "load_scene, name": (lambda: longwave.load_scene("x"), "scene"),
    "run, name": (lambda: longwave.run("x"), "scene"),
    "run, number": (lambda: longwave.run(3), "scene"),
    "relative_sup_error, text": (lambda: longwave.relative_sup_error("a", "b", 0.0), ""),
    "plot, number": (lambda: longwave.plot(5), "source"),
    "plot, None": (lambda: longwave.plot(None), "source"),
    "plot, name": (lambda: longwave.plot("x"), "scene"),
    "plot, output": (lambda: longwave.plot("rogue_cn_k_0.5", 3), "output"),
    "plot, suffix": (lambda: longwave.plot("rogue_cn_k_0.5", "x.txt"), "output"),
    "plot, kind": (lambda: longwave.plot("rogue_cn_k_0.5", None, []), "kind"),
}
"""What is called, and how the message must begin."""


@pytest.mark.parametrize("call", WRONG_CALLS)
def test_a_wrong_call_ends_in_one_line(call: str) -> None:
    wrong, argument = WRONG_CALLS[call]
    with pytest.raises((ValueError, TypeError)) as refused:
        wrong()
    message = str(refused.value)
    assert "\n" not in message
    assert re.search(r"\bmust\b.*\bgot\b.*\(.*\)$", message), message
    assert argument in message.partition("must")[0]


def test_objects_are_shown_in_one_line_and_formulas_in_notebooks() -> None:
    """Catches: a repr with an address, or with the whole tree of an object's parts."""
    reduction = longwave.reduce(FPUT)
    formulas = (reduction, reduction.pde, FPUT, longwave.Scaling(), NORMAL_FORM, DN, DN.equation)
    wave = longwave.Wave(DN, NORMAL_FORM, k=0.5)
    proved = longwave.prove(DN.equation, 0 * DN.equation.xi)
    scene = longwave.load_scene("rogue_cn_k_0.5")
    for thing in (*formulas, wave, longwave.CATALOGUE, DN.parameters[0], scene, proved):
        shown = repr(thing)
        assert "\n" not in shown
        assert " at 0x" not in shown
        assert len(shown) < 300
    for thing in (*formulas, wave):
        assert thing._repr_latex_().startswith(r"$\displaystyle ")


def test_the_version_is_that_of_the_distribution() -> None:
    assert longwave.__version__ == version("longwave")


@pytest.mark.parametrize(
    ("room", "noun"),
    [
        (room, noun)
        for room in longwave._PUBLIC_NAMES
        for noun in longwave._PUBLIC_NAMES[room].split()
    ],
)
def test_each_public_name_is_the_object_of_its_room(room: str, noun: str) -> None:
    assert getattr(longwave, noun) is getattr(import_module(room), noun)
    assert noun in longwave.__all__


def test_an_unknown_public_name_lists_the_known_ones() -> None:
    with pytest.raises(AttributeError, match=r"no public name 'zeta' .one of .*Scene"):
        _ = longwave.zeta


def test_dir_lists_the_public_names() -> None:
    assert set(longwave.__all__) <= set(dir(longwave))
