"""The notebook of the documentation runs, and its cells show what the page shows."""

import base64
import io
from typing import Any

import nbformat
import numpy as np
import pytest
from PIL import Image

from tools.notebook import NOTEBOOK, code_cells, executed, output_kinds

FIRST_PROOF = 'longwave.prove("u_t + 6*u*u_x + u_xxx", "u = 2'


@pytest.fixture(scope="module")
def made() -> Any:
    return executed()


def kept() -> Any:
    return nbformat.read(NOTEBOOK, as_version=4)


def by_source(notebook: Any, begin: str) -> Any:
    (found,) = (cell for cell in code_cells(notebook) if cell.source.startswith(begin))
    return found


def test_the_page_holds_what_its_cells_show() -> None:
    """Catches: a notebook that is kept without outputs, of which the site shows none."""
    assert len(kept().cells) >= 20
    quiet = [cell.source for cell in code_cells(kept()) if not output_kinds(cell)]
    assert quiet == ["import longwave"]


@pytest.mark.slow
def test_every_cell_runs_and_shows_the_same_kinds(made: Any) -> None:
    for now, before in zip(code_cells(made), code_cells(kept()), strict=True):
        assert output_kinds(now) == output_kinds(before), now.source


@pytest.mark.slow
def test_texts_are_those_of_the_page(made: Any) -> None:
    """Of what does not depend on the machine: formulas, verdicts, the scene."""
    for now, before in zip(code_cells(made), code_cells(kept()), strict=True):
        for one, two in zip(results(now), results(before), strict=True):
            if "text/latex" in one:
                assert one["text/latex"] == two["text/latex"]
    assert "PROVED" in results(by_source(made, FIRST_PROOF))[0]["text/html"]


def results(cell: Any) -> list[Any]:
    return [output.data for output in cell.outputs if "data" in output]


@pytest.mark.slow
@pytest.mark.parametrize(
    "begin", ["longwave.plot(run", "convergence.plot()", "longwave.plot(sweep)"]
)
def test_pictures_show_themselves_without_a_magic_word(made: Any, begin: str) -> None:
    """Catches: `<Figure size 650x422 with 3 Axes>` in the place of the picture."""
    (data,) = results(by_source(made, begin))
    picture = np.asarray(Image.open(io.BytesIO(base64.b64decode(data["image/png"]))).convert("L"))
    assert picture.shape[1] > 600
    assert (picture < 200).mean() > 0.005


@pytest.mark.slow
def test_a_film_shows_itself(made: Any) -> None:
    (data,) = results(by_source(made, "longwave.animate("))
    assert "base64," in data["text/html"]


@pytest.mark.slow
def test_a_long_call_shows_how_far_it_is(made: Any) -> None:
    """Catches: a call of seconds without a word, or with a line for each word."""
    said = "".join(
        o.text for o in by_source(made, "import numpy").outputs if o.output_type == "stream"
    )
    assert said.count("\n") == 1
    assert said.endswith("\n")
    assert "two_springs: done in" in said
    assert "left\r" in said.replace(" \r", "\r")
