"""The face of a room: its nouns under the room's name, each imported when it is first asked for.

A command that only shows its help, or another room that needs one record, imports no more than
that.
"""

import sys
import time
from collections.abc import Callable, Mapping
from importlib import import_module

BEGUN = time.time()
"""When the first room was imported: what runs is older."""


def lazy_exports(
    room: str, modules: Mapping[str, str]
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """The room's ``__getattr__`` and ``__dir__``, from the nouns (in one text) of each module.

    Asking for anything else raises AttributeError, with the nouns that there are.
    """
    module_of = {noun: module for module, nouns in modules.items() for noun in nouns.split()}

    def get(noun: str) -> object:
        if noun not in module_of:
            from longwave.support.known_names import one_of

            known = "" if noun.startswith("_") else f" ({one_of(noun, sorted(module_of))})"
            raise AttributeError(f"{room} has no noun {noun!r}{known}")
        value = getattr(import_module(module_of[noun]), noun)
        setattr(sys.modules[room], noun, value)
        return value

    return get, lambda: sorted({*vars(sys.modules[room]), *sys.modules[room].__all__})
