"""Catches: data that change on the way, and bytes that call code or exhaust the memory."""

import json
import math
import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from longwave.support.plain_data import HEAD, plain_bytes, plain_value

SCALARS = (
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=9)
)
ARRAYS = hnp.arrays(
    st.sampled_from(["f8", ">f8", "f4", "c16", "i8", "u1", "?", "U3", "S2"]),
    hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=3),
)
VALUES = st.recursive(
    SCALARS | ARRAYS | st.complex_numbers(allow_nan=False),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.tuples(inner, inner)
        | st.dictionaries(st.text(max_size=3) | st.tuples(st.integers()), inner, max_size=3)
    ),
    max_leaves=8,
)


def same(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray | np.generic):
        alike = (one.dtype, one.shape, type(one)) == (other.dtype, other.shape, type(other))
        return alike and one.tobytes() == other.tobytes()
    if isinstance(one, list | tuple):
        return type(one) is type(other) and all(map(same, one, other)) and len(one) == len(other)
    if isinstance(one, dict):
        return list(one) == list(other) and all(same(one[key], other[key]) for key in one)
    return type(one) is type(other) and repr(one) == repr(other)


@given(VALUES)
def test_data_come_back_type_by_type_and_bit_by_bit(value: Any) -> None:
    assert same(plain_value(plain_bytes(value)), value)


def test_values_that_json_lacks_are_restored() -> None:
    for value in (math.inf, -math.inf, -0.0, np.float64(0.1), np.int32(3), 2**400, "\ud800"):
        assert same(plain_value(plain_bytes(value)), value)
    assert math.isnan(plain_value(plain_bytes(math.nan)))
    columns = plain_value(plain_bytes(np.asfortranarray(np.arange(6.0).reshape(2, 3))))
    assert columns.flags.f_contiguous
    assert columns.flags.writeable
    assert columns[1, 2] == 5.0


@pytest.mark.parametrize("value", [object(), {1}, np.array([None]), np.array([1], "M8[s]"), len])
def test_other_types_are_refused(value: object) -> None:
    with pytest.raises(TypeError, match=r"must (be|hold)"):
        plain_bytes(value)


def crafted(tree: object, arrays: bytes = b"") -> bytes:
    text = json.dumps(tree).encode()
    return len(text).to_bytes(HEAD, "little") + text + arrays


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\xff" * 20,
        pickle.dumps([1]),
        crafted({"array": ["|O", [1], "C", 0]}, bytes(8)),
        crafted({"array": ["O", [1], "C", 0]}, bytes(8)),
        crafted({"array": ["<f8,O", [1], "C", 0]}, bytes(16)),
        crafted({"array": ["<f8", [10**12], "C", 0]}, bytes(8)),
        crafted({"array": ["<f8", [2], "C", 8]}, bytes(16)),
        crafted({"array": ["<f8", [-1], "C", 0]}, bytes(8)),
        crafted({"array": ["<f8", [1], "C", -8]}, bytes(8)),
        crafted({"array": ["<f8", [1.0], "C", 0]}, bytes(8)),
        crafted({"array": ["<f8", [0] * 70, "C", 0]}, bytes(8)),
        crafted({"array": ["<U999999999", [1], "C", 0]}, bytes(8)),
        crafted({"os.system": "true"}),
        crafted({"tuple": [1], "dict": []}),
        crafted({"dict": [[[], 1]]}),
        crafted({"tuple": 3}),
    ],
)
def test_foreign_bytes_raise_one_error(content: bytes) -> None:
    with pytest.raises(ValueError, match=r"^data must be those of plain_bytes"):
        plain_value(content)


def test_deeply_nested_data_raise_one_error() -> None:
    text = b"[" * 10**5
    with pytest.raises(ValueError, match=r"^data must be those of plain_bytes"):
        plain_value(len(text).to_bytes(HEAD, "little") + text)
