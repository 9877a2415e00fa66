"""The map from a reduced equation to the normal form of its closed solutions.

``Y(X, Z, T) = h U(a (X - drift T), e Z, b T)`` turns the reduced equation into a multiple of the
normal form.  Each equation is one entry: its terms, and the scales as functions of their
coefficients.  For mKdV the map takes beta and delta = -gamma_3 of the paper's eq. (15) to a and b
of the paper's eq. (22).  If an equation keeps its form under a scaling, the simplest map is used:
h = 1 for mKdV, a = 1 for KdV, KP and NLS.
"""

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields

from sympy import Abs, Expr, S, sign, sqrt

from longwave.derive.algebra.exact_numbers import exact
from longwave.derive.algebra.formula_printing import latex_of
from longwave.derive.output.own_names import joined_powers, marked, unused
from longwave.support.known_names import one_of
from longwave.support.user_files import shown

Scales = dict[str, Expr]


@dataclass(frozen=True)
class NormalEquation:
    """An equation with known closed solutions.

    ``terms``: names of the reduced equation's terms besides Y_T and Y_X, which only makes the
    solution drift.  ``scales`` returns the scales and signs of the map from the coefficients of
    these terms, in this order.  ``text``: the equation.
    """

    name: str
    terms: tuple[str, ...]
    text: str
    scales: Callable[..., Scales]

    @property
    def latex(self) -> str:
        """The equation in LaTeX, without delimiters."""
        return re.sub(r"_(\d*)((?:xi|zeta|tau)+)", _subscript, self.text)


def _subscript(match: re.Match[str]) -> str:
    names = re.sub("(xi|zeta|tau)", r"\\\1", match[2])
    return f"_{names}" if names.count("\\") == 1 and not match[1] else f"_{{{match[1]}{names}}}"


def _kdv(quadratic: Expr, third: Expr) -> Scales:
    return {"a": S.One, "b": third, "h": 6 * third / quadratic}


def _mkdv(cubic: Expr, third: Expr) -> Scales:
    ratio = cubic / (6 * third)
    a = sqrt(Abs(ratio))
    return {"a": a, "b": third * a**3, "s": sign(ratio)}


def _gardner(cubic: Expr, quadratic: Expr, third: Expr) -> Scales:
    ratio = 6 * cubic * third
    a = Abs(quadratic) / sqrt(Abs(ratio))
    return {"a": a, "b": third * a**3, "h": sign(ratio) * quadratic / cubic, "s": sign(ratio)}


def _kawahara(quadratic: Expr, third: Expr, fifth: Expr) -> Scales:
    a = sqrt(Abs(third / fifth))
    b = -fifth * a**5
    return {"a": a, "b": b, "h": 6 * b / (quadratic * a), "s": -sign(third / fifth)}


def _modified_kawahara(cubic: Expr, third: Expr, fifth: Expr) -> Scales:
    square = Abs(third / fifth)
    a, h = sqrt(square), square * sqrt(6 * Abs(fifth / cubic))
    signs = {"s": -sign(third / fifth), "r": -sign(cubic * fifth)}
    return {"a": a, "b": -fifth * a**5, "h": h, **signs}


def _kdv_burgers(quadratic: Expr, second: Expr, third: Expr) -> Scales:
    """Return the KdV-Burgers map's scales from the coefficients of Y Y_X, Y_XX (< 0) and Y_XXX."""
    a = Abs(second / third)
    b = -second * a**2
    return {"a": a, "b": b, "h": 6 * b / (quadratic * a), "s": -sign(second * third)}


def _mkdv_burgers(cubic: Expr, second: Expr, third: Expr) -> Scales:
    a = Abs(second / third)
    b = -second * a**2
    h = sqrt(Abs(6 * b / (cubic * a)))
    return {"a": a, "b": b, "h": h, "s": -sign(second * third), "r": -sign(second * cubic)}


def _fifth_kdv(quadratic: Expr, fifth: Expr) -> Scales:
    return {"a": S.One, "b": -fifth, "h": -6 * fifth / quadratic}


