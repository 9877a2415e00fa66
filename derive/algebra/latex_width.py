"""Approximate width of typeset LaTeX, and how deep its fractions are nested."""

import re

NARROW = 0.7
"""Width of a character in a sub- or superscript, relative to one on the line."""

_TOKEN = re.compile(r"\\[a-zA-Z]+|\\.|\S")


def measure(text: str) -> float:
    r"""Return the approximate width of typeset LaTeX, in characters.

    >>> measure("x + y"), measure(r"\frac{x + y}{2}"), measure(r"\mathrm{sn}^{2}")
    (4.0, 4.0, 2.7)
    """
    return round(_measure(_TOKEN.findall(text)), 6)


def nesting(text: str) -> int:
    r"""Return how deep fractions are nested in the LaTeX.

    >>> nesting("x"), nesting(r"\frac{1}{2} + \frac{x}{\frac{1}{y}}")
    (0, 2)
    """
    return _depth(_TOKEN.findall(text))


def _depth(tokens: list[str]) -> int:
    """Return how deep fractions are nested up to the end of a LaTeX group; consume its tokens."""
    deepest = 0
    while tokens:
        token = tokens.pop(0)
        if token == "}":
            break
        if token == "{":
            deepest = max(deepest, _depth(tokens))
        elif token == r"\frac":
            tokens.pop(0)
            above = _depth(tokens)
            tokens.pop(0)
            deepest = max(deepest, 1 + above, 1 + _depth(tokens))
    return deepest


def _measure(tokens: list[str]) -> float:
    """Return the width of the tokens up to the end of their LaTeX group; consume them."""
    total = 0.0
    while tokens:
        token = tokens.pop(0)
        if token == "}":
            break
        total += _width(token, tokens)
    return total


def _width(token: str, tokens: list[str]) -> float:
    """Return the width of one token, consuming its arguments."""
    if token == "{":
        return _measure(tokens)
    if token == r"\frac":
        return max(_width(tokens.pop(0), tokens), _width(tokens.pop(0), tokens))
    if token in ("^", "_"):
        return NARROW * _width(tokens.pop(0), tokens)
    if token in (r"\left", r"\right", r"\,", r"\mathrm", r"\operatorname", r"\mathcal", "&"):
        return 0.0
    if token in (r"\sqrt", "+", "-", "="):
        return 2.0
    if token in (r"\cosh", r"\sinh", r"\tanh", r"\cos", r"\sin"):
        return float(len(token))
    return 1.0
