"""Catches: a public object that another process cannot unpickle, or unpickles as another one."""

import copy
import inspect
import pickle
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import cache, partial
from importlib import import_module
from operator import attrgetter, methodcaller
from pathlib import Path
from typing import Any

import cloudpickle
import numpy as np
import pytest
import sympy as sp

import longwave
from longwave.derive import (
    LATTICES,
    Check,
    carrier_fields,
    dispersion_relation,
    envelope,
    mkdv_normal_form,
    mkdv_reduction,
)
from longwave.lattice import (
    SCHEMES,
    DrivenChain,
    FieldRing,
    Model,
    SiteForce,
    State,
    driven_chain,
    integrate,
    spectral_integrate,
)
from longwave.lattice.numeric_lattice import NumericLattice, numeric_lattice
from longwave.lattice.state import BlowUp
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.numerics import Discretisation, Tolerance
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.time_functions import time_function
from longwave.scenes.engines.run_record import RunRecord
from longwave.scenes.observed.observables import OBSERVABLES
from longwave.scenes.starts.lattice_derivation import derivation
from longwave.scenes.starts.moving_wave import moving_wave
from longwave.solutions import CATALOGUE, ClosedForm, Wave, closed_form, rational
from longwave.verify.proof import Domain, rational_facts
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.statement_verdict import decide_statement
from longwave.verify.verdict import Outcome, Verdict

HOUSE = Path(__file__).parents[2]
FACES = (
    "longwave",
    "longwave.derive",
    "longwave.solutions",
    "longwave.lattice",
    "longwave.verify.proof",
    "longwave.runs",
)
NOUNS = {
    f"{face}.{noun}": getattr(import_module(face), noun)
    for face in FACES
    for noun in getattr(import_module(face), "__all__", ())
}
LARGEST = 30_000
"""Bytes of any pickle here that holds no field of numbers: a program or a kernel is larger."""

SITES = np.linspace(-300.0, 300.0, 41)
START = State(0.0, np.array([[0.1, 0.0, -0.1, 0.0]]), np.zeros((1, 4)))
CARRIER = 0.01 * np.cos(np.pi / 4 * np.arange(8.0))[None]
RING = FieldRing(0.0, (0.0,), (8.0,), CARRIER, 0 * CARRIER)
FIELDS = State(0.0, CARRIER, 0 * CARRIER)


@cache
def toda_chain() -> NumericLattice:
    return numeric_lattice(LATTICES["toda"], {"a": 1, "b": 1})


@cache
def peregrine() -> Any:
    return envelope(LATTICES["fput_strain"], k=sp.pi / 2)


@cache
def short_scene() -> Scene:
    return Scene.of(
        name="short", lattice="toda", constants={"a": 1, "b": 1}, eps=0.2, wave="kdv_soliton",
        parameters={"kappa": 2}, slow_times=[0, 0.01], half_width=2, tolerance=0.1,
    )  # fmt: skip


def scene() -> Scene:
    found = load_scene("rogue_cn_k_0.5")
    moving_wave(found).state(SITES, 0.0)  # what it finds is no part of it
    return found


def kept_wave() -> Any:
    return moving_wave(scene()).wave


def user_form() -> ClosedForm:
    """Return a form that is in no catalogue."""
    kink = closed_form("kink")
    return ClosedForm(
        name="mine", title="mine", expression=kink.expression, equation=kink.equation,
        parameters=kink.parameters, background=kink.background, far_fields=kink.far_fields,
        reference=kink.reference,
    )  # fmt: skip


def wave(name: str, **parameters: float) -> Wave:
    form = closed_form(name, parameters)
    result = Wave(form, mkdv_normal_form(2, form.equation.s), **parameters)
    result.at(SITES, -50.0, 0.05)
    return result


def shaken_chain() -> DrivenChain:
    wall = time_function("wall", "sin(t)")
    push = SiteForce(1, time_function("force", "cos(t)"))
    return driven_chain(toda_chain(), 4, left=wall, right="fixed", dashpots=0.1, forces=[push])


def trajectory() -> Any:
    return integrate(Model(1.0, 0.5, 2.0).lattice, START, [0.5], 1e-3)


def scheme(kind: str) -> Any:
    return next(table for table in SCHEMES if type(table).__name__ == kind)


ERROR: dict[str, Any] = {"error": (("time",), [0.5], {})}
X = sp.Symbol("X", real=True)
STATEMENT = partial(read_statement, "u_t + c*u_x", "u = exp(x - c*t)", "c: c>0")