def _fifth_mkdv(cubic: Expr, fifth: Expr) -> Scales:
    ratio = -6 * fifth / cubic
    return {"a": S.One, "b": -fifth, "h": sqrt(Abs(ratio)), "r": sign(ratio)}


def _kp(quadratic: Expr, third: Expr, across: Expr) -> Scales:
    e = sqrt(3 * Abs(third / across))
    return {**_kdv(quadratic, third), "e": e, "s": sign(third * across)}


def _generalised_kp(cubic: Expr, third: Expr, across: Expr) -> Scales:
    longitudinal = _mkdv(cubic, third)
    e = sqrt(3 * Abs(third / across)) * longitudinal["a"] ** 2
    return {**longitudinal, "r": longitudinal["s"], "e": e, "s": sign(third * across)}


def _nls(dispersion: Expr, cubic: Expr) -> Scales:
    ratio = 2 * dispersion / cubic
    return {"a": S.One, "b": dispersion, "h": sqrt(Abs(ratio)), "s": sign(ratio)}


_ROWS: tuple[tuple[str, str, str, Callable[..., Scales]], ...] = (
    ("KdV", "Y Y_X, Y_XXX", "U_tau + 6 U U_xi + U_xixixi", _kdv),
    ("mKdV", "Y^2 Y_X, Y_XXX", "U_tau + 6 s U^2 U_xi + U_xixixi", _mkdv),
    ("Gardner", "Y^2 Y_X, Y Y_X, Y_XXX", "U_tau + 6 U U_xi + 6 s U^2 U_xi + U_xixixi", _gardner),
    ("Kawahara", "Y Y_X, Y_XXX, Y_5X", "U_tau + 6 U U_xi + s U_xixixi - U_5xi", _kawahara),
    (
        "modified Kawahara",
        "Y^2 Y_X, Y_XXX, Y_5X",
        "U_tau + 6 r U^2 U_xi + s U_xixixi - U_5xi",
        _modified_kawahara,
    ),
    ("fifth-order KdV", "Y Y_X, Y_5X", "U_tau + 6 U U_xi - U_5xi", _fifth_kdv),
    ("fifth-order mKdV", "Y^2 Y_X, Y_5X", "U_tau + 6 r U^2 U_xi - U_5xi", _fifth_mkdv),
    ("KdV-Burgers", "Y Y_X, Y_XX, Y_XXX", "U_tau + 6 U U_xi + s U_xixixi - U_xixi", _kdv_burgers),
    (
        "mKdV-Burgers",
        "Y^2 Y_X, Y_XX, Y_XXX",
        "U_tau + 6 r U^2 U_xi + s U_xixixi - U_xixi",
        _mkdv_burgers,
    ),
    ("KP", "Y Y_X, Y_XXX, Y_ZZ", "(U_tau + 6 U U_xi + U_xixixi)_xi + 3 s U_zetazeta", _kp),
    (
        "generalised KP",
        "Y^2 Y_X, Y_XXX, Y_ZZ",
        "(U_tau + 6 r U^2 U_xi + U_xixixi)_xi + 3 s U_zetazeta",
        _generalised_kp,
    ),
    ("NLS", "A_XX, |A|^2 A", "i U_tau + U_xixi + 2 s |U|^2 U", _nls),
)
"""One row an equation: name, terms besides Y_T, left-hand side, scales from the coefficients."""

NORMAL_EQUATIONS = {
    name: NormalEquation(name, tuple(terms.split(", ")), f"{left_side} = 0", scales)
    for name, terms, left_side, scales in _ROWS
}
"""The normal forms by name."""


