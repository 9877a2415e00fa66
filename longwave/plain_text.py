"""Text of a user or a file, made fit to be drawn or printed as what it is."""

import textwrap

WIDTH, MOST = 90, 270
"""Characters in a line of a figure's title, and most of them altogether."""


def plain_text(text: str) -> str:
    r"""The text in lines of a title's width, long texts cut, control characters shown as U+FFFD.

    >>> plain_text("  a\x1b[1m \n title $x_")
    'a�[1m title $x_'
    """
    shown = "".join(sign if sign.isprintable() else "\ufffd" for sign in " ".join(text.split()))
    return textwrap.fill(textwrap.shorten(shown, MOST, placeholder=" ..."), WIDTH)
