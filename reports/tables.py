"""Tables of the report: rows of text and LaTeX set with booktabs, in one piece or across pages."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

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
    lines = [
        rf"\begin{{longtable}}{{{columns}}}",
        *_head(head),
        r"\endhead",
        r"\bottomrule",
        r"\endfoot",
        f"{between}\n".join(map(row, rows)),
        r"\end{longtable}",
    ]
    return "\n".join(lines)


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
    lines = [
        r"\begin{center}",
        rf"\begin{{tabular}}{{{columns}}}",
        *_head(head),
        *map(row, rows),
        r"\bottomrule",
        r"\end{tabular}",
        r"\end{center}",
    ]
    return "\n".join(lines)


def _head(head: Sequence[str]) -> list[str]:
    return [r"\toprule", row(head), r"\midrule"]


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
