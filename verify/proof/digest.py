"""The format of a certificate and its checksum."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

FORMAT = "longwave proof 1"


def digest(body: Mapping[str, Any]) -> str:
    """A checksum of everything but itself, against slips of the pen."""
    plain = {key: value for key, value in body.items() if key != "digest"}
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()
