"""Every known long-wave limit comes out of its declaration, with the same coefficients."""

from dataclasses import replace

import pytest

from tests.derive.known_reductions import Row, all_rows

ROWS = {row.name: row for row in all_rows()}


@pytest.mark.parametrize("name", ROWS)
def test_the_known_reduction_comes_out(name: str) -> None:
    assert not list(ROWS[name].differences())


def changed(row: Row) -> Row:
    term = next(iter(row.terms))
    return replace(row, terms={**row.terms, term: row.terms[term] * 101 / 100})


@pytest.mark.parametrize("name", ["1", "6d", "7h"])
def test_another_coefficient_is_detected(name: str) -> None:
    assert len(list(changed(ROWS[name]).differences())) == 1
    assert list(replace(ROWS[name], squared=ROWS[name].squared * 2).differences())
