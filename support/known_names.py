"""Suggestions for unknown names: similar known names, and the list of all."""

from collections.abc import Iterable
from typing import TypeVar

COMPARED_CHARACTERS = 60
"""Number of characters of an unknown name that are compared with known names."""

MAX_SUGGESTIONS = 3
"""Largest number of names suggested."""

MAX_SIMILARITY_LOSS = 0.15
"""Suggested names are less similar than the most similar one by at most this, on a scale 0 .. 1."""

MIN_PREFIX = 3
"""Least number of characters for which an unknown name may be the beginning of a known one."""

MAX_LISTED = 30
"""Largest number of known names listed next to suggestions; of more, only the number is given."""

T = TypeVar("T")


def close_names(name: object, known: Iterable[str], limit: int = MAX_SUGGESTIONS) -> list[str]:
    """Return up to ``limit`` known names similar to the unknown ``name``, the most similar first.

    Similar names have the same letters in another order, a few wrong letters, or a missing end.

    >>> close_names("sehc", ["sech", "tanh"]), close_names("toda", ["fput", "toda_soliton"])
    (['sech'], ['toda_soliton'])
    """
    from difflib import SequenceMatcher, get_close_matches  # for errors alone

    plain: dict[str, str] = {}
    for text in known:
        plain.setdefault(text.lower(), text)
    typed = str(name)[:COMPARED_CHARACTERS].lower()
    close = [other for other in plain if sorted(other) == sorted(typed)]
    if not close and (close := get_close_matches(typed, plain, limit)):
        similarities = [SequenceMatcher(None, other, typed).ratio() for other in close]
        close = [
            o
            for o, value in zip(close, similarities, strict=True)
            if value > similarities[0] - MAX_SIMILARITY_LOSS
        ]
    if not close and len(typed) >= MIN_PREFIX:
        close = [other for other in plain if other.startswith(typed)]
    return [plain[other] for other in close[:limit]]


def did_you_mean(name: object, known: Iterable[str], limit: int = MAX_SUGGESTIONS) -> str:
    """Return a question with the known names similar to ``name``; empty if there are none.

    >>> did_you_mean("Kinck", ["wave_cn", "kink"]), did_you_mean("peakon", ["wave_cn", "kink"])
    ('did you mean kink?', '')
    """
    close = close_names(name, known, limit)
    return f"did you mean {', '.join(close)}?" if close else ""


def one_of(name: object, known: Iterable[str]) -> str:
    """Return the remedy for an unknown name: suggestions, and the list of known names.

    If there is a suggestion, the length of a long list is given in place of the list.

    >>> one_of("kinck", ["wave_cn", "kink"])
    'did you mean kink? one of wave_cn, kink'
    >>> one_of("kinck", ["kink", *map(str, range(37))])
    'did you mean kink? one of 38 names'
    """
    names = [*known]
    question = did_you_mean(name, names)
    listed = ", ".join(names) or "none"
    if question and len(names) > MAX_LISTED:
        listed = f"{len(names)} names"
    return f"{question} one of {listed}".lstrip()


class UnknownNameError(ValueError, KeyError):
    """KeyError for an unknown name in a catalogue, with a text like that of a ValueError."""

    def __str__(self) -> str:
        return str(self.args[0])


class NamedEntries(dict[str, T]):
    """Catalogue of entries by name; the error for an unknown name suggests similar names.

    >>> try:
    ...     NamedEntries("lattice", {"toda": 1, "fput": 2})["todda"]
    ... except KeyError as error:
    ...     print(error)
    lattice must be a known one, got 'todda' (did you mean toda? one of toda, fput)
    """

    def __init__(self, kind: str, entries: dict[str, T]) -> None:
        super().__init__(entries)
        self.kind = kind

    def __missing__(self, name: object) -> T:
        from longwave.support.user_files import shown  # for errors alone

        raise UnknownNameError(
            f"{self.kind} must be a known one, got {shown(name)} ({one_of(name, self)})"
        )

    def __reduce__(self) -> tuple[type, tuple[str, dict[str, T]]]:
        return type(self), (self.kind, dict(self))
