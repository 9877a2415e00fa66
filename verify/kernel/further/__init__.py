"""What goes further than the catalogue needs: rules and functions that are entered in the tables.

The kernel works without this folder, and refuses the certificates that need it.
"""

from __future__ import annotations

from . import ends, free_functions, inverse, principal, quotients, special, turns

__all__ = ["ends", "free_functions", "inverse", "principal", "quotients", "special", "turns"]
