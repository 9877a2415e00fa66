"""What goes further than the catalogue needs: rules and functions that are entered in the tables.

The kernel works without this folder, and refuses the certificates that need it.
"""

from __future__ import annotations

from . import free_functions, inverse, principal, quotients, special, turns

__all__ = ["free_functions", "inverse", "principal", "quotients", "special", "turns"]
