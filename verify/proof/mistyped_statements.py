"""Corrections of mistyped statements, shown in the error message.

The rules for formulas are in `derive.algebra.typing_mistakes`; here are those for the parts of a
statement. A correction is shown only if it can be read without an error.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterable, Mapping, Sequence

from longwave.derive.algebra.foreign_characters import ascii_text
from longwave.derive.algebra.formula_text import FormulaError
from longwave.derive.algebra.typing_mistakes import LONGEST_CORRECTED, Spelling, corrected
from longwave.derive.algebra.typing_rules import SITE, VARIABLES

from .text_parts import WORDS

Parts = Mapping[str, Sequence[str]]
"""Texts of a statement by the names of its parts."""

LONGEST_LINE = 690
"""Most characters of an error with a correction."""

MOST_RESPELLINGS = 6
"""Most misspelled names that are corrected in one statement."""

_DOMAIN_WORDS = {
    **{word: word for word in WORDS},
    **dict.fromkeys(("R", "Reals", "reals", "Real", "float", "number"), "real"),
    **dict.fromkeys(("Z", "int", "Integers", "integers", "Integer", "whole"), "integer"),
    **dict.fromkeys(("Positive", "pos"), "positive"),
    **dict.fromkeys(("Negative", "neg"), "negative"),
    **dict.fromkeys(("Nonzero", "non-zero"), "nonzero"),
}
_IS = r"\s*(?:::|:|==|=|\bis\b|\bin\b|\belement\b)?\s*"
_COMPARED = re.compile(r"<=|>=|!=|<|>")
_NAME = re.compile(r"[A-Za-z]\w*")
_LEADING = re.compile(r"(?:let|with|for|where|assume|given)\s+")
_CALLED = re.compile(r"(?<![\w.\\])([fghFGH])\s*(?=\()")
"""Letters that stand for arbitrary functions if they are not declared."""

_DECLARED = re.compile(r"(?:^|[;,])\s*([A-Za-z]\w*)\s*(?=[:=<>]|,|;|$|\b(?:is|in)\b)")
_SIZED = re.compile(r"(?:abs\(|\|)\s*([A-Za-z]\w*)\s*[)|]\s*(<=?)\s*(\w[\w.]*)")


def corrected_error(
    error: FormulaError, given: Parts, functions: Iterable[str], read: Callable[[Parts], object]
) -> FormulaError:
    """Return the error with the corrected text, or the same error if no correction is found."""
    if sum(len(text) for texts in given.values() for text in texts) > LONGEST_CORRECTED:
        return error
    parts = _readable(_rewritten(given, {*functions}), read)
    if parts is None:
        return error
    remedy = _changes(error.name, given, parts)
    longer = FormulaError(error.name, f"{error.words}; {remedy}", error.text, error.position)
    return longer if remedy and len(str(longer)) <= LONGEST_LINE else error


def _readable(parts: Parts, read: Callable[[Parts], object]) -> Parts | None:
    """Return the parts with misspelled names corrected; None if ``read`` still rejects them."""
    for _ in range(MOST_RESPELLINGS):
        try:
            read(parts)
        except FormulaError as error:
            suggestion = re.search(r"\(did you mean (\w+)\?\)", error.words)
            if suggestion is None:
                return None
            respelled = [_respelled(text, error, suggestion[1]) for text in parts[error.name]]
            parts = {**parts, error.name: respelled}
        else:
            return parts
    return None


def _respelled(text: str, error: FormulaError, name: str) -> str:
    wrong = _NAME.match(error.text, error.position)
    if text != error.text or wrong is None:
        return text
    return text[: error.position] + name + text[wrong.end() :]


def _changes(name: str, given: Parts, parts: Parts) -> str:
    """Return the corrections in words, the part with the error first."""
    remedies = []
    for label in sorted(given, key=lambda label: label != name):
        if [*given[label]] == [*parts[label]]:
            continue
        where = "" if label == name else f"{label} "
        changed = [n for o, n in zip(given[label], parts[label], strict=True) if o != n]
        remedies += [f"write {where}'{text}'" if text else f"leave {label} out" for text in changed]
    return " and ".join(remedies)


def _rewritten(given: Parts, functions: set[str]) -> Parts:
    declared = {name for text in given["parameters"] for name in _DECLARED.findall(text)}
    unknowns = _unknowns(given, functions)
    given = {**given, "equation": [_with_case_of(unknowns, text) for text in given["equation"]]}
    formulas = " ;; ".join([*given["equation"], *given["solution"]])
    variables = [
        letter
        for letter in VARIABLES + SITE
        if re.search(rf"(?<![A-Za-z\\]){letter}(?![A-Za-z0-9])|_\{{?[a-z]*{letter}", formulas)
    ]
    indexed = {n for n in declared if re.fullmatch(r"[xyztn][1-9]\d*", n) and n[0] in variables}
    called = {*_CALLED.findall(" ".join(given["solution"]))} - declared - {*unknowns}
    spelling = Spelling(functions | called, unknowns, variables, declared - indexed - {*unknowns})
    parameters, limits = _conditions(given, spelling)
    arbitrary = [f"{name}: function" for name in sorted(called)]
    return {
        "equation": [_equation(text, spelling) for text in given["equation"]],
        "solution": [_solution(text, spelling) for text in given["solution"]],
        "parameters": ["; ".join([*filter(None, parameters), *arbitrary])],
        "domain": limits,
        "solve": [re.sub(r"[\s;,]+", ", ", text.strip()) for text in given["solve"]],
    }


def _unknowns(given: Parts, functions: set[str]) -> tuple[str, ...]:
    """Return the names on the left of solutions; without ``u =``, the names with a derivative."""
    headings = [
        match[1]
        for text in given["solution"]
        for part in re.split(r";;|\n|(?<!;);(?!;)", text)
        if (match := re.match(r"\s*\\?([A-Za-z][A-Za-z0-9]*)[^=<>]*?(?::=|==?|->|→)", part))
        and match[1] not in functions
    ]
    subscripted = re.findall(r"(?<!\w)([A-Za-z])_", "\n".join(given["equation"]))
    return tuple(dict.fromkeys(headings or subscripted))


def _with_case_of(unknowns: Sequence[str], text: str) -> str:
    """Change the case of an unknown in an equation to that of the solution."""
    for name in unknowns:
        if not re.search(rf"(?<![\w.\\]){name}(?![A-Za-z0-9])", text):
            text = re.sub(rf"(?<![\w.\\]){name.swapcase()}(?![A-Za-z0-9])", name, text)
    return text


def _equation(text: str, spelling: Spelling) -> str:
    """Return an equation with single equals signs; ``a = b = c`` becomes two equations."""
    parts = []
    for part in _corrected_parts(text, spelling):
        sides = [side.strip() for side in part.split("=")]
        pairs = [(a, b) for a, b in itertools.pairwise(sides) if a != b]
        parts += [" = ".join(pair) for pair in pairs] if len(sides) > 2 else [part]
    return " ;; ".join(parts)


def _solution(text: str, spelling: Spelling) -> str:
    parts = _corrected_parts(text, spelling)
    unknowns = list(spelling.unknowns)
    lone = len(unknowns) == 1 and len(parts) == 1 and "=" not in text
    return f"{unknowns[0]} = {parts[0]}" if lone else " ;; ".join(parts)


def _corrected_parts(text: str, spelling: Spelling) -> list[str]:
    """Return the corrected formulas of a text, which may be a list in square brackets."""
    text = re.sub(r":=|==|->|→", "=", text)
    text = re.sub(r"^\s*\[(.*)\]\s*$", r"\1", text, flags=re.DOTALL)
    lines = re.split(r"\n|\band\b", text)
    parts = [part for line in lines for part in split_outside(corrected(line, spelling), r";;|;|,")]
    return [part.strip() for part in parts if part.strip()]


def split_outside(text: str, separators: str) -> list[str]:
    """Split a text at the separators outside brackets."""
    parts, depth, start = [], 0, 0
    for match in re.finditer(rf"{separators}|[()\[\]]", text):
        if match[0] in ("(", "[", ")", "]"):
            depth += 1 if match[0] in "([" else -1
        elif depth <= 0:
            parts.append(text[start : match.start()])
            start = match.end()
    return [*parts, text[start:]]


def _conditions(given: Parts, spelling: Spelling) -> tuple[list[str], list[str]]:
    """Return the texts of parameters and domain, each condition in that of the name it limits."""
    entries, values = dict[str, list[str]](), dict[str, str]()
    for text in (*given["parameters"], *given["domain"]):
        last, waiting = "", list[str]()
        for chunk in _chunks(text):
            last = _assign(chunk, last, waiting, entries, values, spelling)
        for name in waiting:
            entries.setdefault(name, []).append("real")
    limits = [limit for name in entries if name in (*VARIABLES, SITE) for limit in entries[name]]
    order = {**dict.fromkeys(entries), **dict.fromkeys(values)}
    stated = {name: f"{name}: {', '.join(words)}" for name, words in entries.items()}
    stated |= {name: f"{name} = {value}" for name, value in values.items()}
    texts = [stated[name] for name in order if name not in (*VARIABLES, SITE)]
    limits = [limit for limit in limits if limit not in ("real", "integer")]
    return ["; ".join(texts)], ["; ".join(limits)]


def _chunks(text: str) -> list[str]:
    text = re.sub(r"=<", "<=", re.sub(r"=>", ">=", re.sub(r"<>|=/=|/=|~=", "!=", ascii_text(text))))
    text = re.sub(r"(?<![\w.,(\[])(\d+),(\d+)(?![\w.,)\]])", r"\1.\2", text)
    parts = split_outside(text, r";|\n|&&?|\band\b|,")
    return [_LEADING.sub("", part.strip()).rstrip(".") for part in parts if part.strip()]


def _assign(
    chunk: str,
    last: str,
    waiting: list[str],
    entries: dict[str, list[str]],
    values: dict[str, str],
    spelling: Spelling,
) -> str:
    """Add the condition ``chunk`` to the ``entries`` of its name; return that name.

    An unnamed condition belongs to ``last``.  ``waiting`` names share the next condition."""
    named = re.match(rf"(?:(?:real|const)\s+)?([A-Za-z]\w*){_IS}(.*)$", chunk)
    if chunk in _DOMAIN_WORDS and last:
        entries.setdefault(last, []).append(_DOMAIN_WORDS[chunk])
        return last
    if named and not named[2]:
        waiting.append(named[1])
        return named[1]
    conditions, name = [], ""
    if named and not _COMPARED.match(named[2]):
        name = corrected(named[1], spelling)
        conditions = _domain_of(name, named[2], spelling)
        if not conditions and re.match(r"[A-Za-z]\w*\s*:?=(?!=)", chunk):
            values[name] = corrected(named[2], spelling)
            return name
    if not conditions:
        text = re.sub(r"^\s*[A-Za-z]\w*\s*:\s*(?=[-+.\w(])", "", chunk)
        if named and re.match(rf"{named[1]}\s*:\s*[<>!]", chunk):
            text = f"{named[1]}{named[2]}"
        name, conditions = _inequality(text, last, spelling)
    for other in [*waiting, name]:
        entries.setdefault(other, []).extend(re.sub(rf"\b{name}\b", other, c) for c in conditions)
    waiting.clear()
    return name


def _domain_of(name: str, text: str, spelling: Spelling) -> list[str]:
    """Return the conditions after ``name:`` if they are words or an interval, else none."""
    words = text.split()
    if words and all(word in _DOMAIN_WORDS for word in words):
        kinds = dict.fromkeys(_DOMAIN_WORDS[word] for word in words)
        return [word for word in kinds if word != "real" or len(kinds) == 1]
    if text.lower() in ("nonnegative", "non-negative"):
        return [f"{name}>=0"]
    interval = re.fullmatch(r"([(\[\]])\s*([^,;]+)[,;]\s*([^,;]+)([)\]\[])", text)
    interval = interval or re.fullmatch(r"()(.*?)\s*\.\.+\s*(.*)()", text)
    if interval:
        first, low, high, final = interval.groups()
        left, right = "<=" if first == "[" else "<", "<=" if final == "]" else "<"
        return _inequality(f"{low.strip()}{left}{name}{right}{high.strip()}", name, spelling)[1]
    return []


def _inequality(text: str, last: str, spelling: Spelling) -> tuple[str, list[str]]:
    """Return the name that an inequality restricts, and its conditions."""
    if sized := _SIZED.fullmatch(text.strip()):
        other, sign, bound = sized.groups()
        text = f"-{bound}{sign}{other}{sign}{bound}"
    sides = [corrected(side, spelling) for side in _COMPARED.split(text)]
    signs = _COMPARED.findall(text)
    if not signs:
        return last, []
    if not sides[0] and last:
        sides[0] = last
    names = [s for s in sides if _NAME.fullmatch(s) and s not in ("pi", "oo", "Infinity")]
    name = last if last in names else next(iter(names), last)
    for place in (0, -1):
        if len(sides) > 1 and re.fullmatch(r"[+-]?(oo|inf|[Ii]nfinity)", sides[place]):
            del sides[place], signs[place]
    if not signs:
        return name, ["real"]
    written = sides[0] + "".join(sign + side for sign, side in zip(signs, sides[1:], strict=True))
    spaced = " " in text.strip()
    return name, [_COMPARED.sub(r" \g<0> ", written) if spaced else written]
