"""Where the house stands, which rooms it has, and which modules they hold."""

import tomllib
from collections.abc import Iterator
from pathlib import Path

HOUSE = Path(__file__).resolve().parents[2]

_PROJECT = tomllib.loads((HOUSE / "pyproject.toml").read_text(encoding="utf-8"))

ROOMS: tuple[str, ...] = tuple(_PROJECT["tool"]["mypy"]["packages"])
"""The rooms, left to right."""


def packages(room: str) -> Iterator[str]:
    """Yield the room and the packages inside it, by their dotted names."""
    for path in sorted((HOUSE / room).rglob("__init__.py")):
        yield ".".join(path.relative_to(HOUSE).parent.parts)


def modules(package: str) -> Iterator[str]:
    """Yield the modules that lie in the package itself; commands (`__main__`) are left out."""
    for path in sorted(HOUSE.joinpath(*package.split(".")).glob("*.py")):
        if not path.stem.startswith("__"):
            yield f"{package}.{path.stem}"