MADE: Mapping[str, tuple[Callable[[], Any], Callable[[Any], Any] | None]] = {
    "Bond": (lambda: LATTICES["toda"].bonds[0], None),
    "Stencil": (lambda: LATTICES["toda"].bonds[0].stretch[0], None),
    "Lattice": (lambda: LATTICES["mass_dimer"], methodcaller("text")),
    "Scaling": (lambda: longwave.Scaling(2, time=5), methodcaller("text")),
    "SlowVariable": (lambda: longwave.Scaling().space[0], methodcaller("phase")),
    "NormalForm": (lambda: mkdv_normal_form(2, -1), attrgetter("values")),
    "Reduction": (mkdv_reduction, methodcaller("json", K2=2, K4=1)),
    "Coefficients": (lambda: mkdv_reduction().coefficients(K2=2, K4=1), None),
    "Condition": (lambda: mkdv_reduction().conditions[0], methodcaller("text")),
    "EvolutionEquation": (lambda: mkdv_reduction().pde, methodcaller("latex")),
    "OrderEquation": (lambda: mkdv_reduction().orders[5], methodcaller("latex")),
    "Dispersion": (dispersion_relation, methodcaller("long_wave")),
    "Envelope": (peregrine, methodcaller("coefficients", K2=1, K3=1, K4=2)),
    "EnvelopeNumbers": (lambda: peregrine().coefficients(K2=1, K3=1, K4=2), None),
    "CarrierFields": (lambda: carrier_fields(peregrine(), K2=1, K3=1, K4=2), None),
    "CarrierTerm": (lambda: carrier_fields(peregrine(), K2=1, K3=1, K4=2).mean[0], None),
    "Check": (lambda: Check("name", "detail", True), methodcaller("text")),
    "ClosedForm": (user_form, attrgetter("residual")),
    "Equation": (lambda: CATALOGUE[-1].equation, None),
    "Parameter": (lambda: closed_form("rogue_cn").parameters[0], None),
    "Bound": (lambda: closed_form("rogue_cn").parameters[0].lower, None),
    "FarFields": (lambda: closed_form("kink").far_fields, None),
    "Reference": (lambda: closed_form("kink").reference, str),
    "Wave": (partial(wave, "rogue_cn", k=0.7), methodcaller("at", SITES, -50.0, 0.05)),
    "NumericWave": (kept_wave, methodcaller("at", SITES, -50.0, 0.05)),
    "WaveValues": (lambda: wave("kink", A=1.2)(SITES, 0.1), None),
    "Model": (lambda: Model(1.0, 0.5, 2.0), methodcaller("sound_speed", 0.3)),
    "State": (lambda: START, None),
    "FieldRing": (lambda: RING, methodcaller("at", SITES)),
    "NumericLattice": (toda_chain, methodcaller("acceleration", RING.f)),
    "DrivenChain": (shaken_chain, attrgetter("shares")),
    "SiteForce": (lambda: shaken_chain().outer_forces[0], attrgetter("value.slope_instructions")),
    "BlowUp": (lambda: BlowUp("grown", 1.0, 3), None),
    "Cost": (lambda: trajectory().cost, None),
    "Trajectory": (trajectory, None),
    "SpectralTrajectory": (lambda: spectral_integrate(toda_chain(), RING, [1.0], 1e-3), None),
    "Composition": (partial(scheme, "Composition"), methodcaller("oscillator", SITES)),
    "Splitting": (partial(scheme, "Splitting"), methodcaller("oscillator", SITES)),
    "RungeKutta": (partial(scheme, "RungeKutta"), methodcaller("oscillator", SITES)),
    "Discretisation": (lambda: Discretisation(0.1, "window", 4000), str),
    "Tolerance": (lambda: Tolerance(1e-3, "stencil"), str),
    "Scene": (scene, methodcaller("json")),
    "Verdict": (lambda: Verdict("kink", "mKdV", "residual", Outcome.CHECKED, "3e-49"), None),
    "ProofVerdict": (lambda: longwave.prove_equal(X, X, [X]), methodcaller("json")),
    "Domain": (lambda: Domain(sp.S.Zero, sp.oo), None),
    "RationalFacts": (lambda: rational_facts(2), None),
    "Statement": (STATEMENT, attrgetter("variables")),
    "StatementVerdict": (lambda: decide_statement(STATEMENT()), methodcaller("json")),
    "MovingWave": (lambda: moving_wave(scene()), methodcaller("state", SITES, 0.0)),
    "RunRecord": (
        lambda: RunRecord(scene(), (9,), [0.0], ERROR, {}),
        methodcaller("values", "error"),
    ),
    "LatticeDerivation": (lambda: derivation(short_scene()), methodcaller("text")),
}
"""Of each public class an instance, and what is asked of it in another process."""

