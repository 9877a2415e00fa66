"""The reference: a page for `longwave`, then one for each package, from the docstrings."""

from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path

from house import HOUSE, ROOMS, modules, packages
from paper_map import Row, paper_map

FACE = ROOMS[-1]
"""The package from which users import the public names."""


@cache
def _map() -> list[Row]:
    return paper_map(HOUSE, ROOMS)


def write_reference(folder: Path) -> None:
    """Write a page for each package into the folder, and remove pages of packages that are gone."""
    folder.mkdir(parents=True, exist_ok=True)
    pages = {f"{package}.rst": _page(package) for package in _packages()}
    pages["index.rst"] = _index()
    for stale in set(folder.glob("*.rst")) - {folder / name for name in pages}:
        stale.unlink()
    for name, text in pages.items():
        path = folder / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def _packages() -> list[str]:
    """Return `longwave`, then the rooms, each with its packages that contain modules."""
    return [
        package
        for room in (FACE, *ROOMS[:-1])
        for package in packages(room)
        if package == room or any(modules(package))
    ]


def _index() -> str:
    """Return the index of the reference: the page of ``longwave``, then its packages."""
    names = "".join(f"   {package}\n" for package in _packages() if package != FACE)
    return (
        f"{_title('Reference', '=')}"
        "Everything that a script needs is imported from ``longwave`` itself. The packages behind\n"
        "it are for those who extend the program; what they import is in ``CONTRIBUTING.md``.\n\n"
        f".. toctree::\n   :maxdepth: 2\n\n   {FACE}\n\n"
        f".. toctree::\n   :maxdepth: 1\n   :caption: The packages behind it\n\n{names}"
    )


def _face() -> Iterator[str]:
    """Yield every public name of ``longwave`` with its docstring, grouped by room."""
    nouns = [name for name in import_module(FACE).__all__ if not name.startswith("__")]
    for room in (FACE, *ROOMS[:-1]):
        held = [name for name in nouns if _room_of(name) == room]
        if held:
            yield _title("Sessions" if room == FACE else f"From {FACE}.{room}", "-")
            yield from (_documented(name) for name in held)


def _room_of(name: str) -> str:
    """Return the room that exports the name, or ``longwave`` if none does."""
    for room in ROOMS[:-1]:
        if name in getattr(import_module(f"{FACE}.{room}"), "__all__", ()):
            return room
    home = str(getattr(getattr(import_module(FACE), name), "__module__", "")).split(".")
    return home[1] if len(home) > 1 and home[1] in ROOMS else FACE


def _documented(name: str) -> str:
    """Return the entry of a class, function or catalogue, with a link to its definition."""
    value = getattr(import_module(FACE), name)
    if isinstance(value, type):
        return f".. autoclass:: {FACE}.{name}\n   :inherited-members:\n   :no-index:\n\n"
    if callable(value):
        return f".. autofunction:: {FACE}.{name}\n   :no-index:\n\n"
    named = ", ".join(f"``{key}``" for key in getattr(value, "names", value))
    room = f":py:mod:`{FACE}.{_room_of(name)}`"
    head = f".. py:data:: {FACE}.{name}\n   :no-index:\n"
    return f"{head}\n   By name, from {room}: {named}.\n\n"


def _page(package: str) -> str:
    """Return the package's docstring and public names, then each of its modules."""
    parts = [_title(package, "="), f".. automodule:: {package}\n   :no-members:\n\n"]
    nouns = [_noun(package, name) for name in getattr(import_module(package), "__all__", ())]
    if package == FACE:
        parts += _face()
    elif nouns:
        parts.append(f"It offers {', '.join(nouns)}.\n\n")
    for module in modules(package):
        parts.append(_title(module.removeprefix(f"{package}."), "-"))
        parts.append(f".. automodule:: {module}\n\n")
        parts += _records(module)
    return "".join(parts)


def _records(module: str) -> list[str]:
    """Return entries for records in the paper's map that have no docstring."""
    held: dict[str, list[str]] = {}
    for row in _map():
        for holder in row.holders:
            if holder.module == module and not holder.described:
                held.setdefault(holder.name, []).append(row.place)
    return [
        f".. py:data:: {name}\n   :module: {module}\n\n"
        f"   {_title_of(module, name)}In the paper: {', '.join(places)}.\n\n"
        for name, places in held.items()
    ]


def _title_of(module: str, name: str) -> str:
    title = getattr(getattr(import_module(module), name), "title", "")
    return f"{title[0].upper()}{title[1:]}. " if title else ""


def _noun(package: str, name: str) -> str:
    """Return a link to the definition of a name, or the name alone for data."""
    value = getattr(import_module(package), name)
    home = getattr(value, "__module__", None)
    if home is None or getattr(value, "__qualname__", None) != name:
        return f"``{name}``"
    return f":py:obj:`~{home}.{name}`"


def _title(text: str, line: str) -> str:
    escaped = text.replace("_", r"\_")
    return f"{escaped}\n{line * len(escaped)}\n\n"
