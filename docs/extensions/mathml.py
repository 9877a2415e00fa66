"""Mathematics as MathML, which browsers draw themselves: no script, no network, errors at build."""

import re

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

_LEFT_OVER = re.compile(r"\\[a-zA-Z]+|&(?!#?\w+;)")
"""LaTeX that the converter did not understand and left as text: commands and column marks."""


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer under the name `mathml`."""
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def mathml(latex: str, display: str = "inline") -> str:
    r"""Return the formula as MathML; `display` is "inline" or "block".

    Raises ValueError for LaTeX that the converter does not know.

    >>> mathml(r"\frac{c}{24}")[-82:]
    '<mrow><mfrac><mrow><mi>c</mi></mrow><mrow><mn>24</mn></mrow></mfrac></mrow></math>'
    """
    try:
        made = convert(latex.replace("{aligned}", "{align*}"), display=display)
    except Exception as error:  # the converter raises exceptions without a common base
        raise ValueError(_message(latex, type(error).__name__)) from None
    left = _LEFT_OVER.search(made)
    if left:
        raise ValueError(_message(latex, left[0]))
    return made


def _message(latex: str, cause: str) -> str:
    return f"formula must be LaTeX that becomes MathML, got {latex!r} (not understood: {cause})"


def _inline(translator: HTML5Translator, node: nodes.math) -> None:
    translator.body.append(mathml(node.astext()))
    raise nodes.SkipNode


def _display(translator: HTML5Translator, node: nodes.math_block) -> None:
    translator.body.append(f'<div class="formula">{mathml(node.astext(), "block")}</div>')
    raise nodes.SkipNode