WITHOUT_INSTANCES = {"Scheme", "Side", "CarrierTerms"}
"""Names of public types that are only written in hints, or that others are made from."""

ANSWERS = """
import pickle, sys
found = []
for text, ask in pickle.load(sys.stdin.buffer):
    got = pickle.loads(text)
    found.append((got, ask and ask(got)))
sys.stdout.buffer.write(pickle.dumps(found))
"""


def same(left: Any, right: Any) -> bool:
    """Whether two objects are equal, arrays bit by bit; records with arrays have no ``==``."""
    if isinstance(left, np.ndarray):
        return left.dtype == right.dtype and left.tobytes() == right.tobytes()
    if isinstance(left, tuple | list):
        return len(left) == len(right) and all(map(same, left, right))
    if is_dataclass(left) and any(isinstance(v, np.ndarray | tuple) for v in vars(left).values()):
        names = [entry.name for entry in fields(left) if entry.compare]
        return all(same(getattr(left, name), getattr(right, name)) for name in names)
    return bool(left == right)


def test_every_public_noun_pickles() -> None:
    for name, noun in NOUNS.items():
        for module in (pickle, cloudpickle):
            assert pickle.loads(module.dumps(noun)) == noun, name
        assert copy.deepcopy(noun) == noun, name


def test_every_public_class_has_an_instance_here() -> None:
    classes = {
        noun.__name__
        for noun in NOUNS.values()
        if inspect.isclass(noun) and not issubclass(noun, BaseException)
    }
    assert classes - WITHOUT_INSTANCES - MADE.keys() == set()


@pytest.mark.slow
def test_instances_are_the_same_in_another_process() -> None:
    """The records are equal, and their methods return the same bits."""
    result = {name: make() for name, (make, _) in MADE.items()}
    sent = []
    for name, record in result.items():
        for module in (pickle, cloudpickle):
            text = module.dumps(record)
            assert len(text) < LARGEST, name
            sent.append((name, text, MADE[name][1]))
        assert same(copy.deepcopy(record), record), name
    requested = pickle.dumps([(text, ask) for _, text, ask in sent])
    command = [sys.executable, "-c", ANSWERS]
    answer = subprocess.run(command, input=requested, capture_output=True, cwd=HOUSE, check=False)
    assert answer.returncode == 0, answer.stderr.decode()
    for (name, _, ask), (found, value) in zip(sent, pickle.loads(answer.stdout), strict=True):
        assert type(found) is type(result[name]), name
        assert same(found, result[name]), name
        assert same(value, ask and ask(result[name])), name


def test_unique_objects_stay_unique_after_unpickling() -> None:
    forms = (*CATALOGUE, CATALOGUE, *SCHEMES, *OBSERVABLES.values())
    assert all(pickle.loads(pickle.dumps(noun)) is noun for noun in forms)


def test_a_form_pickles_by_its_name_and_a_family_by_its_order() -> None:
    """Catches: an expression of a thousand terms in each message to a worker."""
    for form in (closed_form("rational_9"), rational(5, [5, 7]), closed_form("rational_3")):
        text = pickle.dumps(form)
        assert len(text) < 100
        assert pickle.loads(text) == form


def test_waves_are_equal_only_if_form_numbers_and_parameters_are() -> None:
    one, other = wave("rogue_cn", k=0.7), wave("rogue_cn", k=0.5)
    assert one == wave("rogue_cn", k=0.7)
    assert hash(one) == hash(wave("rogue_cn", k=0.7))
    assert one != other
    assert one != Wave(closed_form("rogue_cn"), mkdv_normal_form(1, 1), k=0.7)


@pytest.mark.parametrize("error", [e for e in NOUNS.values() if inspect.isclass(e)
                                   and issubclass(e, BaseException)])  # fmt: skip
def test_errors_pickle(error: type[Exception]) -> None:
    found = pickle.loads(pickle.dumps(error("words")))
    assert type(found) is error
    assert str(found) == "words"
