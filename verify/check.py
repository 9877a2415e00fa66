"""The check that each closed form gets: exact where it is rational, to many digits elsewhere."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from solutions.catalogue import CATALOGUE
from solutions.closed_form import ClosedForm
from verify.rational import check_rational, is_rational
from verify.residual import Sampling, check_residual
from verify.verdict import Verdict


def check(form: ClosedForm, sampling: Sampling | None = None) -> Verdict:
    """The verdict on ``form``: a proof if it is rational, else its high-precision residual.

    >>> from solutions.catalogue import closed_form
    >>> print(check(closed_form("rational_2")).outcome)
    PROVED
    """
    return check_rational(form) if is_rational(form) else check_residual(form, sampling)


def check_all(
    forms: Iterable[ClosedForm] = CATALOGUE, sampling: Sampling | None = None
) -> Iterator[Verdict]:
    """The verdicts on ``forms``, one after the other as they are reached."""
    for form in forms:
        yield check(form, sampling)
