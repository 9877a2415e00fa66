"""Folder of the repository, its rooms, and their packages and modules."""

from collections.abc import Iterator
from pathlib import Path

HOUSE = Path(__file__).resolve().parents[2]

ROOMS = (
    *("support", "derive", "solutions", "verify", "lattice", "waves", "scenes"),
    *("runs", "reports"),
    "longwave",
)
"""Rooms in the order of their imports; the last is the package that contains all of them."""


def packages(room: str) -> Iterator[str]:
    """Yield the room and the packages inside it, by their dotted names."""
    for path in sorted((HOUSE / room).rglob("__init__.py")):
        yield dotted_name(path)


def dotted_name(path: Path, house: Path = HOUSE) -> str:
    """Return the dotted name under which a file of a room is imported.

    >>> dotted_name(HOUSE / "derive" / "lattice.py"), dotted_name(HOUSE / "derive" / "__init__.py")
    ('longwave.derive.lattice', 'longwave.derive')
    """
    parts = path.relative_to(house).with_suffix("").parts
    inside = parts if parts[0] == "longwave" else ("longwave", *parts)
    return ".".join(inside).removesuffix(".__init__")


def modules(package: str) -> Iterator[str]:
    """Yield the modules directly in the package, without commands (`__main__`)."""
    for path in sorted(HOUSE.joinpath(*package.split(".")).glob("*.py")):
        if not path.stem.startswith("__"):
            yield f"{package}.{path.stem}"
