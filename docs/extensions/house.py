"""Where the house stands, which rooms it has, and which modules they hold."""

from collections.abc import Iterator
from pathlib import Path

HOUSE = Path(__file__).resolve().parents[2]

ROOMS = (
    *("support", "derive", "solutions", "verify", "lattice", "scenes", "runs", "reports"),
    "longwave",
)
"""The rooms, each beside what it imports; the last is the package that all are installed in."""


def packages(room: str) -> Iterator[str]:
    """Yield the room and the packages inside it, by their dotted names."""
    for path in sorted((HOUSE / room).rglob("__init__.py")):
        yield dotted_name(path)


def dotted_name(path: Path, house: Path = HOUSE) -> str:
    """The name that a file of a room is imported by.

    >>> dotted_name(HOUSE / "derive" / "lattice.py"), dotted_name(HOUSE / "derive" / "__init__.py")
    ('longwave.derive.lattice', 'longwave.derive')
    """
    parts = path.relative_to(house).with_suffix("").parts
    inside = parts if parts[0] == "longwave" else ("longwave", *parts)
    return ".".join(inside).removesuffix(".__init__")


def modules(package: str) -> Iterator[str]:
    """Yield the modules that lie in the package itself; commands (`__main__`) are left out."""
    for path in sorted(HOUSE.joinpath(*package.split(".")).glob("*.py")):
        if not path.stem.startswith("__"):
            yield f"{package}.{path.stem}"
