"""Derivation of a scene's wave: from lattice and constants to the reduced equation and the wave.

No equation is looked up: it results from the expansion of the lattice at the scene's constants. A
wave of another equation is refused.
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
from longwave.scenes.starts.damped_soliton import DAMPED_WAVES, DampedSoliton
from longwave.scenes.starts.first_correction import correction_interval
from longwave.scenes.starts.lattice_wave import LatticeWave
from longwave.scenes.starts.long_wave_numbers import long_wave
from longwave.scenes.starts.start_entries import ReducedStart
from longwave.solutions import CATALOGUE, ClosedForm, Wave, closed_form
from longwave.support.user_files import shown

if TYPE_CHECKING:
    from longwave.derive import Envelope
    from longwave.derive.amplitude_law import AmplitudeLaw

FURTHER_ORDERS = 2
"""Number of orders derived beyond the reduced equation, as corrected initial data need."""


@dataclass(frozen=True)
class LatticeDerivation:
    """Derived equation of a scene's lattice: its reduction or envelope, with the normal form.

    For a reduction the constants' values, which may contain eps, are already in ``lattice``. For an
    envelope ``lattice`` keeps the symbols, whose values are ``numbers``. ``normal_form`` is None
    for a computed soliton; with an amplitude ``law`` it is the lossless form, whose soliton follows
    the law.
    """

    lattice: Lattice
    source: Reduction | Envelope
    normal_form: NormalForm | None
    numbers: Mapping[str, Expr]
    law: AmplitudeLaw | None = None

    @property
    def equation(self) -> str:
        """Name of the equation, with the sign of its nonlinearity if waves depend on that."""
        if self.normal_form is None or self.law is not None:
            assert isinstance(self.source, Reduction)
            return self.source.pde.kind
        return self.normal_form.name

    @property
    def slow(self) -> int:
        """Power of eps in the slow time ``T = eps**slow t``."""
        return self.source.scaling.time if isinstance(self.source, Reduction) else 2

    def text(self) -> str:
        """Return the derived equation in one line."""
        if isinstance(self.source, Reduction):
            return f"{self.equation}: {self.source.pde.text()}"
        return f"{self.equation} envelope: i A_T + p A_XX + q |A|^2 A = 0"

    def latex(self) -> str:
        """Return the derived equation in LaTeX."""
        if isinstance(self.source, Reduction):
            return self.source.pde.latex()
        return r"i A_T + p\, A_{XX} + q\, |A|^2 A = 0"


def derivation(scene: Scene) -> LatticeDerivation:
    """Derive equations from the scene's lattice and return the one that the scene's wave solves.

    Raises ValueError for missing or wrong constants, for a lattice without such an equation, and
    for a wave of another equation; the message names the derived equation and its waves.
    """
    form = _form(scene)
    unused: dict[str, Any] = {"eps": 0.1, "name": "", "title": "", "parameters": ()}
    unused |= {"wave": "" if form else scene.wave_name, "order": "leading", "disorder": None}
    unused |= {"half_width": None, "compared": 1, "times": (0.0, 1.0), "slow_times": ()}
    unused |= {"observables": None, "curve_points": 201, "look_points": None}
    unused |= {"losses": scene.losses and scene.losses.as_eps_formulas(scene.eps)}
    candidates = _derivations(scene.with_tolerance(1.0).changed(**unused))
    if form is None:
        return candidates[0]
    for candidate in candidates:
        if _fits(form, candidate):
            return candidate
    without_law = [each for each in candidates if each.law is None] or candidates
    names = ", ".join(each.equation for each in without_law)
    fitting = [f.name for f in CATALOGUE if any(_fits(f, each) for each in candidates)]
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
    """Return all equations that are derived from a scene's lattice, whatever its wave; cached."""
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
    """Return the closed form of a scene's wave; None if the wave is not a closed form."""
    scene.check_compared()
    if scene.named_start:
        return None
    try:
        return closed_form(scene.wave_name, dict(scene.parameters))
    except ValueError as error:
        raise ValueError(f"wave: {error}") from None


def equation_of_form(form: ClosedForm) -> str:
    """Return the name of the equation that a closed form solves."""
    return equation_name(form.equation.normal, form.equation.s, form.equation.r)


def _fits(form: ClosedForm, derived: LatticeDerivation) -> bool:
    """Return whether the form solves the equation and can follow its amplitude law, if any."""
    equation, normal = form.equation, derived.normal_form
    if normal is None or (derived.law is not None and form.name not in DAMPED_WAVES):
        return False
    signs = ((equation.s, normal.s), (equation.r, normal.r))
    return equation.normal == normal.equation and all(
        sign == required or not isinstance(sign, int) for sign, required in signs
    )


