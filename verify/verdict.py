"""Verdicts on closed forms: outcome, method, details and run time."""

from __future__ import annotations

import enum
import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from longwave.support.html_tables import html_table


class Outcome(enum.StrEnum):
    """Outcome of a check; UNDECIDED is distinct from REFUTED.

    ``PROVED`` is exact (`verify.proof`).  ``CHECKED`` is a residual that vanishes at the stated
    digits and points, which is evidence and not a proof.  ``REFUTED`` has a witness,
    ``UNDECIDED`` a reason.  ``UNREADABLE`` is a text that is not a statement.
    """

    PROVED = "PROVED"
    CHECKED = "CHECKED"
    REFUTED = "REFUTED"
    UNDECIDED = "UNDECIDED"
    UNREADABLE = "UNREADABLE"

    @property
    def passed(self) -> bool:
        """Whether the outcome is PROVED or CHECKED.

        >>> Outcome.CHECKED.passed, Outcome.UNDECIDED.passed
        (True, False)
        """
        return self in (Outcome.PROVED, Outcome.CHECKED)


@dataclass(frozen=True, repr=False)
class Verdict:
    """Outcome of one check of one closed form.

    ``detail`` is one line: the residual at each precision, the fact that was proved, or the reason
    why nothing was decided.  ``residual`` is the largest relative residual at the highest
    precision (0 for an exact proof, None if there is none).  ``witness`` is the point, as exact
    rationals in text, at which a refuted form has a nonzero residual.  Raises ValueError for a
    refutation without a witness, and for an undecided verdict without a reason.

    >>> Verdict("kink", "mKdV", "proof", Outcome.REFUTED, "residual 2", witness={"xi": "1"})
    <Verdict REFUTED: kink, mKdV: residual 2 at xi = 1>
    """

    name: str
    equation: str
    method: str
    outcome: Outcome
    detail: str
    residual: float | None = None
    witness: Mapping[str, str] | None = None
    seconds: float = 0.0

    def __post_init__(self) -> None:
        if self.outcome is Outcome.REFUTED and self.witness is None:
            remedy = "use UNDECIDED where there is no such point"
            raise ValueError(f"witness must name the point of a refutation, got none ({remedy})")
        if self.outcome is Outcome.UNDECIDED and not self.detail:
            words = "detail must give the reason of an undecided verdict, got ''"
            raise ValueError(f"{words} (say what stopped it)")

    @property
    def passed(self) -> bool:
        """Whether the closed form stands: proved or checked."""
        return self.outcome.passed

    @property
    def heading(self) -> str:
        """The outcome as text, the first words of a verdict."""
        return str(self.outcome)

    @property
    def point(self) -> str:
        """The witness point in words."""
        return ", ".join(f"{name} = {value}" for name, value in (self.witness or {}).items())

    def json(self) -> dict[str, Any]:
        """Return the record as plain data for ``json.dumps``.

        >>> verdict = Verdict("kink", "defocusing mKdV", "residual", Outcome.CHECKED, "3e-49")
        >>> verdict.json()["outcome"]
        'CHECKED'
        """
        record = vars(self) | {"outcome": self.outcome.value}
        record["witness"] = None if self.witness is None else dict(self.witness)
        return record

    def __repr__(self) -> str:
        text = f"{self.detail} at {self.point}" if self.witness else self.detail
        kind = type(self).__name__
        return f"<{kind} {self.heading}: {self.name}, {self.equation}: {text}>"

    @property
    def html_rows(self) -> dict[str, str]:
        """Rows of the HTML table that a notebook shows: texts by label."""
        took = f"{self.seconds:.2g} s, {self.method}"
        return {"equation": self.equation, "found": self.detail, "at": self.point, "took": took}

    def _repr_html_(self) -> str:
        rows = [(words, text) for words, text in self.html_rows.items() if text]
        return html_table(f"{self.heading}: {self.name}", rows)


Given = ParamSpec("Given")
AnyVerdict = TypeVar("AnyVerdict", bound=Verdict)


def timed(decide: Callable[Given, AnyVerdict]) -> Callable[Given, AnyVerdict]:
    """Return ``decide`` with its run time in seconds recorded in the verdicts."""

    @wraps(decide)
    def measured(*arguments: Given.args, **options: Given.kwargs) -> AnyVerdict:
        start = time.perf_counter()
        verdict = decide(*arguments, **options)
        return replace(verdict, seconds=time.perf_counter() - start)

    return measured


SHOWN_PLACES = 4
"""Most places that `on_each_side` lists."""


def on_each_side(places: Sequence[str], sites: Sequence[str] = ()) -> str:
    """Return in words that a proof holds on each side of ``places`` and apart from ``sites``.

    >>> on_each_side(["x = c*t"])
    'on each side of x = c*t, nothing said across it'
    >>> on_each_side([], ["n = 3"])
    'apart from n = 3, nothing said of it'
    """
    parts = []
    cases = ("on each side of", places, "across"), ("apart from", sites, "of")
    for before, listed, after in cases:
        more = len(listed) - SHOWN_PLACES
        names = [*listed[:SHOWN_PLACES], *([f"{more} more"] if more > 0 else [])]
        them = "it" if len(listed) == 1 else "them"
        parts += [f"{before} {', '.join(names)}, nothing said {after} {them}"] if listed else []
    return " and ".join(parts)


@dataclass(frozen=True, repr=False)
class ProofVerdict(Verdict):
    """Verdict of the prover, with ``assumptions`` in words and a proof's accepted ``certificate``.

    ``sides`` names places in the domain where a formula may jump or have a corner; a proof holds on
    each side.  ``singularities`` names poles, jumps and branch points inside the domains, where the
    verdict makes no claim.  Raises ValueError for a proof without a certificate.
    """

    assumptions: tuple[str, ...] = ()
    singularities: tuple[str, ...] = ()
    certificate: Mapping[str, Any] | None = field(default=None, compare=False)
    sides: str = ""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.outcome is Outcome.PROVED and self.certificate is None:
            remedy = "prove only what is checked"
            raise ValueError(f"certificate must be given with a proof, got none ({remedy})")

    @property
    def restriction(self) -> str:
        """Text after the word PROVED: the ``sides`` of a proof, else ""."""
        return self.sides if self.outcome is Outcome.PROVED else ""

    @property
    def nonsmooth_lines(self) -> tuple[str, ...]:
        """Lines for the places at which the formula may not be smooth."""
        return tuple(f"possibly not smooth: {line}" for line in self.singularities)

    @property
    def heading(self) -> str:
        """The outcome and its restriction."""
        return f"{self.outcome} {self.restriction}".strip()

    @property
    def html_rows(self) -> dict[str, str]:
        """Rows of the HTML table, with assumptions and singularities."""
        further = {"holds": self.assumptions, "except at": self.singularities}
        return super().html_rows | {words: "; ".join(texts) for words, texts in further.items()}

    @property
    def certificate_bytes(self) -> int | None:
        """Length of the certificate as JSON on one line; None without a certificate."""
        return None if self.certificate is None else len(json.dumps(self.certificate))

    def json(self) -> dict[str, Any]:
        """Return the record as plain data, with the size of the certificate in place of it."""
        record = super().json()
        del record["certificate"]
        lists = {name: list(record[name]) for name in ("assumptions", "singularities")}
        return record | lists | {"certificate_bytes": self.certificate_bytes}
