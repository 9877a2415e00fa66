"""Arrays over named dimensions, with attributes: what a data set holds, without its half second.

A run that is drawn at once needs names, values and places of them and no more. `LabelledArrays`
have the words of an `xarray.Dataset` for that, and are made of one without copying it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

Places = int | slice | Sequence[int] | NDArray[np.integer]
"""Places along a dimension; one integer takes the dimension away."""


@runtime_checkable
class Labelled(Protocol):
    """Variables with attributes: an `xarray.Dataset`, or `LabelledArrays`."""

    @property
    def attrs(self) -> dict[Any, Any]:
        """Attributes of all variables together."""

    @property
    def variables(self) -> Mapping[Any, Any]:
        """Variables by their names, coordinates among them."""

    @property
    def sizes(self) -> Mapping[Any, int]:
        """Lengths of the dimensions."""


class LabelledValues(Protocol):
    """Values over named dimensions: an `xarray.Variable`, or a `LabelledArray`."""

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
    """Values over named dimensions, with attributes."""

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


def at_places(values: LabelledValues, places: Mapping[str, Places]) -> LabelledValues:
    """Return the values at some places along the dimensions that they have.

    >>> ramp = LabelledArray(("time", "site"), np.arange(6).reshape(2, 3))
    >>> at_places(ramp, {"time": 1, "site": [2, 0], "row": 0})
    LabelledArray(dims=('site',), values=array([5, 3]), attrs={})
    """
    if not set(places) & set(values.dims):
        return values
    dims, held = values.dims, values.values
    for name in values.dims:
        if name in places:
            place, axis = places[name], dims.index(name)
            chosen = place if isinstance(place, int | slice) else np.asarray(place, dtype=np.intp)
            held = np.asarray(held[(slice(None),) * axis + (chosen,)])
            dims = dims if held.ndim == len(dims) else dims[:axis] + dims[axis + 1 :]
    return LabelledArray(dims, held, values.attrs)


@dataclass(frozen=True, eq=False)
class LabelledArrays:
    """Variables that share dimensions, with attributes; coordinates are variables as well."""

    variables: Mapping[str, LabelledValues]
    attrs: dict[Any, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, data: Labelled) -> LabelledArrays:
        """Return the variables and attributes of a data set; nothing is read and nothing copied."""
        if isinstance(data, cls):
            return data
        return cls({str(name): held for name, held in data.variables.items()}, dict(data.attrs))

    def __getitem__(self, name: str) -> LabelledValues:
        return self.variables[name]

    def __contains__(self, name: object) -> bool:
        return name in self.variables

    def __iter__(self) -> Iterator[str]:
        return iter(self.variables)

    def get(self, name: str) -> LabelledValues | None:
        """Return the variable, or None if there is none of that name."""
        return self.variables.get(name)

    @property
    def sizes(self) -> Mapping[Any, int]:
        """Lengths of the dimensions."""
        found: dict[Any, int] = {}
        for held in self.variables.values():
            found |= zip(held.dims, held.shape, strict=True)
        return found

    def isel(self, **places: Places) -> LabelledArrays:
        """Return all variables at some places along dimensions, as `xarray.Dataset.isel` does."""
        chosen = {name: at_places(held, places) for name, held in self.variables.items()}
        return LabelledArrays(chosen, self.attrs)

    def assign(self, **added: LabelledValues) -> LabelledArrays:
        """Return the arrays with other variables, or more of them."""
        return LabelledArrays({**self.variables, **added}, self.attrs)

    def assign_attrs(self, **added: object) -> LabelledArrays:
        """Return the arrays with other attributes, or more of them."""
        return LabelledArrays(self.variables, self.attrs | added)

    def without(self, dimension: str) -> LabelledArrays:
        """Return the variables that do not lie along the dimension."""
        rest = {name: held for name, held in self.variables.items() if dimension not in held.dims}
        return LabelledArrays(rest, self.attrs)
