"""Names that are not known: which ones may have been meant, and which there are."""

from collections.abc import Iterable
from typing import TypeVar

LOOKED_AT = 60
"""Characters of an unknown name that are compared."""

MOST = 3
"""Names that may have been meant."""

NEARLY = 0.15
"""What a name may be less alike than the one that is most alike, of a likeness of 0 .. 1."""

BEGINNING = 3
"""Characters that may be the beginning of a name."""

FEW = 30
"""Names that are listed beside those that may have been meant."""

T = TypeVar("T")


def close_names(name: object, known: Iterable[str], most: int = MOST) -> list[str]:
    """The known names that an unknown one is like, the most alike first.

    That is with two letters exchanged, with some of them wrong, or with an end to be added.

    >>> close_names("sehc", ["sech", "tanh"]), close_names("toda", ["fput", "toda_soliton"])
    (['sech'], ['toda_soliton'])
    """
    from difflib import SequenceMatcher, get_close_matches  # for errors alone

    plain: dict[str, str] = {}
    for text in known:
        plain.setdefault(text.lower(), text)
    typed = str(name)[:LOOKED_AT].lower()
    close = [other for other in plain if sorted(other) == sorted(typed)]
    if not close and (close := get_close_matches(typed, plain, most)):
        alike = [SequenceMatcher(None, other, typed).ratio() for other in close]
        close = [o for o, value in zip(close, alike, strict=True) if value > alike[0] - NEARLY]
    if not close and len(typed) >= BEGINNING:
        close = [other for other in plain if other.startswith(typed)]
    return [plain[other] for other in close[:most]]


def did_you_mean(name: object, known: Iterable[str], most: int = MOST) -> str:
    """The known names that an unknown one is like, as a question; empty if it is like none.

    >>> did_you_mean("Kinck", ["wave_cn", "kink"]), did_you_mean("peakon", ["wave_cn", "kink"])
    ('did you mean kink?', '')
    """
    close = close_names(name, known, most)
    return f"did you mean {', '.join(close)}?" if close else ""


def one_of(name: object, known: Iterable[str]) -> str:
    """The remedy for an unknown name: which may have been meant, and all that there are.

    Many are counted where one of them may have been meant.

    >>> one_of("kinck", ["wave_cn", "kink"])
    'did you mean kink? one of wave_cn, kink'
    >>> one_of("kinck", ["kink", *map(str, range(37))])
    'did you mean kink? one of 38 names'
    """
    names = [*known]
    meant = did_you_mean(name, names)
    listed = f"{len(names)} names" if meant and len(names) > FEW else ", ".join(names) or "none"
    return f"{meant} one of {listed}".lstrip()


class UnknownNameError(ValueError, KeyError):
    """A name that is none of a catalogue's: a KeyError that reads as every ValueError does."""

    def __str__(self) -> str:
        return str(self.args[0])


class NamedEntries(dict[str, T]):
    """A catalogue by name, which says for an unknown one which may have been meant.

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
