r"""LaTeX sources: templates, text, numbers, and tables set with booktabs.

Jinja2 has delimiters that LaTeX leaves alone: \VAR{...}, \BLOCK{...}, \#{...}, %% lines.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from longwave.derive.algebra.foreign_characters import GREEK
from longwave.reports.paper import cited

if TYPE_CHECKING:
    import jinja2

TEMPLATES = Path(__file__).parent / "templates"

_ESCAPES = {character: rf"\{character}" for character in "&%$#_{}"}
_ESCAPES |= {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}


def escape(text: object) -> str:
    r"""Return text with LaTeX's special characters escaped.

    >>> escape("50 % of K_2")
    '50 \\% of K\\_2'
    """
    return "".join(_ESCAPES.get(character, character) for character in str(text))


def environment(directory: Path = TEMPLATES) -> jinja2.Environment:
    """Return the Jinja2 environment of the report's templates.

    The filter `e` escapes text for LaTeX; formulas pass unescaped. `cited(label)` gives the
    paper's number. An unknown name in a template is an error.
    """
    import jinja2

    templates = jinja2.Environment(
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
    templates.filters["e"] = escape
    templates.globals["cited"] = cited
    return templates


def render(template: str, **content: object) -> str:
    """Return the template of that name filled with the content."""
    return environment().get_template(template).render(**content)


DASH = "--"
"""LaTeX that is printed in place of a missing number."""

MAX_DIGITS = 6
"""Largest number of digits of a measured value that are printed."""

MAX_UNBROKEN_ROWS = 8
"""Number of rows up to which a table is kept on one page."""

Row = Sequence[str] | str
"""One row of a table: its cells, or a text that is a heading across all columns."""


def table(
    name: str, caption: str, columns: str, head: Sequence[str], rows: Iterable[Row], gap: str = ""
) -> str:
    r"""Return a table with its number, caption and the label tab:name; "" without rows.

    Every cell is LaTeX, ``gap`` a length of extra space between rows. Page breaks leave no row
    alone and no heading without its rows; the head is repeated on each page.

    >>> print(table("waves", "Waves.", "lr", ["wave", "error"], [["sech", "0.1"], ["kink", "0.2"]]))
    \begin{longtable}{lr}
    \caption{Waves.}\label{tab:waves}\\
    \toprule
    wave & error \\
    \midrule
    \endfirsthead
    \multicolumn{2}{@{}l}{Table \thetable, continued}\\
    \toprule
    wave & error \\
    \midrule
    \endhead
    \bottomrule
    \endfoot
    sech & 0.1 \\*
    kink & 0.2 \\
    \end{longtable}
    """
    listed = list(rows)
    if not listed:
        return ""
    full = any(isinstance(cells, str) for cells in listed)
    if full:
        columns = rf"@{{\extracolsep{{\fill}}}}{columns}@{{}}"
    top = [r"\toprule", row(head), r"\midrule"]
    continued = rf"\multicolumn{{{len(head)}}}{{@{{}}l}}{{Table \thetable, continued}}\\"
    lines = [
        rf"\begin{{longtable}}{{{columns}}}",
        rf"\caption{{{caption}}}\label{{tab:{name}}}\\",
        *(*top, r"\endfirsthead", continued, *top, r"\endhead", r"\bottomrule", r"\endfoot"),
        *_broken(listed, len(head), gap),
        r"\end{longtable}",
    ]
    text = "\n".join(lines)
    return rf"{{\LTleft=0pt \LTright=0pt plus 1fil{chr(10)}{text}}}" if full else text


def _broken(rows: Sequence[Row], across: int, gap: str) -> Iterator[str]:
    """Yield rows of ``across`` columns in LaTeX; a star marks a row that must not end a page."""
    last = len(rows) - 1
    for index, cells in enumerate(rows):
        ends = index == last or isinstance(rows[index + 1], str)
        lone = index + 1 == last or (index + 2 <= last and isinstance(rows[index + 2], str))
        begins = index == 0 or isinstance(rows[index - 1], str)
        no_break = index < last and (
            last < MAX_UNBROKEN_ROWS or isinstance(cells, str) or (not ends and (begins or lone))
        )
        space = f"[{gap}]" if gap and index < last else ""
        text = " & ".join(cells)
        if isinstance(cells, str):
            text = heading_row(cells, across, index > 0)
        yield rf"{text} \\" + "*" * no_break + space


def heading_row(words: str, across: int, spaced: bool) -> str:
    """Return a heading across the columns that does not widen them; ``spaced`` adds space above."""
    above = r"\addlinespace " if spaced else ""
    text = rf"\parbox[t]{{\linewidth}}{{\raggedright\strut {words}\strut}}"
    return rf"{above}\multicolumn{{{across}}}{{@{{}}l@{{}}}}{{\makebox[0pt][l]{{{text}}}}}"


PRINTED = {
    "rk4": "RK4",
    "stoermer_verlet": "Störmer-Verlet (2)",
    "mclachlan_4": "McLachlan (4)",
    "blanes_moan_6": "Blanes-Moan (6)",
    "reduced_phase_6": "reduced phase lag (6)",
    "suzuki_umeno_8": "Suzuki-Umeno (8)",
    "kahan_li_8": "Kahan-Li (8)",
    "spectral": "spectral ring",
}
"""Scheme or engine -> its printed name, with the order of a splitting scheme in brackets."""


def titled(title: str, name: str, fault: str = "") -> str:
    """Return a run's heading: title, scene name and, with a ``fault``, why it did not run."""
    words = rf"{title} (\texttt{{{escape(name)}}})"
    return f"{words} did not run: {escape(fault)}" if fault else words


