"""What goes further than the catalogue needs: rules and functions that are entered in the tables.

The kernel works without this folder, and refuses the certificates that need it.
"""

from __future__ import annotations

from . import inverse, jets, principal, quotients, special, turns

__all__ = ["inverse", "jets", "principal", "quotients", "special", "turns"]
