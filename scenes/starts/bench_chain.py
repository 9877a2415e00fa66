"""Chain of a bench on its lattice: driven chain, initial state and recorded variables."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from longwave.lattice.driving import DrivenChain, End, driven_chain
from longwave.lattice.energy_balance import Flow
from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.state import State
from longwave.lattice.time_integral import Integral
from longwave.scenes.description.bench import FORCE_TABLES, Bench, Cells, Drive, Impact
from longwave.scenes.description.losses import LossRates
from longwave.scenes.description.time_functions import time_function
from longwave.support.known_names import one_of
from longwave.support.real_arrays import Array
from longwave.support.user_files import shown


class Moment(NamedTuple):
    """Chain at one time: fields and velocities; if integrated, energy flows and their rates."""

    chain: DrivenChain
    f: Array
    v: Array
    total: Flow = Flow()
    rate: Flow = Flow()


Reader = Callable[[Moment], ArrayLike]


@dataclass(frozen=True)
class BenchVariable:
    """Variable of a run: dimensions besides time, and the function of a `Moment` that reads it."""

    name: str
    dimensions: tuple[str, ...]
    units: str
    long_name: str
    read: Reader


_UNIT = "lattice units"
_STRETCH, _FORCE = "stretch of the bond to the next cell", "force in the bond to the next cell"

READINGS = {
    variable.name: variable
    for variable in (
        BenchVariable("displacement", ("field",), _UNIT, "displacement", lambda at: at.f),
        BenchVariable("velocity", ("field",), "per lattice time", "velocity", lambda at: at.v),
        BenchVariable("strain", ("bond",), _UNIT, _STRETCH, lambda at: at.chain.stretches(at.f)),
        BenchVariable("force", ("bond",), _UNIT, _FORCE, lambda at: at.chain.forces(at.f)),
    )
}
"""Variable for each quantity that sensors read, by name, with all cells along its last axis."""


def chain_on_bench(
    bench: Bench,
    lattice: NumericLattice,
    span: tuple[float, float],
    losses: LossRates | None = None,
) -> DrivenChain:
    """Return the chain with the bench's ends, forces and defects for times in ``span``.

    Raises ValueError for an unknown field.
    """
    for given in bench.masses.values():
        for name in given if isinstance(given, Mapping) else ():
            _field(lattice, name, "[defects]")
    left, right = (
        _end(side, given, *span) for side, given in zip(("left", "right"), bench.ends, strict=True)
    )
    forces = []
    for push in bench.forces:
        drive = time_function(f"value in [[{push.kind}]]", push.value)
        index = _field(lattice, push.field, f"[[{push.kind}]]")
        forces.append(FORCE_TABLES[push.kind](push.site, drive, index))
    mass_factors = {
        cell: [given.get(name, 1.0) for name in lattice.fields]
        if isinstance(given, Mapping)
        else given
        for cell, given in bench.masses.items()
    }
    return driven_chain(
        lattice,
        bench.sites,
        left=left,
        right=right,
        losses=losses.sites if losses else 0.0,
        dashpots=losses.bonds if losses else 0.0,
        forces=forces,
        mass_factors=mass_factors,
        spring_factors=bench.springs,
    )


def _end(side: str, given: str | Mapping[str, Drive], begin: float, end: float) -> End:
    if isinstance(given, str):
        return "free" if given == "free" else "fixed"
    [(kind, value)] = given.items()
    drive = time_function(f"{kind} of {side}", value)
    return drive if kind == "displacement" else Integral.of(drive, begin, end)


def _field(lattice: NumericLattice, name: str, where: str) -> int:
    """Return the index of a field, 0 for an empty name; ``where`` locates the name in errors."""
    if name and name not in lattice.fields:
        raise ValueError(
            f"field in {where} must be one of {lattice.name}, got {shown(name)} "
            f"({one_of(name, lattice.fields)})"
        )
    return lattice.fields.index(name) if name else 0


def start_on_bench(bench: Bench, chain: DrivenChain, t: float) -> State:
    """Return the state at time ``t`` from which the bench starts."""
    f, v = np.zeros((2, len(chain.fields), bench.sites))
    for part in bench.start:
        if isinstance(part, Impact):
            v[_field(chain, part.field, "impact"), part.site] += part.velocity
        elif isinstance(part, Cells):
            for name, values in part.values.items():
                rows = f if name in chain.fields else v
                row = _field(chain, name if rows is f else name.removeprefix("d"), "state")
                rows[row, list(part.sites)] += values
        else:
            f += part.amplitude * _mode(bench, part.number)
    return State(t, f, v)


def _mode(bench: Bench, number: int) -> Array:
    """Return mode ``number`` of a chain between fixed walls, as a sine over the cells."""
    if number > bench.sites:
        raise ValueError(
            f"modes must be 1 to {bench.sites}, got {number} (a chain has as many as cells)"
        )
    n = np.arange(1, bench.sites + 1)
    return np.asarray(np.sin(np.pi * number * n / (bench.sites + 1)))


def energy_cuts(bench: Bench, chain: DrivenChain) -> Sequence[int] | None:
    """Return the cell left of each cut whose energy flow is integrated; None without cuts."""
    return bench.flux if bench.flux or has_balance(bench, chain) else None


def has_balance(bench: Bench, chain: DrivenChain) -> bool:
    """Return whether work and heat are recorded with the energy; in a heat bath they are not."""
    return bench.energy and bench.noise is None and chain.exchanges_energy


def bench_variables(bench: Bench, chain: DrivenChain) -> Iterator[BenchVariable]:
    """Yield the recorded variables, in the order in which a reading stores their values."""
    for name in bench.sensed if bench.sensors else ():
        yield _in_cells(f"sensor_{name}", "sensor", name, bench.sensors)
    if bench.energy:
        name = "energy of chain and bonds"
        yield BenchVariable("energy", (), _UNIT, name, lambda at: at.chain.energy(at.f, at.v))
    if has_balance(bench, chain):
        since = "since the start"
        yield BenchVariable("work", (), _UNIT, f"work done {since}", lambda at: at.total.work.sum())
        name = f"energy lost {since}"
        yield BenchVariable("heat", (), _UNIT, name, lambda at: at.total.heat.sum())
        if len(chain.drivers) > 1:
            name = f"work done by a wall or force {since}"
            yield BenchVariable("driver_work", ("driver",), _UNIT, name, lambda at: at.total.work)
    if bench.flux:
        name = "energy sent to the right"
        yield BenchVariable("transmitted", ("cut",), _UNIT, name, lambda at: at.total.through)
        name, unit = "power to the right", "lattice units per lattice time"
        yield BenchVariable("flux", ("cut",), unit, name, lambda at: at.rate.through)
    if bench.modes:
        name, read = "energy of the mode of a linear chain", _mode_reader(bench, chain)
        yield BenchVariable("mode_energy", ("mode",), _UNIT, name, read)
    for name in ("displacement", "velocity") if bench.state else ():
        yield _in_cells(name, "cell", name, range(bench.sites))


def _in_cells(name: str, dimension: str, what: str, cells: Sequence[int]) -> BenchVariable:
    """Return the variable ``name`` that reads the quantity ``what`` of `READINGS` in some cells."""
    whole, indices = READINGS[what], list(cells)
    return replace(
        whole,
        name=name,
        dimensions=(dimension, *whole.dimensions),
        read=lambda now: np.asarray(whole.read(now))[:, indices].T,
    )


def _mode_reader(bench: Bench, chain: DrivenChain) -> Reader:
    """Return a function that reads the energies of the bench's modes in the linearised chain."""
    is_even = bench.ends == ("fixed", "fixed") and not (bench.masses or bench.springs)
    if len(chain.fields) > 1 or not is_even:
        raise ValueError(
            "mode_energies must be of a chain of one field between fixed walls without defects, "
            f"got {chain.name} with {shown(bench.ends)} (leave them out)"
        )
    shapes = np.array([_mode(bench, number) for number in bench.modes])
    squares = chain.squared_frequencies(
        np.pi * np.array(bench.modes)[:, None] / (bench.sites + 1), chain.rest_slopes()
    )[:, 0]

    def read(at: Moment) -> Array:
        a, rate = (shapes @ part[0, : bench.sites] for part in (at.f, at.v))
        return np.asarray(chain.masses[0] * (rate**2 + squares * a**2) / (bench.sites + 1))

    return read
