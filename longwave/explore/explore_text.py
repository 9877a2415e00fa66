"""Texts of the explorer's page as HTML; everything typed by the user is escaped."""

from __future__ import annotations

import re
from html import escape
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from longwave.explore.exploration_run import Comparison, Refusal

INTRODUCTION = (
    "A lattice of masses and springs is started from a <b>closed-form wave</b> of its own "
    "long-wave equation. Both are followed in time, each by its own equation, and the page shows "
    "the difference. The smaller &epsilon;, the longer the waves and the smaller the difference."
)

SUPERSCRIPTS = {ord("^"): None} | {
    ord(digit): sign for digit, sign in zip("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹", strict=True)
}


def unit(comparison: Comparison) -> str:
    """Return the unit of strains and errors in readable form.

    >>> from types import SimpleNamespace
    >>> unit(SimpleNamespace(unit="eps^2"))
    'ε²'
    """
    return comparison.unit.translate(SUPERSCRIPTS).replace("eps", "ε")


def summary_numbers(comparison: Comparison) -> list[tuple[str, str, str]]:
    """Return the main numbers of a comparison: label, value and explanation of each."""
    worst = int(np.nanargmax(comparison.errors))
    T, t = comparison.slow_times[worst], comparison.times[worst]
    difference = f"{comparison.errors[worst]:.3g} {unit(comparison)}"
    percent = f"{100.0 * float(np.nanmax(comparison.relative)):.2g} %"
    own_error = f"± {comparison.estimate:.2g} {unit(comparison)}"
    return [
        ("largest difference", difference, f"lattice less wave, at T = {T:.3g}, t = {t:.4g}"),
        ("of the wave's height", percent, "the largest at any time"),
        ("the run's own error", own_error, "estimated: the accuracy of the difference"),
    ]


def frame_caption(comparison: Comparison, frame: int) -> str:
    """Return the caption of the profile at one time."""
    return (
        f"T = {comparison.slow_times[frame]:.4g}, t = {comparison.times[frame]:.6g}: difference "
        f"{comparison.errors[frame]:.3g} {unit(comparison)}"
    )


def outcome_html(comparison: Comparison) -> str:
    """Return the main numbers as tiles, preceded by the reason if the run ended early."""
    tiles = "".join(
        f'<div class="tile"><div class="what">{escape(label)}</div><div class="value">'
        f'{escape(value)}</div><div class="hint">{escape(hint)}</div></div>'
        for label, value, hint in summary_numbers(comparison)
    )
    ended = f'<div class="refusal">{escape(comparison.ended)}</div>' if comparison.ended else ""
    return f'{ended}<div class="tiles">{tiles}</div>'


def refusal_html(refusal: Refusal) -> str:
    """Return the ``refusal``'s reason why there is no new picture, as HTML."""
    return f'<div class="refusal" role="alert">{escape(refusal.line)}</div>'


def formula_html(latex: str, plain: str) -> str:
    r"""Return a formula as MathML, or as plain text if it cannot be converted.

    >>> formula_html("Y_T", "Y_T")[:29], formula_html(r"\nonsense{", "a < b")
    ('<math xmlns="http://www.w3.or', '<code>a &lt; b</code>')
    """
    from latex2mathml.converter import convert

    bare_latex = re.sub(r"\\displaystyle|\$", "", latex).strip()
    try:
        mathml: str = convert(bare_latex, display="block")
    except Exception:  # the converter raises exceptions without a common base
        return f"<code>{escape(plain)}</code>"
    return f"<code>{escape(plain)}</code>" if re.search(r"\\[a-zA-Z]", mathml) else mathml


def equation_html(comparison: Comparison) -> str:
    """Return the long-wave equation that was derived from the lattice."""
    name, _, text = comparison.equation.partition(": ")
    return (
        f'<div class="what">the lattice\'s {escape(name)} equation</div>'
        f"{formula_html(comparison.equation_latex, text)}"
    )


def wave_html(comparison: Comparison) -> str:
    """Return as HTML the closed form, in variables of its normal form, and that normal form."""
    title, reference, normal_form, formula = comparison.wave_texts
    too_long = "<div>its formula is too long to show</div>"
    formula_part = formula_html(formula, "") if formula else too_long
    return (
        f'<div class="what">its normal form</div>{formula_html(normal_form, "")}'
        f'<div class="what">{escape(title)} ({escape(reference)})</div>{formula_part}'
    )


def lines_html(comparison: Comparison) -> str:
    """Return the summary lines of the run."""
    return "".join(f"<div>{escape(line)}</div>" for line in comparison.lines)
