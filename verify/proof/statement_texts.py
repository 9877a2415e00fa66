"""The texts of a statement as they were typed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class StatementTexts:
    """What was typed, part by part; a certificate holds these texts and no others."""

    variables: tuple[str, ...]
    equations: tuple[str, ...]
    solutions: tuple[str, ...]
    parameters: tuple[str, ...] = ()
    domain: tuple[str, ...] = ()

    def with_values(self, values: Mapping[str, str]) -> StatementTexts:
        """The texts with parameters that stand for formulas in the place of any values.

        >>> texts = StatementTexts(("x",), ("u_x - b",), ("u = x",), ("b: b>0",))
        >>> texts.with_values({"b": "1"}).parameters
        ('b = 1',)
        """
        kept = (
            p
            for p in self.parameters
            if p.replace("=", ":").partition(":")[0].strip() not in values
        )
        made = (f"{name} = {text}" for name, text in values.items())
        return replace(self, parameters=(*made, *kept))
