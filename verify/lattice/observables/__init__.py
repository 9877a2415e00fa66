"""The observables that a scene may ask for, as a table; each is computed only if it is asked for.

>>> from verify.lattice.observables import entry_named
>>> [variable.name for variable in entry_named("momentum").variables]
['mean_strain', 'mean_velocity']
"""

from verify.lattice.observables.axes import axis_values
from verify.lattice.observables.table import ENTRIES, NAMES, entry_named

__all__ = ["ENTRIES", "NAMES", "axis_values", "entry_named"]
