"""Arrays with named dimensions and attributes: a small part of xarray without its import time.

Drawing a run needs only names, values and indexing, and importing xarray takes half a second.
`LabelledArrays` has the methods of `xarray.Dataset` for that; it wraps one without a copy.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

Indexer = int | slice | Sequence[int] | NDArray[np.integer]
"""Index along a dimension; a single integer removes the dimension."""


@runtime_checkable
class Labelled(Protocol):
    """Protocol of variables with attributes: an `xarray.Dataset`, or `LabelledArrays`."""

    @property
    def attrs(self) -> dict[Any, Any]:
        """Attributes of the data set."""

    @property
    def variables(self) -> Mapping[Any, Any]:
        """Variables by name, including coordinates."""

    @property
    def sizes(self) -> Mapping[Any, int]:
        """Lengths of the dimensions."""


class LabelledValues(Protocol):
    """Protocol of an array with named dimensions: an `xarray.Variable` or a `LabelledArray`."""

    @property
    def dims(self) -> tuple[Any, ...]:
        """Names of the dimensions."""

    @property
    def values(self) -> NDArray[Any]:
        """Values as an array."""

    @property
    def attrs(self) -> dict[Any, Any]:
        """Attributes, such as units."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""

    @property
    def size(self) -> int:
        """Number of values."""

    @property
    def dtype(self) -> Any:
        """Type of the values."""


@dataclass(frozen=True, eq=False)
class LabelledArray:
    """Array with named dimensions and attributes."""

    dims: tuple[str, ...]
    values: NDArray[Any]
    attrs: dict[Any, Any] = field(default_factory=dict)

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return self.values.shape

    @property
    def size(self) -> int:
        """Number of values."""
        return self.values.size

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the values."""
        return self.values.dtype


def select(values: LabelledValues, indexers: Mapping[str, Indexer]) -> LabelledValues:
    """Return the values at ``indexers`` along dimensions; those of other dimensions are ignored.

    >>> ramp = LabelledArray(("time", "site"), np.arange(6).reshape(2, 3))
    >>> select(ramp, {"time": 1, "site": [2, 0], "row": 0})
    LabelledArray(dims=('site',), values=array([5, 3]), attrs={})
    """
    if not set(indexers) & set(values.dims):
        return values
    dims, array = values.dims, values.values
    for name in values.dims:
        if name in indexers:
            indexer, axis = indexers[name], dims.index(name)
            is_basic = isinstance(indexer, int | slice)
            index = indexer if is_basic else np.asarray(indexer, dtype=np.intp)
            array = np.asarray(array[(slice(None),) * axis + (index,)])
            dims = dims if array.ndim == len(dims) else dims[:axis] + dims[axis + 1 :]
    return LabelledArray(dims, array, values.attrs)


@dataclass(frozen=True, eq=False)
class LabelledArrays:
    """Variables with shared dimensions, and attributes; coordinates are variables as well."""

    variables: Mapping[str, LabelledValues]
    attrs: dict[Any, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, data: Labelled) -> LabelledArrays:
        """Return a view of a data set's variables and attributes; nothing is read or copied."""
        if isinstance(data, cls):
            return data
        return cls({str(name): array for name, array in data.variables.items()}, dict(data.attrs))

    def __getitem__(self, name: str) -> LabelledValues:
        return self.variables[name]

    def __contains__(self, name: object) -> bool:
        return name in self.variables

    def __iter__(self) -> Iterator[str]:
        return iter(self.variables)

    def get(self, name: str) -> LabelledValues | None:
        """Return the variable of that name, or None if there is none."""
        return self.variables.get(name)

    @property
    def sizes(self) -> Mapping[Any, int]:
        """Lengths of the dimensions."""
        sizes: dict[Any, int] = {}
        for array in self.variables.values():
            sizes |= zip(array.dims, array.shape, strict=True)
        return sizes

    def isel(self, **indexers: Indexer) -> LabelledArrays:
        """Return all variables at indices along dimensions, as `xarray.Dataset.isel` does."""
        selection = {name: select(array, indexers) for name, array in self.variables.items()}
        return LabelledArrays(selection, self.attrs)

    def assign(self, **added: LabelledValues) -> LabelledArrays:
        """Return the arrays with variables added or replaced."""
        return LabelledArrays({**self.variables, **added}, self.attrs)

    def assign_attrs(self, **added: object) -> LabelledArrays:
        """Return the arrays with attributes added or replaced."""
        return LabelledArrays(self.variables, self.attrs | added)

    def without(self, dimension: str) -> LabelledArrays:
        """Return the arrays without the variables that have this dimension."""
        rest = {name: each for name, each in self.variables.items() if dimension not in each.dims}
        return LabelledArrays(rest, self.attrs)
