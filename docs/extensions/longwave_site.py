"""The site's Sphinx extension: generated reference, tables, gallery and mathematics."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

import docstrings
import gallery
import library_pages
import lists
import mathml
import notebook
from house import HOUSE
from reference import write_reference

GALLERY = HOUSE / "docs" / "gallery"

CONTENTS: dict[str, Callable[[], str]] = {
    "paper-map": lists.paper_table,
    "waves": lists.waves,
    "scenes": lists.scenes,
    "observables": lists.observables,
    "schemes": lists.schemes,
    "bench-keys": lists.bench_keys,
    "kernel-rules": lists.kernel_rules,
    "published-solutions": library_pages.contents,
    "published-misprints": lists.misprints,
    "gallery": lambda: gallery.markdown(gallery.scripts(GALLERY)),
}
"""Markdown generator of each directive."""


def setup(app: Sphinx) -> dict[str, bool]:
    """Register everything. Reference and pictures are written before the pages are read."""
    mathml.setup(app)
    docstrings.setup(app)
    notebook.setup(app)
    for name in CONTENTS:
        app.add_directive(name, Generated)
    app.connect("builder-inited", _write)
    app.connect("env-before-read-docs", _read_again)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


class Generated(SphinxDirective):
    """Directive without arguments that is replaced by generated Markdown."""

    has_content: ClassVar[bool] = False

    def run(self) -> list[nodes.Node]:
        """Parse the directive's Markdown, including headings."""
        lines = StringList(CONTENTS[self.name]().splitlines(), source=self.name)
        node = nodes.Element()
        self.state.nested_parse(lines, 0, node, match_titles=True)
        return node.children


def _write(app: Sphinx) -> None:
    generated = Path(app.srcdir) / "generated"
    write_reference(generated / "reference")
    library_pages.write_pages(generated / "library")
    for script in gallery.scripts(GALLERY):
        gallery.draw(script, generated / "gallery")


def _read_again(app: Sphinx, env: Any, docnames: list[str]) -> None:
    """Add the pages with generated tables, whose sources Sphinx does not watch."""
    docnames += [
        name
        for name in ("gallery", "how-to/bench", "library", "lists", "paper-map", "trust")
        if name not in docnames
    ]
