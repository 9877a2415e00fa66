"""From a lattice's name to its wave: numbers in, its equation derived, the wave that must solve it.

Nothing is looked up: the equation of a scene is what the expansion of its lattice leaves at its
constants, and a wave of another equation is refused.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from sympy import Expr, elliptic_k, pi

from longwave.derive import Lattice, NormalForm, Reduction, find_scaling
from longwave.derive.algebra.exact_numbers import exact
from longwave.derive.algebra.formula_expression import exact_value
from longwave.derive.normal_form import equation_name
from longwave.derive.symbols import constant_value
from longwave.scenes.description.losses import loss_rates
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_checks import Pairs, Value
from longwave.scenes.starts.computed_soliton import ComputedSoliton
from longwave.scenes.starts.damped_soliton import LAWFUL, DampedSoliton
from longwave.scenes.starts.first_correction import correction_interval
from longwave.scenes.starts.lattice_wave import LatticeWave
from longwave.scenes.starts.long_wave_numbers import long_wave
from longwave.scenes.starts.start_entries import ReducedStart
from longwave.solutions import CATALOGUE, ClosedForm, Wave, closed_form
from longwave.support.user_files import shown

if TYPE_CHECKING:
    from longwave.derive import Envelope
    from longwave.derive.amplitude_law import AmplitudeLaw

FURTHER = 2
"""Orders behind the reduced equation that data of the next order take."""


@dataclass(frozen=True)
class LatticeDerivation:
    """What a scene's lattice is found to be: its reduction or envelope, and the map of that.

    Before a reduction the numbers are put into ``lattice``, with eps where they are small; an
    envelope has symbols, whose values are ``numbers``. A computed soliton asks for no normal form.
    With a ``law`` the normal form is that without losses, whose soliton follows the law.
    """

    lattice: Lattice
    source: Reduction | Envelope
    normal_form: NormalForm | None
    numbers: Mapping[str, Expr]
    law: AmplitudeLaw | None = None

    @property
    def equation(self) -> str:
        """The equation's name, with its sign where waves depend on it."""
        if self.normal_form is None or self.law is not None:
            assert isinstance(self.source, Reduction)
            return self.source.pde.kind
        return self.normal_form.name

    @property
    def slow(self) -> int:
        """``T = eps**slow t``."""
        return self.source.scaling.time if isinstance(self.source, Reduction) else 2

    def text(self) -> str:
        """The equation as it was derived, in one line."""
        if isinstance(self.source, Reduction):
            return f"{self.equation}: {self.source.pde.text()}"
        return f"{self.equation} envelope: i A_T + p A_XX + q |A|^2 A = 0"

    def latex(self) -> str:
        """The equation in LaTeX."""
        if isinstance(self.source, Reduction):
            return self.source.pde.latex()
        return r"i A_T + p\, A_{XX} + q\, |A|^2 A = 0"


def derivation(scene: Scene) -> LatticeDerivation:
    """The equation of the scene's lattice that its wave solves, and how it was derived.

    Raises ValueError for constants that are missing or wrong, where there is no equation, and for
    a wave of another one: the line says which is derived and which waves it has.
    """
    form = _form(scene)
    same = {"eps": 0.1, "name": "", "title": "", "parameters": ()}
    same["wave"] = "" if form else scene.wave_name
    ran: dict[str, Any] = {"order": "leading", "disorder": None, "half_width": None, "compared": 1}
    ran |= {"observables": None, "curve_points": 201, "look_points": None}
    ran |= {"losses": scene.losses and scene.losses.as_eps_formulas(scene.eps)}
    found = _derivations(
        scene.with_tolerance(1.0).changed(**same, **ran, times=(0.0, 1.0), slow_times=())
    )
    if form is None:
        return found[0]
    for one in found:
        if _fits(form, one):
            return one
    told = [one for one in found if one.law is None] or found
    names = ", ".join(one.equation for one in told)
    fitting = [f.name for f in CATALOGUE if any(_fits(f, one) for one in found)]
    remedy = f"one of {', '.join(fitting)}" if fitting else "none of the catalogue does"
    if form.equation.normal == "NLS" and not scene.is_envelope:
        remedy += "; an envelope needs the carrier's k"
    elif not scene.is_envelope:
        remedy += '; other constants, small ones such as "eps/2", or a background give another'
    raise ValueError(
        f"wave must solve the {names} equation, which is derived from {scene.lattice} here, got "
        f"{form.name} of the {equation_of_form(form)} equation ({remedy})"
    )