@dataclass(frozen=True, repr=False)
class NormalForm:
    """``Y(X, Z, T) = h U(a (X - drift T), e Z, b T)``, where U solves the ``equation``.

    ``c`` is the frame speed, ``X = eps (n - c t)``; for NLS it is the group velocity, and Y is A.
    ``s`` and ``r`` are the signs in the normal form, 1 or -1 (1 if it has none); b may be negative,
    and e is 0 without a Z.  ``equation`` is a name of `NORMAL_EQUATIONS`.

    All are exact SymPy expressions; numbers are converted.  ``digits`` is None if the values are
    exact, else the number of their correct digits.  Raises ValueError for a value that is not
    exact or real, for a number s or r other than 1 and -1, and for a scale that is 0.
    """

    a: Expr
    b: Expr
    s: Expr
    c: Expr
    equation: str = "mKdV"
    h: Expr = S.One
    e: Expr = S.Zero
    r: Expr = S.One
    drift: Expr = S.Zero
    digits: int | None = None

    def __post_init__(self) -> None:
        for name in ("a", "b", "s", "c", "h", "e", "r", "drift"):
            object.__setattr__(self, name, exact(name, getattr(self, name)))
        for name in ("s", "r"):
            value = getattr(self, name)
            if value.is_number and value not in (1, -1):
                raise ValueError(
                    f"{name} must be 1 or -1, got {shown(value)} (it is a sign in the normal form)"
                )
        if self.equation not in NORMAL_EQUATIONS:
            raise ValueError(
                f"equation must be a known one, got {shown(self.equation)} "
                f"({one_of(self.equation, NORMAL_EQUATIONS)})"
            )
        for name in ("a", "b", "h", "e")[: 4 if self.is_transverse else 3]:
            if getattr(self, name).is_zero:
                raise ValueError(f"{name} must not be 0, got 0 (the map must have an inverse)")

    @property
    def name(self) -> str:
        """The equation's name, with its signs if its waves depend on them."""
        return equation_name(self.equation, self.s, self.r)

    @property
    def is_transverse(self) -> bool:
        """Whether there is a second slow variable of space, Z."""
        return "Y_ZZ" in NORMAL_EQUATIONS[self.equation].terms

    @property
    def map_text(self) -> str:
        """The map in plain text, without terms that are trivial."""
        first_argument = "a X" if self.drift == 0 else "a (X - drift T)"
        arguments = ("Z, ", ", e Z") if self.is_transverse else ("", "")
        unknown = "A" if self.equation == "NLS" else "Y"
        factor = "" if self.h == 1 else "h "
        return f"{unknown}(X, {arguments[0]}T) = {factor}U({first_argument}{arguments[1]}, b T)"

    def lines(self, taken: Collection[str], written: Callable[[str, Expr], str]) -> Iterator[str]:
        """Yield equation, map and scales as lines of text; a tilde marks names that are ``taken``.

        ``written(name, value)`` formats a scale.
        """
        text = f"{NORMAL_EQUATIONS[self.equation].text}, {self.map_text}:"
        yield f"normal form {marked(text, ('U', 'drift', *'abehsr'), taken)}"
        for name, value in self.values.items():
            yield f"  {unused(name, taken)} = {written(name, value)}"

    @property
    def values(self) -> dict[str, Expr]:
        """Scales of the map and signs of the normal form, by name."""
        names = ["a", "b"] + ["e"] * self.is_transverse
        names += [name for name, usual in (("h", 1), ("drift", 0)) if getattr(self, name) != usual]
        names += [name for name in "sr" if f" {name} " in NORMAL_EQUATIONS[self.equation].text]
        return {name: getattr(self, name) for name in names}

    def __repr__(self) -> str:
        values = [(i.name, getattr(self, i.name), i.default) for i in fields(self)]
        texts = (f"{name}={v}" for name, v, usual in values if name in "absc" or v != usual)
        return f"NormalForm({', '.join(texts)})"

    def _repr_latex_(self) -> str:
        greek = {"drift": r"\nu"}
        map_latex = self.map_text.replace("drift", greek["drift"])
        parts = [rf"{NORMAL_EQUATIONS[self.equation].latex},\quad {map_latex}"]
        parts += (f"{greek.get(name, name)} = {latex_of(v)}" for name, v in self.values.items())
        return rf"$\displaystyle {', '.join(parts)}$"


