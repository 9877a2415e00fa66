"""The prover's verdict: a `verify.verdict.Verdict` with assumptions and a certificate."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from verify.verdict import Outcome, Verdict

METHOD = "differential algebra"


@dataclass(frozen=True)
class ProofVerdict(Verdict):
    """``assumptions`` and ``singularities`` in words; a proof's ``certificate``, accepted.

    ``singularities`` names the poles, jumps and branch points that the formula may have inside
    its domains; the verdict holds at the points at which it is smooth.

    Raises ValueError for a proof without a certificate.
    """

    assumptions: tuple[str, ...] = ()
    singularities: tuple[str, ...] = ()
    certificate: Mapping[str, Any] | None = field(default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.outcome is Outcome.PROVED and self.certificate is None:
            raise ValueError(
                "certificate must be given with a proof, got none (prove only what is checked)"
            )

    def certificate_text(self) -> str | None:
        """The certificate as JSON on one line; None where there is none."""
        return None if self.certificate is None else json.dumps(self.certificate)

    @property
    def certificate_bytes(self) -> int | None:
        """The length of `certificate_text`."""
        text = self.certificate_text()
        return None if text is None else len(text)

    def timed(self, seconds: float) -> ProofVerdict:
        """The same verdict with the time it took."""
        return replace(self, seconds=seconds)

    def json(self) -> dict[str, Any]:
        """The record as plain data, with the certificate's size (it is a file of its own)."""
        record = self.__dict__.copy()
        record.pop("certificate")
        record["outcome"] = self.outcome.value
        record["assumptions"] = list(self.assumptions)
        record["singularities"] = list(self.singularities)
        record["certificate_bytes"] = self.certificate_bytes
        record["witness"] = None if self.witness is None else dict(self.witness)
        return record
