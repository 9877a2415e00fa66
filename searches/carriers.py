"""Random carriers of lattices with two fields, judged by an eigenproblem in NumPy.

    python -m searches.carriers --count 300 --seed 0

Stiffnesses, masses and wavenumbers are small numbers, so that fields at rest, equal masses, closed
gaps and resonances are frequent.  Forces are odd: the judge has omega from eigenvalues of the
dynamical matrix, v and p from differences of these in k, and q from the energy of the cubic terms,
``q = -sum 3 g |x|^4 / (2 omega sum m |f|^2)`` over bonds, with the eigenvector's first entry that
is not 0 as the unit.  A refusal must be one that the judge finds a reason for.  Each case is asked
twice: at its wavenumber, and by the formulas of all wavenumbers.  Exit status 1 for a difference.
"""

from __future__ import annotations

import argparse
import re
import sys
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from sympy import Integer, Symbol, pi

from longwave.derive.carrier_envelope import envelope
from longwave.derive.lattice import Lattice, on_site, spring
from longwave.derive.symbols import x

Complex = NDArray[np.complex128]

WAVENUMBERS = (0, pi / 2, pi, 2 * pi / 3, 1, pi / 3)
LINKS = {"uv": (0, 0, 1), "vu": (1, 1, 0), "uu": (1, 0, 0), "vv": (1, 1, 1), "uv1": (1, 0, 1)}
"""Springs by name: cells ahead, and the fields of both ends."""

STEP = 2e-3
"""Of the wavenumber, in differences of omega."""

NEAR = 1e-7
"""Frequencies so close, beside omega, are one."""

AGREE = 1e-6
"""Relative difference from the judge that is allowed."""


@dataclass(frozen=True)
class CarrierCase:
    """Masses, springs (name, stiffness, cubic part), ties to sites, a wavenumber and a branch."""

    masses: tuple[int, int]
    springs: tuple[tuple[str, int, int], ...]
    ties: tuple[int, int]
    k: object
    branch: int

    def matrix(self, k: float) -> Complex:
        """Return the dynamical matrix, whose eigenvalues are omega^2."""
        found = np.diag(np.array(self.ties, complex))
        for name, stiffness, _ in self.springs:
            row = self.stretch(name, k)
            found += stiffness * np.outer(row.conj(), row)
        return found / np.sqrt(np.outer(self.masses, self.masses))

    def stretch(self, name: str, k: float) -> Complex:
        """Return the stretch of a spring by each field's wave."""
        offset, start, end = LINKS[name]
        row = np.zeros(2, complex)
        row[end] += np.exp(1j * k * offset)
        row[start] -= 1.0
        return row

    @property
    def lattice(self) -> Lattice:
        """The lattice with a symbol for each number."""
        bonds = []
        for i, (name, _, cubic) in enumerate(self.springs):
            offset, start, end = LINKS[name]
            force = Symbol(f"K{i}", positive=True) * x
            force += Symbol(f"g{i}", real=True) * x**3 if cubic else 0
            bonds.append(spring(force, ((0,), start), ((offset,), end)))
        for i, tie in enumerate(self.ties):
            if tie:
                bonds.append(on_site(Symbol(f"w{i}", positive=True) * x, i))
        masses = tuple(Symbol(f"m{i}", positive=True) for i in range(2))
        return Lattice("random", "random", ("u", "v"), masses, tuple(bonds))

    @property
    def constants(self) -> dict[str, Integer]:
        """The numbers of the lattice's symbols."""
        found = {f"m{i}": mass for i, mass in enumerate(self.masses)}
        for i, (_, stiffness, cubic) in enumerate(self.springs):
            found |= {f"K{i}": stiffness} | ({f"g{i}": cubic} if cubic else {})
        found |= {f"w{i}": tie for i, tie in enumerate(self.ties) if tie}
        return {name: Integer(value) for name, value in found.items()}


