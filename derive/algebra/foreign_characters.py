"""Non-ASCII characters and their replacements in the text of a formula."""

from __future__ import annotations

import re
import unicodedata

GREEK = (
    *("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa"),
    *("lambda", "mu", "nu", "xi", "omicron", "pi", "rho", "sigma", "tau", "upsilon"),
    *("phi", "chi", "psi", "omega"),
)

_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻⁽⁾ⁿˣᵗ", "0123456789+-()nxt")
_SUBSCRIPTS = str.maketrans("₀₁₂₃₄₅₆₇₈₉₊₋ₓₜₙ", "0123456789+-xtn")

_SIGNS = (
    {
        **dict.fromkeys("·⋅∙×∗⁎•✕", "*"),
        **dict.fromkeys("÷∕⁄", "/"),
        **dict.fromkeys("−–—‐‑﹣", "-"),
        **dict.fromkeys("≤⩽≦", "<="),
        **dict.fromkeys("≥⩾≧", ">="),
        **dict.fromkeys("′’‘ʹ", "'"),
        **dict.fromkeys("″", "''"),
        **dict.fromkeys("“”„«»", '"'),
        **dict.fromkeys("∣∥‖", "|"),
        **dict.fromkeys("\u200b\u200c\u200d\ufeff\u00ad\u2061", ""),
        **dict.fromkeys("\u2062\u00a0\u2009\u202f", " "),
        **dict.fromkeys("≡≔→", "="),
    }
    | {"≠": "!=", "√": " sqrt ", "∞": " oo ", "∂": "\\partial ", "⟨": "(", "⟩": ")"}
    | {"½": "(1/2)", "¼": "(1/4)", "¾": "(3/4)", "⅓": "(1/3)", "⅔": "(2/3)"}
    | {"∈": " in ", "ℝ": " real ", "∧": " and ", "ⅈ": " I ", "ⅇ": " e ", "ℏ": " hbar "}
    | {"ϵ": " epsilon ", "ϕ": " phi ", "ϑ": " theta ", "ϱ": " rho "}
    # Cyrillic letters that look Latin
    | dict(zip("асеорхуікАВСЕНКМОРТХ", "aceopxyikABCEHKMOPTX", strict=True))
)

_MARKS = {"\u0304": "_bar ", "\u0305": "_bar ", "\u0307": "_t ", "\u0308": "_tt "}
"""Combining bar or dots over a letter -> their spelling; each dot is a time derivative."""


def ascii_text(text: str) -> str:
    """Return the text with powers, indices, Greek letters and known signs spelled in ASCII.

    >>> ascii_text("2·κ² sech(κ·(x − 4κ²t))²")
    '2*kappa**2 sech(kappa*(x - 4 kappa**2t))**2'
    """
    if text.isascii():
        return text
    text = re.sub("[⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻⁽⁾ⁿˣᵗ]+", lambda m: _power(m[0].translate(_SUPERSCRIPTS)), text)
    text = re.sub("[₀-₉₊₋ₓₜₙ]+", lambda m: _index(m[0].translate(_SUBSCRIPTS)), text)
    text = "".join(_SIGNS.get(c, c) for c in text)
    text = "".join(_SIGNS.get(c, c) for c in unicodedata.normalize("NFKC", text))
    text = re.sub("[\u0391-\u03c9]", _letter, text)
    return "".join(_MARKS.get(c, c) for c in unicodedata.normalize("NFD", text))


def _power(exponent: str) -> str:
    return f"**{exponent}" if exponent.isdigit() or exponent.isalpha() else f"**({exponent})"


def _index(index: str) -> str:
    return f"{index} " if index.isdigit() else f"_{{{index}}}"


def _letter(match: re.Match[str]) -> str:
    """Return the name of a Greek letter, separated by spaces from adjacent letters and digits."""
    words = unicodedata.name(match[0], "none").lower().split()
    name = {"lamda": "lambda"}.get(words[-1], words[-1])
    if name not in GREEK:
        return match[0]
    before, after = match.string[: match.start()][-1:], match.string[match.end() :][:1]
    left, right = " " * before.isalnum(), " " * after.isalpha()
    return f"{left}{name.capitalize() if 'capital' in words else name}{right}"
