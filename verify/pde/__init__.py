"""The reduced equation itself, integrated in time."""

from verify.pde.mkdv import PeriodicMkdv, evolve

__all__ = ["PeriodicMkdv", "evolve"]
