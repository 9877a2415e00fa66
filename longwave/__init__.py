"""longwave: derive the long-wave limit of a lattice, check its solutions, test them on the lattice.

The face of the project. The public nouns of the rooms `derive`, `solutions` and `verify` are
here under one name; each is imported when it is first asked for, so `import longwave` is quick.

>>> import longwave
>>> longwave.mkdv_normal_form(4, 1).s
1
"""

from importlib import import_module
from typing import Any

from longwave.rooms import claim_rooms

claim_rooms()

__version__: str

_ROOMS: dict[str, tuple[str, ...]] = {
    "derive": (
        "LATTICES",
        "Lattice",
        "NormalForm",
        "Reduction",
        "Scaling",
        "mkdv_normal_form",
        "reduce",
    ),
    "solutions": ("CATALOGUE", "ClosedForm", "Equation", "Parameter", "Wave", "closed_form"),
    "verify.proof": ("check_certificate", "prove_equal"),
    "verify.proof.statement_verdict": ("prove",),
    "verify.verdict": ("Verdict",),
    "longwave.plotting": ("plot",),
    "verify.comparison": (
        "Discretisation",
        "Scene",
        "Tolerance",
        "load_scene",
        "relative_sup_error",
        "run",
        "shipped_scenes",
    ),
}
_ROOM_OF = {noun: room for room, nouns in _ROOMS.items() for noun in nouns}

__all__ = ["__version__", *sorted(_ROOM_OF)]


def __getattr__(name: str) -> Any:
    """Import the noun from its room, or look the version up."""
    if name == "__version__":
        from importlib.metadata import version

        return version("longwave")
    if name not in _ROOM_OF:
        raise AttributeError(f"longwave has no noun {name!r}; it has {', '.join(sorted(_ROOM_OF))}")
    return getattr(import_module(_ROOM_OF[name]), name)


def __dir__() -> list[str]:
    """List the nouns."""
    return sorted(__all__)
