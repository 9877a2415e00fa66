"""HTML tables for objects in notebooks."""

from collections.abc import Iterable, Sequence
from html import escape

CELL_STYLE = 'style="text-align: left"'
"""Style of all cells; the notebook determines the rest."""


def html_table(title: str, rows: Iterable[Sequence[str]], heads: Sequence[str] = ()) -> str:
    """Return a table with a caption, and column heads if given.

    Texts are shown literally; formulas between dollar signs are typeset by the notebook.

    >>> print(html_table("a < b", [("eps", "< 0.1")]))
    <table><caption style="text-align: left"><b>a &lt; b</b></caption>
    <tr><td style="text-align: left">eps</td><td style="text-align: left">&lt; 0.1</td></tr>
    </table>
    """

    def line(texts: Sequence[str], tag: str = "td") -> str:
        cells = (f"<{tag} {CELL_STYLE}>{escape(text, quote=False)}</{tag}>" for text in texts)
        return f"<tr>{''.join(cells)}</tr>"

    lines = [f"<table><caption {CELL_STYLE}><b>{escape(title, quote=False)}</b></caption>"]
    lines += [line(heads, "th")] if heads else []
    return "\n".join([*lines, *map(line, rows), "</table>"])