@lru_cache(maxsize=8)
def _derivations(scene: Scene) -> tuple[LatticeDerivation, ...]:
    """All that are found of a scene's lattice, whatever its wave."""
    symbolic = scene.symbolic_lattice
    values = _constant_values(scene, symbolic)
    numeric = symbolic.with_values(values)
    if not scene.is_envelope:
        from longwave.derive.balances import uniform_mean

        mean = uniform_mean(symbolic, scene.background, values)
        return tuple(_reductions(scene, numeric, mean))
    source, numbers = _envelope(scene, symbolic, values, exact_value("k", scene.carrier))
    return (LatticeDerivation(source.lattice, source, source.normal_form(**numbers), numbers),)


def _form(scene: Scene) -> ClosedForm | None:
    """The closed form of a scene's wave; None if that is computed."""
    scene.check_compared()
    if scene.named_start:
        return None
    try:
        return closed_form(scene.wave_name, dict(scene.parameters))
    except ValueError as error:
        raise ValueError(f"wave: {error}") from None


def equation_of_form(form: ClosedForm) -> str:
    """The name of the equation that a closed form solves."""
    return equation_name(form.equation.normal, form.equation.s, form.equation.r)


def _fits(form: ClosedForm, found: LatticeDerivation) -> bool:
    """Whether the closed form solves the normal form's equation, and follows its law if any."""
    equation, normal = form.equation, found.normal_form
    if normal is None or (found.law is not None and form.name not in LAWFUL):
        return False
    signs = ((equation.s, normal.s), (equation.r, normal.r))
    return equation.normal == normal.equation and all(
        own == there or not isinstance(own, int) for own, there in signs
    )


def _reductions(scene: Scene, lattice: Lattice, mean: Expr) -> Iterator[LatticeDerivation]:
    """Long waves, those first that ask for nothing; ValueError if there are none."""
    if mean and lattice.is_displacement:
        raise ValueError(
            f"background must be 0 on a lattice of displacements, got {shown(str(mean))} (their "
            "mean does nothing; declare the lattice in its strain)"
        )
    refused, found = "", False
    for reduction in find_scaling(lattice, mean, scene.amplitude, scene.time, further=FURTHER):
        if scene.named_start:
            yield LatticeDerivation(lattice, reduction, None, {})
            found = True
            continue
        try:
            yield LatticeDerivation(lattice, reduction, reduction.normal_form(), {})
            found = True
        except ValueError as error:
            refused = refused or str(error)
        law = reduction.amplitude_law() if lattice.has_losses else None
        if law is not None:
            yield LatticeDerivation(lattice, reduction, reduction.lossless_form(), {}, law)
            found = True
    if not found:
        raise ValueError(f"no long wave of {lattice.name} has a normal form: {refused}")


def _constant_values(scene: Scene, lattice: Lattice) -> dict[str, Expr]:
    """The scene's constants exactly; ValueError for one of the lattice's that is missing."""
    values = {name: constant_value(name, value) for name, value in scene.constants}
    for name, value in values.items() if scene.is_envelope else ():
        if value.free_symbols:
            raise ValueError(
                f"{name} must not depend on eps with an envelope, got {shown(str(value))} (give a "
                "number: the wave alone is small)"
            )
    missing = [str(s) for s in lattice.constants if str(s) not in values]
    if missing:
        raise ValueError(
            f"constant {missing[0]} of {lattice.name} must be given, got none (it takes "
            f"{', '.join(map(str, lattice.constants))})"
        )
    return values


def _envelope(
    scene: Scene, lattice: Lattice, numbers: Mapping[str, Expr], k: Expr | None
) -> tuple[Envelope, Mapping[str, Expr]]:
    from longwave.derive import envelope

    if not lattice.is_polynomial:
        in_masses = {str(s) for mass in lattice.masses for s in mass.free_symbols}
        outer = {name: value for name, value in numbers.items() if name not in in_masses}
        if in_masses:  # a symbol must be left for the dispersion relation to be solved for
            lattice = lattice.with_values(outer)
            numbers = {name: value for name, value in numbers.items() if name in in_masses}
    return envelope(lattice, k=k, branch=scene.branch, **numbers), numbers