def picture_latex(name: str, caption: str, place: str = "htbp") -> str:
    """Return the LaTeX that includes a figure by name; with ``place`` "H" it does not float."""
    graphics = rf"\includegraphics{{figures/{name}.pdf}}"
    title = rf"\caption{{{caption}}}\label{{fig:{name}}}"
    begin, end = rf"\begin{{figure}}[{place}]", r"\end{figure}"
    return "\n".join([begin, r"\centering", graphics, title, end])


def row(cells: Sequence[str]) -> str:
    r"""Return one row: cells joined by ampersands, ended by a double backslash."""
    return " & ".join(cells) + r" \\"


def scientific(value: float, digits: int = 2) -> str:
    r"""Return the number as LaTeX with that many significant digits.

    >>> scientific(0.000123), scientific(0.0), scientific(0.1014, 4)
    ('$1.2\\times 10^{-4}$', '$0$', '$0.1014$')
    """
    if value == 0 or not np.isfinite(value):
        return "$0$" if value == 0 else rf"$\mathrm{{{value}}}$"
    mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
    if -3 <= int(exponent) < digits + 1:
        return f"${value:.{max(digits - 1 - int(exponent), 0)}f}$"
    return rf"${mantissa}\times 10^{{{int(exponent)}}}$"


def uncertain(value: float, error: float) -> tuple[str, str]:
    r"""Return a measured number and its discretisation error, for two columns.

    The error is rounded up to two digits, the number to the error's last digit, with at most six
    digits. A dash replaces an error of 0.
    >>> uncertain(0.1013819, 0.000041), uncertain(2.0706e-5, 1e-12), uncertain(5.0, 0.0)
    (('$0.101382$', '$4.1\\times 10^{-5}$'), ('$2.07060\\times 10^{-5}$', ...), ('$5$', '--'))
    """
    if error == 0:
        return f"${value:.{MAX_DIGITS}g}$", DASH
    if not (np.isfinite(value) and np.isfinite(error)):
        return scientific(value), scientific(error)
    power = int(np.floor(np.log10(max(abs(value), error))))
    scale = power if power < -3 else 0
    last = int(np.floor(np.log10(error))) - 1
    places = max(min(scale - last, MAX_DIGITS - 1 - (power - scale)), 0)
    digits_text = f"{value / 10.0**scale:.{places}f}" + (rf"\times 10^{{{scale}}}" if scale else "")
    return f"${digits_text}$", scientific(float(np.ceil(error / 10.0**last - 1e-6)) * 10.0**last)