def _reductions(scene: Scene, lattice: Lattice, mean: Expr) -> Iterator[LatticeDerivation]:
    """Yield the reductions that have a normal form or an amplitude law; ValueError if none has."""
    if mean and lattice.is_displacement:
        raise ValueError(
            f"background must be 0 on a lattice of displacements, got {shown(str(mean))} (their "
            "mean has no effect; declare the lattice in its strain)"
        )
    refusal, has_any = "", False
    ansatz = scene.amplitude, scene.time
    for reduction in find_scaling(lattice, mean, *ansatz, further=FURTHER_ORDERS):
        if scene.named_start:
            yield LatticeDerivation(lattice, reduction, None, {})
            has_any = True
            continue
        try:
            yield LatticeDerivation(lattice, reduction, reduction.normal_form(), {})
            has_any = True
        except ValueError as error:
            refusal = refusal or str(error)
        law = reduction.amplitude_law() if lattice.has_losses else None
        if law is not None:
            yield LatticeDerivation(lattice, reduction, reduction.lossless_form(), {}, law)
            has_any = True
    if not has_any:
        raise ValueError(f"no long wave of {lattice.name} has a normal form: {refusal}")


def _constant_values(scene: Scene, lattice: Lattice) -> dict[str, Expr]:
    """Return the exact values of the scene's constants; ValueError for a missing constant."""
    values = {name: constant_value(name, value) for name, value in scene.constants}
    for name, value in values.items() if scene.is_envelope else ():
        if value.free_symbols:
            raise ValueError(
                f"{name} must not depend on eps with an envelope, got {shown(str(value))} (give a "
                "number; only the wave is small)"
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
    """Return the envelope equation of a scene's lattice and branch, and the constants' values.

    The equation is derived once for all wavenumbers, and separately at k = pi, where it is shorter.
    Raises ValueError for missing or wrong constants and for a lattice without such an equation.
    """
    unused = {"eps": 0.1, "tolerance": 1.0, "name": "", "title": ""}
    at_pi = exact_value("k", scene.carrier) == pi
    return _scene_envelope(
        scene.changed(**unused, parameters={"amplitude": 1}, carrier="pi" if at_pi else 1)
    )


@lru_cache(maxsize=8)
def _scene_envelope(scene: Scene) -> tuple[Envelope, Mapping[str, Expr]]:
    lattice = scene.symbolic_lattice
    values = _constant_values(scene, lattice)
    lattice.with_values(values)  # refuses unknown constants
    return _envelope(scene, lattice, values, pi if scene.carrier == "pi" else None)


def _values(
    pairs: Iterable[tuple[str, Value]], names: Mapping[str, Expr] | None = None
) -> dict[str, Expr]:
    """Return exact values by name from pairs; a formula may contain ``names`` as symbols."""
    return {name: exact_value(name, value, names) for name, value in pairs}


def exact_parameters(parameters: Pairs) -> dict[str, float | Expr]:
    """Return a wave's parameters by name, with formulas as exact expressions.

    K in a formula is the quarter period of the modulus, the parameter k.

    >>> exact_parameters((("k", 0.5), ("alpha", "3*K/4")))["alpha"]
    3*elliptic_k(1/4)/4
    """
    modulus = _values(pair for pair in parameters if pair[0] == "k")
    names = {"K": elliptic_k(modulus["k"] ** 2)} if modulus else {}
    texts = _values((pair for pair in parameters if isinstance(pair[1], str)), names)
    return {name: texts.get(name, value) for name, value in parameters}


def wave_of(scene: Scene) -> Wave | ComputedSoliton | DampedSoliton:
    """Return the scene's wave with numeric parameters; ValueError for inadmissible ones."""
    derived = derivation(scene)
    if isinstance(start := scene.start, ReducedStart):
        return start.solve(scene, cast(Reduction, derived.source), _values(scene.parameters))
    values = exact_parameters(scene.parameters)
    form = closed_form(scene.wave_name, values)
    wave = Wave(form, cast(NormalForm, derived.normal_form), **values)
    return wave if derived.law is None else DampedSoliton(wave, derived.law)


def lattice_wave(scene: Scene) -> LatticeWave:
    """Return the wave on the scene's lattice, with initial data, theory and compared quantities.

    Raises the ValueErrors of `derivation` and `wave_of`, and one for an inadmissible disorder.
    """
    wave = _ordered_wave(scene)
    if scene.losses:
        wave.losses = loss_rates(derivation(scene).lattice, {"eps": exact("eps", scene.eps)})
        if wave.losses:
            wave.lattice = wave.losses.on(wave.lattice, wave.lattice.reach + 2)
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
    derived, wave = derivation(scene), wave_of(scene)
    interval = correction_interval(scene, wave)
    source, lattice = derived.source, derived.lattice
    if isinstance(source, Reduction):
        return long_wave(source, {}, wave, scene.eps, scene.order, lattice, interval)
    from longwave.scenes.starts.envelope_data import EnvelopeData, EnvelopeWave

    A = cast(EnvelopeWave, wave)
    far = mean_square_far(cast(Wave, wave)) if scene.order == "leading" else 0.0
    return EnvelopeData(
        source, derived.numbers, A, scene.eps, scene.order, mean_square=far, interval=interval
    )


FAR_WIDTHS, MEAN_SAMPLES = 200.0, 4096
"""Distance of an envelope's far field from its middle, in widths, and number of points on either
side over which its mean is taken."""


def mean_square_far(wave: Wave) -> float:
    """Return the mean of |A|^2 in the far field, which sets the uniform strain of leading data."""
    reach = FAR_WIDTHS / float(wave.normal_form.a)
    right = np.linspace(reach, 2.0 * reach, MEAN_SAMPLES)
    X = np.concatenate([-right, right])
    return float(np.mean(np.abs(wave(X, 0.0).Y) ** 2))