def scene_envelope(scene: Scene) -> tuple[Envelope, Mapping[str, Expr]]:
    """The envelope equation of a scene's lattice and branch at any k, and the lattice's numbers.

    It is derived once for all wavenumbers; that of k = pi, where it is shorter, by itself. Raises
    ValueError as `derivation` does.
    """
    same = {"eps": 0.1, "tolerance": 1.0, "name": "", "title": "", "parameters": {"amplitude": 1}}
    at_pi = exact_value("k", scene.carrier) == pi
    return _scene_envelope(scene.changed(**same, carrier="pi" if at_pi else 1))


@lru_cache(maxsize=8)
def _scene_envelope(scene: Scene) -> tuple[Envelope, Mapping[str, Expr]]:
    lattice = scene.symbolic_lattice
    values = _constant_values(scene, lattice)
    lattice.with_values(values)  # refuses what is no constant
    return _envelope(scene, lattice, values, pi if scene.carrier == "pi" else None)


def _values(
    pairs: Iterable[tuple[str, Value]], names: Mapping[str, Expr] | None = None
) -> dict[str, Expr]:
    """Names and exact values."""
    return {name: exact_value(name, value, names) for name, value in pairs}


def exact_parameters(parameters: Pairs) -> dict[str, float | Expr]:
    """A wave's parameters, texts exactly: in them K is the quarter period of the modulus k.

    >>> exact_parameters((("k", 0.5), ("alpha", "3*K/4")))["alpha"]
    3*elliptic_k(1/4)/4
    """
    modulus = _values(pair for pair in parameters if pair[0] == "k")
    names = {"K": elliptic_k(modulus["k"] ** 2)} if modulus else {}
    texts = _values((pair for pair in parameters if isinstance(pair[1], str)), names)
    return {name: texts.get(name, value) for name, value in parameters}


def wave_of(scene: Scene) -> Wave | ComputedSoliton | DampedSoliton:
    """The scene's wave with numbers in; ValueError for parameters that it does not admit."""
    found = derivation(scene)
    if isinstance(start := scene.start, ReducedStart):
        return start.solve(scene, cast(Reduction, found.source), _values(scene.parameters))
    values = exact_parameters(scene.parameters)
    form = closed_form(scene.wave_name, values)
    wave = Wave(form, cast(NormalForm, found.normal_form), **values)
    return wave if found.law is None else DampedSoliton(wave, found.law)


def lattice_wave(scene: Scene) -> LatticeWave:
    """The wave on the scene's lattice: data, theory and what is compared.

    Raises ValueError as `derivation` and `wave_of` do, and for a disorder that the lattice cannot
    have.
    """
    wave = _ordered_wave(scene)
    if scene.losses:
        wave.losses = loss_rates(derivation(scene).lattice, {"eps": exact("eps", scene.eps)})
        wave.lattice = (
            wave.losses.on(wave.lattice, wave.lattice.reach + 2) if wave.losses else wave.lattice
        )
    if not scene.disorder:
        return wave
    from longwave.scenes.starts.disordered_wave import WaveDisorder

    values = _values(scene.constants, {"eps": exact("eps", scene.eps)})
    lattice = scene.symbolic_lattice
    far = None if scene.is_envelope else wave_of(scene).constant_background
    uniform = np.zeros(len(wave.lattice.fields)) if far is None else wave.uniform()
    wave.disorder = WaveDisorder(wave.lattice, scene.disorder, lattice, values, uniform, far)
    wave.lattice = wave.disorder.on(wave.lattice, np.zeros(0))
    return wave


def _ordered_wave(scene: Scene) -> LatticeWave:
    found, wave = derivation(scene), wave_of(scene)
    interval = correction_interval(scene, wave)
    if isinstance(found.source, Reduction):
        return long_wave(found.source, {}, wave, scene.eps, scene.order, found.lattice, interval)
    from longwave.scenes.starts.envelope_data import EnvelopeData, EnvelopeWave

    A = cast(EnvelopeWave, wave)
    far = mean_square_far(cast(Wave, wave)) if scene.order == "leading" else 0.0
    return EnvelopeData(
        found.source,
        found.numbers,
        A,
        scene.eps,
        scene.order,
        mean_square=far,
        interval=interval,
    )


FAR, SAMPLES = 200.0, 4096
"""Where an envelope is far from its middle, in units of its width, and the points of a mean."""


def mean_square_far(wave: Wave) -> float:
    """The mean of |A|^2 far away, which a uniform strain in the data belongs to."""
    reach = FAR / float(wave.normal_form.a)
    X = np.concatenate([sign * np.linspace(reach, 2.0 * reach, SAMPLES) for sign in (-1.0, 1.0)])
    return float(np.mean(np.abs(wave(X, 0.0).Y) ** 2))
