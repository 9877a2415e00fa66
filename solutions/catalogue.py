"""The catalogue of closed forms. Adding one is one file in ``forms`` and one line here."""

import re
from collections.abc import Iterable

from solutions.forms.bare_waves import WAVE_CN, WAVE_DN, WAVE_SN
from solutions.forms.breather import BREATHER
from solutions.forms.breather_sn import BREATHER_SN
from solutions.forms.double_pole import DOUBLE_POLE
from solutions.forms.kink import KINK
from solutions.forms.kink_antikink import KINK_ANTIKINK
from solutions.forms.rational import RATIONAL_1, RATIONAL_2, RATIONAL_3, rational
from solutions.forms.rogue_cn import ROGUE_CN
from solutions.forms.soliton_background import SOLITON_BACKGROUND
from solutions.forms.soliton_dn import SOLITON_DN
from solutions.forms.soliton_sech import SOLITON_SECH
from solutions.forms.two_soliton import TWO_SOLITON
from solutions.record import ClosedForm

__all__ = ["CATALOGUE", "closed_form"]

CATALOGUE: tuple[ClosedForm, ...] = (
    RATIONAL_1,
    RATIONAL_2,
    RATIONAL_3,
    BREATHER_SN,
    SOLITON_DN,
    ROGUE_CN,
    WAVE_SN,
    WAVE_CN,
    WAVE_DN,
    SOLITON_SECH,
    KINK,
    BREATHER,
    DOUBLE_POLE,
    TWO_SOLITON,
    SOLITON_BACKGROUND,
    KINK_ANTIKINK,
)


LARGEST_ORDER = 12
"""Highest order of a rational solution that is made from its name."""

_RATIONAL = re.compile(r"rational_([1-9]\d?)")
_SHIFT = re.compile(r"tau_([1-9]\d?)")


def closed_form(name: str, parameters: Iterable[str] = ()) -> ClosedForm:
    """The closed form called ``name``; a ValueError lists the names if there is none.

    ``rational_<j>`` is there for every order j up to ``LARGEST_ORDER``. Its free shifts are those
    named in ``parameters`` (tau_5, tau_7, ...); other parameters do not matter here.

    >>> closed_form("kink").title
    'kink'
    >>> [parameter.name for parameter in closed_form("rational_4", ["tau_5"]).parameters]
    ['tau_5']
    """
    match = _RATIONAL.fullmatch(name)
    shifts = [int(found[1]) for text in parameters if (found := _SHIFT.fullmatch(text))]
    printed = next((form for form in CATALOGUE if form.name == name), None)
    if match and int(match[1]) <= LARGEST_ORDER and (shifts or printed is None):
        return rational(int(match[1]), shifts)
    if printed is not None:
        return printed
    names = ", ".join(form.name for form in CATALOGUE)
    raise ValueError(
        f"name must be a closed form of the catalogue, got {name!r} "
        f"(one of {names}; rational_<j> for j up to {LARGEST_ORDER})"
    )