def equation_name(name: str, s: Expr | int, r: Expr | int = 1) -> str:
    """Return an equation's name, with the signs s and r if its waves depend on them.

    >>> equation_name("mKdV", -1), equation_name("KP", -1), equation_name("Kawahara", -1)
    ('defocusing mKdV', 'KP-I', 'Kawahara (s = -1)')
    """
    if s not in (1, -1):
        return name
    if name in ("mKdV", "Gardner", "NLS"):
        return f"{'focusing' if s == 1 else 'defocusing'} {name}"
    if name.endswith("KP"):
        return f"{name}-{'I' if s == -1 else 'II'}"
    if name in ("Kawahara", "KdV-Burgers"):
        return f"{name} (s = {s})"
    return f"{name} (s = {s}, r = {r})" if name in ("modified Kawahara", "mKdV-Burgers") else name


def equation_of(terms: Iterable[str]) -> NormalEquation | None:
    """Return the normal equation with these ``terms``, ignoring Y_X; None if it is unknown."""
    term_set = {*terms} - {"Y_X"}
    return next((e for e in NORMAL_EQUATIONS.values() if {*e.terms} == term_set), None)


def normal_form_of(
    c: Expr, coefficients: Mapping[str, Expr], digits: int | None = None
) -> NormalForm:
    """Return the normal form of an equation from its coefficients; those that are 0 are ignored.

    Terms are named as in `NORMAL_EQUATIONS`.  Raises ValueError for any other equation.

    >>> from sympy import Rational
    >>> normal_form_of(S(2), {"Y^2 Y_X": Rational(3, 4), "Y_XXX": Rational(1, 12)})
    NormalForm(a=sqrt(6)/2, b=sqrt(6)/16, s=1, c=2)
    >>> normal_form_of(S(2), {"Y Y_X": S(3), "Y_XXX": S(1)})
    NormalForm(a=1, b=1, s=1, c=2, equation=KdV, h=2)
    """
    vanishes = {t: v.equals(0) if v.is_number else v.is_zero for t, v in coefficients.items()}
    terms = {term: value for term, value in coefficients.items() if not vanishes[term]}
    drift = terms.pop("Y_X", S.Zero)
    entry = equation_of(terms)
    if entry is None:
        raise ValueError(_refusal(terms, [term for term in coefficients if term not in terms]))
    scale_items = entry.scales(*(terms[term] for term in entry.terms)).items()
    scales = {"s": S.One, **{name: joined_powers(value) for name, value in scale_items}}
    return NormalForm(c=c, equation=entry.name, drift=drift, digits=digits, **scales)


def _refusal(remaining: Mapping[str, Expr], vanished: Sequence[str]) -> str:
    """Return the error message for an equation without a normal form.

    Terms in ``vanished`` have the coefficient 0; ``remaining`` maps the others to theirs.
    """
    vanished_terms = [term for term in vanished if term != "Y_X"]
    if vanished_terms:
        linear = "" if any(" " in term for term in remaining) else ", a linear equation"
        return (
            f"the coefficient of {vanished_terms[0]} must not vanish, got 0, which leaves "
            f"{', '.join(remaining) or 'nothing'}{linear} "
            f"({_REMEDY.get(vanished_terms[0], 'take other constants')})"
        )
    known = "; ".join(f"{e.name}: {', '.join(e.terms)}" for e in NORMAL_EQUATIONS.values())
    return (
        "the terms must be those of an equation with a normal form, got "
        f"{', '.join(remaining) or 'none'} ({known})"
    )


_REMEDY = {
    "Y Y_X": "a cubic force balances at the next lower power of eps",
    "Y^2 Y_X": "take a nonzero cubic stiffness",
    "Y_XXX": "a slower time eps^5 t brings in Y_5X",
    "Y_XX": "take dashpots beside springs",
    "Y_ZZ": "take springs across",
    "A_XX": "the third derivative of omega takes its place",
    "|A|^2 A": "the next nonlinear order takes its place",
}
