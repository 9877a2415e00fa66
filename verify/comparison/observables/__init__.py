"""The observables that a scene may ask for, as a table; each is computed only if it is asked for.

>>> from verify.comparison.observables import entry_named
>>> [variable.name for variable in entry_named("momentum").variables]
['mean_strain', 'mean_velocity']
"""

from verify.comparison.observables.entry import axis_values
from verify.comparison.observables.table import ENTRIES, NAMES, entry_named

__all__ = ["ENTRIES", "NAMES", "axis_values", "entry_named"]
