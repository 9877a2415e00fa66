"""What the page says, as HTML in which everything that was typed is escaped."""

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

RAISED = {ord("^"): None} | {
    ord(digit): sign for digit, sign in zip("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹", strict=True)
}


def unit(found: Comparison) -> str:
    """The unit of strains and errors, as it is read.

    >>> from types import SimpleNamespace
    >>> unit(SimpleNamespace(unit="eps^2"))
    'ε²'
    """
    return found.unit.translate(RAISED).replace("eps", "ε")


def figures_of_merit(found: Comparison) -> list[tuple[str, str, str]]:
    """The numbers of a comparison: what it is, its value, and what that means."""
    worst = int(np.nanargmax(found.errors))
    share = f"{100.0 * float(np.nanmax(found.relative)):.2g} %"
    return [
        (
            "largest difference",
            f"{found.errors[worst]:.3g} {unit(found)}",
            f"lattice less wave, at T = {found.slow_times[worst]:.3g}, t = "
            f"{found.times[worst]:.4g}",
        ),
        ("of the wave's height", share, "the largest at any time"),
        (
            "the run's own error",
            f"± {found.estimate:.2g} {unit(found)}",
            "estimated: the accuracy of the difference",
        ),
    ]


def moment(found: Comparison, frame: int) -> str:
    """What is said beside the profile at one time."""
    return (
        f"T = {found.slow_times[frame]:.4g}, t = {found.times[frame]:.6g}: difference "
        f"{found.errors[frame]:.3g} {unit(found)}"
    )


def outcome_html(found: Comparison) -> str:
    """The numbers as tiles, and in red how the run ended if it ended early."""
    tiles = "".join(
        f'<div class="tile"><div class="what">{escape(what)}</div><div class="value">'
        f'{escape(value)}</div><div class="hint">{escape(hint)}</div></div>'
        for what, value, hint in figures_of_merit(found)
    )
    ended = f'<div class="refusal">{escape(found.ended)}</div>' if found.ended else ""
    return f'{ended}<div class="tiles">{tiles}</div>'


def refusal_html(refusal: Refusal) -> str:
    """Why there is no new picture."""
    return f'<div class="refusal" role="alert">{escape(refusal.line)}</div>'


def formula_html(latex: str, plain: str) -> str:
    """A formula that the browser draws itself, or its plain text if it is not understood.

    >>> formula_html("Y_T", "Y_T")[:29], formula_html(r"\\nonsense{", "a < b")
    ('<math xmlns="http://www.w3.or', '<code>a &lt; b</code>')
    """
    from latex2mathml.converter import convert

    bare = re.sub(r"\\displaystyle|\$", "", latex).strip()
    try:
        made: str = convert(bare, display="block")
    except Exception:  # the converter raises exceptions without a common base
        return f"<code>{escape(plain)}</code>"
    return f"<code>{escape(plain)}</code>" if re.search(r"\\[a-zA-Z]", made) else made


def equation_html(found: Comparison) -> str:
    """The equation of long waves that was derived from the lattice."""
    name, _, text = found.equation.partition(": ")
    return (
        f'<div class="what">the lattice\'s {escape(name)} equation</div>'
        f"{formula_html(found.equation_latex, text)}"
    )


def wave_html(found: Comparison) -> str:
    """The closed form in the variables of its normal form, and that equation."""
    title, reference, normal_form, formula = found.wave_texts
    shown = formula_html(formula, "") if formula else "<div>its formula would fill pages</div>"
    return (
        f'<div class="what">its normal form</div>{formula_html(normal_form, "")}'
        f'<div class="what">{escape(title)} ({escape(reference)})</div>{shown}'
    )


def lines_html(found: Comparison) -> str:
    """What was done, a line each."""
    return "".join(f"<div>{escape(line)}</div>" for line in found.lines)
