"""The catalogue of closed forms. Adding one is one file in ``forms`` and one line here."""

from solutions.closed_form import ClosedForm
from solutions.forms.bare_waves import WAVE_CN, WAVE_DN, WAVE_SN
from solutions.forms.breather import BREATHER
from solutions.forms.breather_sn import BREATHER_SN
from solutions.forms.double_pole import DOUBLE_POLE
from solutions.forms.kink import KINK
from solutions.forms.kink_antikink import KINK_ANTIKINK
from solutions.forms.rational_1 import RATIONAL_1
from solutions.forms.rational_2 import RATIONAL_2
from solutions.forms.rational_3 import RATIONAL_3
from solutions.forms.rogue_cn import ROGUE_CN
from solutions.forms.soliton_background import SOLITON_BACKGROUND
from solutions.forms.soliton_dn import SOLITON_DN
from solutions.forms.soliton_sech import SOLITON_SECH
from solutions.forms.two_soliton import TWO_SOLITON

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


def closed_form(name: str) -> ClosedForm:
    """The closed form called ``name``; a ValueError lists the names if there is none.

    >>> closed_form("kink").title
    'kink'
    """
    for form in CATALOGUE:
        if form.name == name:
            return form
    names = ", ".join(form.name for form in CATALOGUE)
    raise ValueError(f"name must be a closed form of the catalogue, got {name!r} (one of {names})")
