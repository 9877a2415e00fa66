"""The reference: one page for each package of the house, written from its docstrings."""

from functools import cache
from importlib import import_module
from pathlib import Path

from house import HOUSE, ROOMS, modules, packages
from paper_map import Row, paper_map


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
    """The rooms, each with the packages inside it that hold modules, not only data."""
    return [
        package
        for room in ROOMS
        for package in packages(room)
        if package == room or any(modules(package))
    ]


def _index() -> str:
    names = "\n".join(f"   {package}" for package in _packages())
    return f"{_title('Reference', '=')}.. toctree::\n   :maxdepth: 1\n\n{names}\n"


def _page(package: str) -> str:
    """The package's own text, then each of its modules under its name."""
    parts = [_title(package, "="), f".. automodule:: {package}\n   :no-members:\n\n"]
    nouns = [_noun(package, name) for name in getattr(import_module(package), "__all__", ())]
    if nouns:
        parts.append(f"It offers {', '.join(nouns)}.\n\n")
    for module in modules(package):
        parts.append(_title(module.removeprefix(f"{package}."), "-"))
        parts.append(f".. automodule:: {module}\n\n")
        parts += _records(module)
    return "".join(parts)


def _records(module: str) -> list[str]:
    """Entries for the records that the paper's map names and that have no docstring."""
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
    """A link to where the noun is defined; a name for what does not know that, as data."""
    value = getattr(import_module(package), name)
    home = getattr(value, "__module__", None)
    if home is None or getattr(value, "__qualname__", None) != name:
        return f"``{name}``"
    return f":py:obj:`~{home}.{name}`"


def _title(text: str, line: str) -> str:
    escaped = text.replace("_", r"\_")
    return f"{escaped}\n{line * len(escaped)}\n\n"
