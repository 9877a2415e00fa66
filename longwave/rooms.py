"""The other rooms are the packages that lie beside this one, whatever the working folder holds."""

import sys
import warnings
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import spec_from_file_location
from pathlib import Path
from types import ModuleType

HOUSE = Path(__file__).resolve().parents[1]
ROOMS = ("derive", "solutions", "lattice", "verify", "runs", "reports")


class RoomFinder(MetaPathFinder):
    """Finds the named rooms in the house, before any file of the same name."""

    def __init__(self, rooms: Sequence[str]) -> None:
        self.rooms = frozenset(rooms)

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """The specification of a room; None for anything else."""
        if name not in self.rooms:
            return None
        folder = HOUSE / name
        return spec_from_file_location(
            name, folder / "__init__.py", submodule_search_locations=[str(folder)]
        )


def claim_rooms() -> None:
    """Have every room imported from the house, with a warning where another file has its name.

    A folder without modules of that name, of the results of runs, say, is passed over in silence.
    Raises ImportError, naming the file, if such a file has been imported before.
    """
    shadows = {room: file for room in ROOMS if (file := _other_file(room)) is not None}
    if not shadows:
        return
    for room, file in shadows.items():
        if room in sys.modules:
            raise ImportError(
                f"{room} must be longwave's own package, got {file}, which was imported before "
                "(rename that file)"
            )
        if Path(file).is_dir() and not any(Path(file).glob("*.py")):
            continue
        warnings.warn(
            f"{file} has the name of a package of longwave; `import {room}` gives longwave's "
            "from here on (rename that file)",
            RuntimeWarning,
            stacklevel=3,
        )
    sys.meta_path.insert(0, RoomFinder(tuple(shadows)))


def _other_file(room: str) -> str | None:
    """The file or folder that is, or would be, imported as the room and is not of the house."""
    if room in sys.modules:
        module = sys.modules[room]
        places = [getattr(module, "__file__", None), *getattr(module, "__path__", ())]
    else:
        spec = PathFinder.find_spec(room)
        if spec is None:
            return None
        places = [spec.origin, *(spec.submodule_search_locations or ())]
    found = [place for place in places if place is not None]
    if any(Path(place).resolve().is_relative_to(HOUSE / room) for place in found):
        return None
    return found[0] if found else room
