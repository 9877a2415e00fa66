"""Families of cases, of which the default suite looks at those that reach other code."""

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def family(
    cases: Iterable[Any], *, quick: Collection[str] | None = None, slow: Collection[str] = ()
) -> list[Any]:
    """Parameters of a test; all but the ``quick`` ones are marked slow, and the ``slow`` ones.

    A case is known by its name: itself, its attribute, or the first of its values.
    """
    return [
        pytest.param(
            *(case if isinstance(case, tuple) else (case,)),
            id=None if isinstance(case, tuple) else name_of(case),
            marks=[pytest.mark.slow]
            * (name_of(case) in slow or (quick is not None and name_of(case) not in quick)),
        )
        for case in cases
    ]


def name_of(case: Any) -> str:
    """What a case is called."""
    return str(getattr(case, "name", case[0] if isinstance(case, tuple) else case))


WAVES = (
    "rational_2",
    "breather_sn",
    "soliton_dn",
    "wave_cn",
    "soliton_sech",
    "kink",
    "breather",
    "soliton_background",
    "kdv_two_soliton",
    "kdv_cnoidal",
    "gardner_table_soliton",
    "modified_kawahara_soliton",
    "kdv_burgers_shock",
    "kp_line_soliton",
    "kp_lump",
    "nls_plane",
    "nls_dark",
    "nls_akhmediev",
)
"""Closed forms that differ in their functions or in what their equation has: of 38."""
