"""The face: every public noun is the room's own object, an unknown one is named."""

from importlib import import_module
from importlib.metadata import version

import pytest

import longwave


def test_version_is_the_distributions() -> None:
    assert longwave.__version__ == version("longwave")


@pytest.mark.parametrize("noun", sorted(set(longwave.__all__) - {"__version__"}))
def test_each_noun_is_the_rooms_own(noun: str) -> None:
    room = longwave._ROOM_OF[noun]
    assert getattr(longwave, noun) is getattr(import_module(room), noun)


def test_an_unknown_noun_lists_the_known() -> None:
    with pytest.raises(AttributeError, match=r"no noun 'wavelet'.*Scene"):
        _ = longwave.wavelet


def test_dir_lists_the_nouns() -> None:
    assert set(dir(longwave)) == set(longwave.__all__)
