"""Notebooks as pages: their cells and stored outputs as Markdown."""

from __future__ import annotations

import base64
import html
import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from myst_parser.parsers.sphinx_ import MystParser

from mathml import mathml

if TYPE_CHECKING:
    from docutils import nodes
    from sphinx.application import Sphinx

_FORMULA = re.compile(r"\$(\\displaystyle [^$]*)\$")
"""Pattern of a formula within HTML, which a notebook renders with a script."""

Keep = Callable[[bytes], str]
"""Function that stores a picture and returns its address for the page."""


def setup(app: Sphinx) -> None:
    """Register files that end in .ipynb as pages."""
    app.add_source_suffix(".ipynb", "notebook")
    app.add_source_parser(NotebookParser)


class NotebookParser(MystParser):
    """Parser of notebooks, which `markdown` converts to Markdown."""

    supported: ClassVar[tuple[str, ...]] = ("notebook",)

    def parse(self, inputstring: str, document: nodes.document) -> None:
        """Parse the notebook; store its pictures next to those of the gallery."""
        environment = document.settings.env
        page = environment.docname.replace("/", "_")
        folder = Path(environment.srcdir) / "generated" / "notebooks"
        folder.mkdir(parents=True, exist_ok=True)
        names = iter(f"{page}_{number}.png" for number in range(1_000_000))

        def keep(picture: bytes) -> str:
            name = next(names)
            (folder / name).write_bytes(picture)
            return f"/generated/notebooks/{name}"

        super().parse(markdown(inputstring, keep), document)


def markdown(notebook: str, keep: Keep) -> str:
    r"""Return the notebook as Markdown.

    >>> shown = {"data": {"text/plain": "2"}}
    >>> cell = {"cell_type": "code", "source": ["1 + 1"], "outputs": [shown]}
    >>> print(markdown(json.dumps({"cells": [cell]}), keep=repr))
    ```python
    1 + 1
    ```
    <BLANKLINE>
    ```text
    2
    ```
    """
    parts: list[str] = []
    for cell in json.loads(notebook)["cells"]:
        source = _joined(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(source)
        elif cell["cell_type"] == "code" and source.strip():
            parts.append(_fenced("python", source))
            parts += (text for output in cell["outputs"] for text in _shown(output, keep))
    return "\n\n".join(parts)


def _shown(output: dict[str, Any], keep: Keep) -> Iterator[str]:
    """Yield an output in the richest form that a page can show; progress is left out."""
    if output.get("output_type") == "stream":
        if output.get("name") == "stdout":
            yield _fenced("text", _joined(output["text"]).rstrip())
        return
    forms = {kind: _joined(data) for kind, data in output.get("data", {}).items()}
    if "image/png" in forms:
        yield f"![output]({keep(base64.b64decode(forms['image/png']))})"
    elif "image/svg+xml" in forms or "text/html" in forms:
        drawn = forms.get("image/svg+xml") or forms["text/html"]
        yield _fenced("{raw} html", _FORMULA.sub(lambda m: mathml(html.unescape(m[1])), drawn))
    elif "text/latex" in forms:
        yield f"$$\n{forms['text/latex'].strip().strip('$')}\n$$"
    elif "text/plain" in forms:
        yield _fenced("text", forms["text/plain"])
    elif "traceback" in output:
        yield _fenced("text", f"{output['ename']}: {output['evalue']}")


def _fenced(kind: str, text: str) -> str:
    return f"```{kind}\n{text}\n```"


def _joined(text: str | list[str]) -> str:
    return text if isinstance(text, str) else "".join(text)
