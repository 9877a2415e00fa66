r"""LaTeX sources: templates, text, numbers, and tables set with booktabs.

Jinja2 has delimiters that LaTeX leaves alone: \VAR{...}, \BLOCK{...}, \#{...}, %% lines.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from longwave.derive.algebra.foreign_characters import GREEK
from longwave.reports.paper import cited

if TYPE_CHECKING:
    import jinja2

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
    import jinja2

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


DIGITS = 6
"""Most digits of a measured value that are shown."""


def table(columns: str, head: Sequence[str], rows: Iterable[Sequence[str]], gap: str = "") -> str:
    r"""Return a longtable; every cell is LaTeX, `gap` a length of extra space between rows.

    >>> print(table("lr", ["wave", "error"], [["sech", "0.1"], ["kink", "0.2"]], "1ex"))
    \begin{longtable}{lr}
    \toprule
    wave & error \\
    \midrule
    \endhead
    \bottomrule
    \endfoot
    sech & 0.1 \\ \addlinespace[1ex]
    kink & 0.2 \\
    \end{longtable}
    """
    between = rf" \addlinespace[{gap}]" if gap else ""
    shown = [r"\endhead", r"\bottomrule", r"\endfoot", f"{between}\n".join(map(row, rows))]
    return _environment("longtable", columns, head, shown)


def block(columns: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    r"""Return a centred table that is not broken; every cell is LaTeX.

    >>> print(block("lr", ["wave", "error"], [["sech", "0.1"]]))
    \begin{center}
    \begin{tabular}{lr}
    \toprule
    wave & error \\
    \midrule
    sech & 0.1 \\
    \bottomrule
    \end{tabular}
    \end{center}
    """
    shown = _environment("tabular", columns, head, [*map(row, rows), r"\bottomrule"])
    return f"\\begin{{center}}\n{shown}\n\\end{{center}}"


def _environment(name: str, columns: str, head: Sequence[str], shown: Iterable[str]) -> str:
    begin = [rf"\begin{{{name}}}{{{columns}}}", r"\toprule", row(head), r"\midrule"]
    return "\n".join([*begin, *shown, rf"\end{{{name}}}"])


def titled_rows(title: str, name: str, cells: Sequence[str] | str) -> list[list[str]]:
    """Two rows of a table with six columns: a title and the name in it, and cells or a text."""
    words = rf"{escape(title)} (\texttt{{{escape(name)}}})"
    below = rf"\multicolumn{{6}}{{L{{150mm}}}}{{{escape(cells)}}}"
    return [
        [rf"\multicolumn{{6}}{{l}}{{\rule{{0pt}}{{3ex}}{words}}}"],
        [below] if isinstance(cells, str) else list(cells),
    ]


def picture_latex(name: str, caption: str) -> str:
    """The figure that is kept under that name, with its caption in LaTeX."""
    return "\n".join(
        [
            r"\begin{figure}[htbp]",
            r"\centering",
            rf"\includegraphics{{figures/{name}.pdf}}",
            rf"\caption{{{caption}}}",
            r"\end{figure}",
        ]
    )


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


def measured(value: float, error: float) -> str:
    r"""Return a measured number with its discretisation error, rounded up to two digits.

    Not more than six digits of the value are shown. Zero without error is exact.

    >>> measured(0.101382, 0.000041), measured(2.0706e-5, 1e-12)
    ('$0.101382 \\pm 0.000041$', '$(2.07060 \\pm 0.00001)\\times 10^{-5}$')
    """
    if value == error == 0:
        return "$0$"
    if not (np.isfinite(value) and np.isfinite(error)):
        return rf"${value:g} \pm {error:g}$"
    power = int(np.floor(np.log10(max(abs(value), error))))
    scale = power if power < -3 else 0
    value, error = value / 10.0**scale, error / 10.0**scale
    most = DIGITS - 1 - (power - scale)
    places = most if error == 0 else min(1 - int(np.floor(np.log10(error))), most)
    places = max(places, 0)
    units = np.ceil(error * 10**places - 1e-6) if error else 0
    shown = max(units, float(error > 0)) / 10**places
    text = rf"{value:.{places}f} \pm {shown:.{places}f}"
    return rf"$({text})\times 10^{{{scale}}}$" if scale else f"${text}$"


def write(path: Path, text: str) -> Path:
    """Write the table to the path, making its folder; return the path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text + "\n", encoding="utf-8")
    return path