def random_case(seed: int) -> CarrierCase:
    """Return the case of that number."""
    random = np.random.default_rng(seed)
    masses = tuple(int(m) for m in random.choice([1, 1, 2, 3, 4], 2))
    names = ["uv", "vu", *(n for n in ("uu", "vv", "uv1") if random.random() < 0.25)]
    springs = tuple(
        (name, int(random.choice([1, 1, 2, 5])), int(random.choice([0, 1, -1, 3])))
        for name in names
    )
    ties = tuple(int(random.choice([0, 0, 1, 2])) for _ in range(2))
    ties = ties if random.random() < 0.5 else (0, 0)
    k = WAVENUMBERS[int(random.integers(len(WAVENUMBERS)))]
    return CarrierCase(masses, springs, ties, k, int(random.integers(2)))  # type: ignore[arg-type]


def omegas(case: CarrierCase, k: float) -> NDArray[np.float64]:
    """Return both frequencies, the lower one first."""
    return np.sqrt(np.maximum(np.linalg.eigvalsh(case.matrix(k)), 0.0))


def expected(case: CarrierCase) -> dict[str, float] | str:
    """Return omega, v, p and q, or the reason why there is no NLS equation."""
    k = float(case.k)  # type: ignore[arg-type]
    squared, vectors = np.linalg.eigh(case.matrix(k))
    own = np.sqrt(max(squared[case.branch], 0.0))
    if own < 1e-6:
        return "omega > 0"
    if abs(squared[1] - squared[0]) < NEAR * own**2:
        return "(one|same) frequency"
    if min(abs(omegas(case, 2 * k) - 2 * own)) < NEAR * own:
        return "resonance"
    rows = np.array([omegas(case, k + i * STEP)[case.branch] for i in range(-3, 4)])
    v = rows @ np.array([-1, 9, -45, 0, 45, -9, 1]) / (60 * STEP)
    p = rows @ np.array([2, -27, 270, -490, 270, -27, 2]) / (360 * STEP**2)
    fields = vectors[:, case.branch] / np.sqrt(np.array(case.masses))
    fields /= next(value for value in fields if abs(value) > 1e-9 * max(abs(fields)))
    energy = sum(3 * g * abs(case.stretch(name, k) @ fields) ** 4 for name, _, g in case.springs)
    inertia = np.array(case.masses) @ abs(fields) ** 2
    if abs(p) < 1e-7 * own:
        return "dispersion p"
    if not any(case.ties) and abs(abs(v) - _sound(case)) < NEAR * own:
        return "sound"
    return {"omega": own, "v": v, "p": p, "q": -energy / (2 * own * inertia)}


def _sound(case: CarrierCase) -> float:
    """Return the speed of long waves."""
    return float(omegas(case, 1e-4)[0] / 1e-4)


def judged(case: CarrierCase) -> str:
    """Return the differences to the judge in words; "" if all agrees."""
    reference = expected(case)
    lattice, constants = case.lattice, case.constants
    for k in (case.k, None):
        try:
            at = envelope(lattice, k, case.branch, **constants)
            found = at.coefficients(case.k, case.branch, **constants)
        except ValueError as error:
            if not (isinstance(reference, str) and re.search(reference, str(error))):
                return f"{reference} got {error}"
            continue
        if isinstance(reference, str):
            return f"{reference} got {found}"
        unit = max(abs(reference["p"]), reference["omega"], abs(reference["q"]))
        for name, value in reference.items():
            if abs(getattr(found, name) - value) > AGREE * unit:
                return f"{name} = {value} got {getattr(found, name)}, k = {k}"
    return ""


def main() -> int:
    """Search, print what differs, count."""
    parser = argparse.ArgumentParser(description="Carriers of lattices with two fields.")
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    wrong = 0
    for seed in range(given.seed, given.seed + given.count):
        case = random_case(seed)
        if words := judged(case):
            wrong += 1
            print(f"{seed}: {words}: {case}", flush=True)
    print(f"{wrong} of {given.count} differ")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
