"""Tables of HTML, as notebooks show objects."""

from collections.abc import Iterable, Sequence
from html import escape

LEFT = 'style="text-align: left"'
"""Of a cell; the rest is the notebook's."""


def html_table(title: str, rows: Iterable[Sequence[str]], heads: Sequence[str] = ()) -> str:
    """A table with a caption, and heads of its columns if there are any.

    Texts are shown as they stand; formulas between dollar signs are set by the notebook.

    >>> print(html_table("a < b", [("eps", "< 0.1")]))
    <table><caption style="text-align: left"><b>a &lt; b</b></caption>
    <tr><td style="text-align: left">eps</td><td style="text-align: left">&lt; 0.1</td></tr>
    </table>
    """

    def line(texts: Sequence[str], tag: str = "td") -> str:
        cells = (f"<{tag} {LEFT}>{escape(text, quote=False)}</{tag}>" for text in texts)
        return f"<tr>{''.join(cells)}</tr>"

    lines = [f"<table><caption {LEFT}><b>{escape(title, quote=False)}</b></caption>"]
    lines += [line(heads, "th")] if heads else []
    return "\n".join([*lines, *map(line, rows), "</table>"])