_GREEK = re.compile(rf"(?<![\\A-Za-z])(?:eps|{'|'.join(GREEK)})(?![A-Za-z])")

COMMANDS = {"dt": r"\Delta t", "<=": r"\le "}
"""Other names in the records' mathematics that LaTeX calls otherwise."""

UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, r"\textmu s"), (1e-9, "ns"))


def mathematics(text: str) -> str:
    r"""Return a record's text as LaTeX: escaped outside the dollars, commands inside.

    >>> mathematics("below 20 % at $eps = 0.05$")
    'below 20 \\% at $\\epsilon = 0.05$'
    """
    parts = text.split("$")
    parts[::2] = [escape(part) for part in parts[::2]]
    parts[1::2] = [_commands(part) for part in parts[1::2]]
    return "$".join(parts)


def _commands(text: str) -> str:
    return re.sub(r"[a-z]+|<=", lambda found: COMMANDS.get(found[0], found[0]), greek(text))


def greek(text: str) -> str:
    r"""Return mathematics with the names of Greek letters as LaTeX's commands.

    >>> greek("xi - 6 tau"), greek("eps"), greek("taut")
    ('\\xi - 6 \\tau', '\\epsilon', 'taut')
    """
    return _GREEK.sub(lambda found: "\\" + {"eps": "epsilon"}.get(found[0], found[0]), text)


def symbol_latex(name: str) -> str:
    r"""Return a symbol's name as LaTeX, digits and what is behind an underscore as its index.

    >>> symbol_latex("kappa_1"), symbol_latex("K2"), symbol_latex("eps")
    ('\\kappa_{1}', 'K_{2}', '\\epsilon')
    """
    letter, index = re.findall(r"([A-Za-z]+)_?(\w*)", name)[0]
    return greek(letter) + (f"_{{{index}}}" if index else "")


def duration(seconds: float) -> str:
    r"""Return a time with two significant digits in a unit that fits.

    >>> duration(4.4e-08), duration(0.0123), duration(120.0)
    ('44 ns', '12 ms', '120 s')
    """
    scale, unit = next((pair for pair in UNITS if seconds >= pair[0]), UNITS[-1])
    value = seconds / scale
    return f"{value:.1f} {unit}" if value < 10 else f"{float(f'{value:.2g}'):.0f} {unit}"


def domain_latex(domain: str) -> str:
    r"""Return a parameter's domain as LaTeX; its words are those of the record.

    >>> domain_latex("0 < k < 1"), domain_latex("X_0 real")
    ('$0<k<1$', '$X_{0}$ real')
    """
    words = [_domain_word(word) for word in domain.split()]
    return " ".join(words).replace("$ $", "")


def _domain_word(word: str) -> str:
    """Return one word of a domain: relations and symbols in mathematics."""
    if word in ("real", "positive"):
        return word
    named = {"<=": r"\le", "elliptic_k(k**2)": "K(k)", "2*A": "2A"}
    return f"${symbol_latex(word) if word.isidentifier() else named.get(word, word)}$"


_INDEXED = re.compile(r"\b[a-z]_(?:\w|\{[^}]*\})(?: [=+-] [a-z]_(?:\w|\{[^}]*\}))*")
"""Fields with their indices, and sums of them, in a lattice's title."""


def title_latex(title: str) -> str:
    """A lattice's title, its indexed fields in mathematics.

    >>> title_latex("the strain y_n = u_{n+1} - u_n of 50 %")
    'the strain $y_n = u_{n+1} - u_n$ of 50 \\\\%'
    """
    words = _INDEXED.split(title)
    formulas = [f"${found}$" for found in _INDEXED.findall(title)]
    pairs = zip(words, [*formulas, ""], strict=True)
    return "".join(escape(text) + formula for text, formula in pairs)
