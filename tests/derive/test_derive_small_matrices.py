"""Linear algebra of small matrices against SymPy's."""

from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
from sympy import Matrix, Symbol, cancel

from longwave.derive.algebra.rational_functions import RationalFunctions
from longwave.derive.algebra.small_matrices import determinant, inverse, null_space, transposed

x, y = Symbol("x"), Symbol("y")
FIELD = RationalFunctions((x, y))
ENTRIES = (0, 1, -1, 2, x, -x, y, x + y, x * y)

matrices = st.integers(1, 3).flatmap(
    lambda count: st.lists(
        st.lists(st.sampled_from(ENTRIES), min_size=count, max_size=count),
        min_size=count,
        max_size=count,
    )
)


@settings(max_examples=10)
@given(rows=matrices)
def test_small_matrices_agree_with_sympy(rows: Any) -> None:
    own = [[FIELD.from_expr(Matrix([[v]])[0]) for v in row] for row in rows]
    known = Matrix(rows)
    assert cancel(determinant(own).as_expr() - known.det()) == 0
    kernel = null_space(own)
    assert len(kernel) == len(rows) - known.rank() == len(null_space(transposed(own)))
    for vector in kernel:
        assert not any(
            sum((a * b for a, b in zip(row, vector, strict=True)), FIELD.zero) for row in own
        )
        assert next(value for value in vector if value) == FIELD.one
    if not kernel:
        product = known * Matrix([[v.as_expr() for v in row] for row in inverse(own)])
        assert product.applyfunc(cancel) == Matrix.eye(len(rows))
