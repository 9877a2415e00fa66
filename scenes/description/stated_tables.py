"""Tables of a scene's file as they were stated, for keys that other modules interpret."""

import json
from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np


class StatedTables:
    """Hashable nested tables, stored as JSON; two are equal if their JSON is, order included.

    Raises ValueError for values that JSON cannot represent; ``what`` names them in the message.

    >>> StatedTables({"sites": 8}) == StatedTables({"sites": 8}), StatedTables({"sites": 8}).json
    (True, '{"sites": 8}')
    """

    def __init__(self, tables: Mapping[str, Any], what: str = "tables") -> None:
        try:
            self.json = json.dumps(tables, default=np.ndarray.tolist)
        except TypeError as error:
            raise ValueError(
                f"{what} must hold numbers, texts and lists, got another ({error})"
            ) from None

    @cached_property
    def tables(self) -> dict[str, Any]:
        """Nested tables as a cached dict, which must not be modified."""
        tables: dict[str, Any] = json.loads(self.json)
        return tables

    def __eq__(self, other: object) -> bool:
        return isinstance(other, StatedTables) and self.json == other.json

    def __hash__(self) -> int:
        return hash(self.json)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.tables})"
