"""The texts of a statement as they were typed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class StatementTexts:
    """What was typed, part by part; a certificate holds these texts and no others."""

    variables: tuple[str, ...]
    equations: tuple[str, ...]
    solutions: tuple[str, ...]
    parameters: tuple[str, ...] = ()
    domain: tuple[str, ...] = ()