def write(path: Path, text: str) -> Path:
    """Write the text to the path, creating its folder; return the path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text + "\n", encoding="utf-8")
    return path


_GREEK = re.compile(rf"(?<![\\A-Za-z])(?:eps|{'|'.join(GREEK)})(?![A-Za-z])")

COMMANDS = {"dt": r"\Delta t", "<=": r"\le "}
"""LaTeX of the names and signs in records that are not Greek letters."""


def mathematics(text: str) -> str:
    r"""Convert a record's text to LaTeX: escape it outside dollars, replace names (eps) inside.

    >>> mathematics("below 20 % at $eps = 0.05$")
    'below 20 \\% at $\\epsilon = 0.05$'
    """
    parts = text.split("$")
    parts[::2] = [escape(part) for part in parts[::2]]
    parts[1::2] = [_commands(part) for part in parts[1::2]]
    return "$".join(parts)


def _commands(text: str) -> str:
    return re.sub(r"[a-z]+|<=", lambda match: COMMANDS.get(match[0], match[0]), greek(text))


def greek(text: str) -> str:
    r"""Return the text with names of Greek letters replaced by LaTeX commands.

    >>> greek("xi - 6 tau"), greek("eps"), greek("taut")
    ('\\xi - 6 \\tau', '\\epsilon', 'taut')
    """
    return _GREEK.sub(lambda match: "\\" + {"eps": "epsilon"}.get(match[0], match[0]), text)


def symbol_latex(name: str) -> str:
    r"""Return a symbol's name as LaTeX, digits and text after an underscore as its index.

    >>> symbol_latex("kappa_1"), symbol_latex("K2"), symbol_latex("eps")
    ('\\kappa_{1}', 'K_{2}', '\\epsilon')
    """
    letter, index = re.findall(r"([A-Za-z]+)_?(\w*)", name)[0]
    return greek(letter) + (f"_{{{index}}}" if index else "")


def domain_latex(domain: str) -> str:
    r"""Return a parameter's domain as LaTeX; words are kept.

    >>> domain_latex("0 < k < 1"), domain_latex("X_0 real")
    ('$0<k<1$', '$X_{0}$ real')
    """
    words = [_domain_word(word) for word in domain.split()]
    return " ".join(words).replace("$ $", "")


def _domain_word(word: str) -> str:
    """Return the LaTeX of one word of a domain, in math mode if it is a relation or symbol."""
    if word in ("real", "positive"):
        return word
    named = {"<=": r"\le", "elliptic_k(k**2)": "K(k)", "2*A": "2A"}
    return f"${symbol_latex(word) if word.isidentifier() else named.get(word, word)}$"


_INDEXED = re.compile(r"\b[a-z]_(?:\w|\{[^}]*\})(?: [=+-] [a-z]_(?:\w|\{[^}]*\}))*")
"""Pattern of indexed fields such as y_n, and sums of them, in a lattice's title."""


def title_latex(title: str) -> str:
    """Return a lattice's title in LaTeX, its indexed fields in mathematics.

    >>> title_latex("the strain y_n = u_{n+1} - u_n of 50 %")
    'the strain $y_n = u_{n+1} - u_n$ of 50 \\\\%'
    """
    words = _INDEXED.split(title)
    formulas = [f"${formula}$" for formula in _INDEXED.findall(title)]
    pairs = zip(words, [*formulas, ""], strict=True)
    return "".join(escape(text) + formula for text, formula in pairs)
