r"""Jinja2 with delimiters that LaTeX leaves alone: \VAR{...}, \BLOCK{...}, \#{...}, %% lines."""

from pathlib import Path

import jinja2

from reports.paper import cited

TEMPLATES = Path(__file__).parent / "templates"

_ESCAPES = {
    "\\": r"\textbackslash{}",
    "&": r"\&",
    "%": r"\%",
    "$": r"\$",
    "#": r"\#",
    "_": r"\_",
    "{": r"\{",
    "}": r"\}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
}


def escape(text: object) -> str:
    r"""Return text with LaTeX's special characters made harmless.

    >>> escape("50 % of K_2")
    '50 \\% of K\\_2'
    """
    return "".join(_ESCAPES.get(character, character) for character in str(text))


def environment(directory: Path = TEMPLATES) -> jinja2.Environment:
    """Return the Jinja2 environment of the report's templates.

    The filter `e` escapes text for LaTeX; formulas pass unescaped. `cited(label)` gives the
    paper's number. An unknown name in a template is an error.
    """
    made = jinja2.Environment(
        loader=jinja2.FileSystemLoader(directory),
        block_start_string=r"\BLOCK{",
        block_end_string="}",
        variable_start_string=r"\VAR{",
        variable_end_string="}",
        comment_start_string=r"\#{",
        comment_end_string="}",
        line_comment_prefix="%%",
        trim_blocks=True,
        lstrip_blocks=True,
        autoescape=False,
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
    )
    made.filters["e"] = escape
    made.globals["cited"] = cited
    return made


def render(template: str, **content: object) -> str:
    """Return the template of that name filled with the content."""
    return environment().get_template(template).render(**content)
