"""Names that are not known: which ones may have been meant, and which there are."""

from collections.abc import Iterable

LOOKED_AT = 60
"""Characters of an unknown name that are compared."""

MOST = 3
"""Names that may have been meant."""


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """The known names that an unknown one is like, as a question; empty if it is like none.

    >>> did_you_mean("Kinck", ["wave_cn", "kink"]), did_you_mean("peakon", ["wave_cn", "kink"])
    ('did you mean kink?', '')
    """
    from difflib import get_close_matches  # for errors alone

    plain = {text.lower(): text for text in known}
    close = get_close_matches(str(name)[:LOOKED_AT].lower(), plain, MOST)
    return f"did you mean {', '.join(plain[text] for text in close)}?" if close else ""


def one_of(name: object, known: Iterable[str]) -> str:
    """The remedy for an unknown name: which may have been meant, and all that there are.

    >>> one_of("kinck", ["wave_cn", "kink"])
    'did you mean kink? one of wave_cn, kink'
    """
    names = [*known]
    return f"{did_you_mean(name, names)} one of {', '.join(names)}".lstrip()
