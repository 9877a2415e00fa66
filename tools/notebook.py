"""Run the notebook of the documentation and keep what its cells show: ``python tools/notebook.py``.

The site shows the outputs that are in the file; a test runs the cells again and compares.
"""

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient

HOUSE = Path(__file__).parents[1]
NOTEBOOK = HOUSE / "docs" / "how-to" / "notebook.ipynb"

PATIENCE = 600
"""Seconds of a cell."""


def executed(path: Path = NOTEBOOK) -> Any:
    """Return the notebook, run in a folder of its own, with its present outputs."""
    notebook = nbformat.read(path, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        environment = {
            "PYTHONPATH": str(HOUSE),
            "PYTHONSAFEPATH": "1",
            "IPYTHONDIR": f"{folder}/ipython",
        }
        NotebookClient(
            notebook,
            timeout=PATIENCE,
            kernel_name="python3",
            resources={"metadata": {"path": folder}},
        ).execute(env=os.environ | environment)
    return notebook


def code_cells(notebook: Any) -> Iterator[Any]:
    """Yield the cells that are run."""
    return (cell for cell in notebook.cells if cell.cell_type == "code")


def output_kinds(cell: Any) -> set[str]:
    """Return the kinds of a cell's outputs, without messages on the way."""
    return {kind for output in cell.outputs for kind in output.get("data", {})}


def main() -> None:
    """Write the notebook with its outputs, without times, and without what was told on the way."""
    notebook = executed()
    for cell in code_cells(notebook):
        cell.metadata.pop("execution", None)
        cell.outputs = [output for output in cell.outputs if output.output_type != "stream"]
    nbformat.write(notebook, NOTEBOOK)


if __name__ == "__main__":
    main()
