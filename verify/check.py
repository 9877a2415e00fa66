"""The exact check that each closed form gets, by name: the catalogue and higher rational orders."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from solutions.catalogue import CATALOGUE, closed_form
from solutions.forms.rational import rational
from solutions.record import ClosedForm
from verify.proof import ProofVerdict, prove_form, prove_rational

HIGHER_ORDERS = range(4, 10)
"""The orders of the rational family that are proved along with the catalogue."""

NAMES = (
    *(form.name for form in CATALOGUE),
    *(f"rational_{order}" for order in HIGHER_ORDERS),
)
"""Every form that is checked where none is named."""


def higher_order(name: str) -> int | None:
    """The order of a member of the rational family; None for a name of the catalogue.

    Raises ValueError, listing the catalogue, if ``name`` is neither.

    >>> higher_order("rational_7"), higher_order("rational_2")
    (7, None)
    """
    member = re.fullmatch(r"rational_([1-9][0-9]?)", name)
    if member is None or int(member[1]) < HIGHER_ORDERS.start:
        closed_form(name)
        return None
    return int(member[1])


def named_form(name: str) -> ClosedForm:
    """The closed form of that name; raises ValueError as `higher_order` does."""
    order = higher_order(name)
    return closed_form(name) if order is None else rational(order)


def check(name: str) -> ProofVerdict:
    """The exact verdict on the form called ``name``; raises ValueError as `higher_order` does.

    >>> print(check("rational_2").outcome, check("rational_4").outcome)
    PROVED PROVED
    """
    order = higher_order(name)
    return prove_form(named_form(name)) if order is None else prove_rational(order)


def check_all(names: Iterable[str] = NAMES) -> Iterator[ProofVerdict]:
    """The verdicts on the forms called ``names``, one after the other as they are reached."""
    for name in names:
        yield check(name)
