"""Symbols of the derivation, with the paper's names and their assumptions.

``K2`` (so that the sound speed is real), the frame speed ``c`` and the small parameter ``eps``
are positive; everything else is real.  Lattice: site ``n``, time ``t``, uniform strain ``ybar``,
wavenumber ``k`` per site.  Slow variables: ``X = eps (n - c t)``, ``T = eps^3 t``.

Lattices and scalings may declare constants of their own; their names and values are checked
here.
"""

from collections.abc import Callable, Mapping, Sequence

from sympy import Expr, Pow, Symbol, fraction, symbols, together

from longwave.derive.algebra.exact_numbers import Number, exact
from longwave.support.known_names import did_you_mean
from longwave.support.user_files import shown

K2, c, eps = symbols("K2 c eps", positive=True)
K3, K4, n, t, X, T, k, ybar, x = symbols("K3 K4 n t X T k ybar x", real=True)

RESERVED = {
    "T": "the slow time",
    "X": "the slow variable of space",
    "Y": "the wave",
    "eps": "the small parameter, longwave.derive.symbols.eps",
    "k": "the wavenumber",
    "n": "the number of a cell",
    "t": "the time",
    "x": "the stretch of a bond, longwave.derive.symbols.x",
}
"""Reserved name -> its fixed meaning in the reduction."""


def rational_function(name: str, value: Expr) -> Expr:
    """Return ``value``, exact: a rational function of symbols, and a polynomial in eps.

    Raises ValueError, naming ``name``, for anything else.

    >>> from longwave.derive.symbols import K2, K3
    >>> rational_function("speed", K3**2 / K2 + 1)
    1 + K3**2/K2
    """
    number = exact(name, value)
    numerator, denominator = fraction(together(number))
    names = number.free_symbols
    if (
        not (numerator.is_polynomial(*names) and denominator.is_polynomial(*names))
        or denominator.has(eps)
        or not all(atom.is_Rational for atom in number.atoms() - names)
        or not all(power.exp.is_Integer for power in number.atoms(Pow))
    ):
        raise ValueError(
            f"{name} must be a rational function of symbols and a polynomial in eps, got "
            f"{shown(number)} (put a symbol instead of a root, and give its value to "
            "coefficients)"
        )
    return number


def constant_value(name: str, value: Number) -> Expr:
    """Return a constant's value exactly: a number, or a formula in text, with eps if it is small.

    >>> constant_value("K3", "5*eps"), constant_value("K3", "1/3")
    (5*eps, 1/3)
    """
    from longwave.derive.algebra.formula_expression import exact_value  # the reader of formulas

    return exact_value(name, value, {str(eps): eps})


def loss_value(name: str, value: Number, known: dict[str, Symbol]) -> Expr:
    """Return a loss exactly: a number, or a formula in text, in which ``^`` is also a power.

    Names that are not ``known`` become positive constants, and are added to ``known``.

    >>> loss_value("site", "eps^3*gamma", {})
    eps**3*gamma
    """
    if not isinstance(value, str):
        return exact(name, value)
    from longwave.derive.algebra.formula_expression import read_formula
    from longwave.derive.algebra.formula_text import Vocabulary

    def constant(word: str) -> Symbol:
        return known.setdefault(word, Symbol(word, positive=True))

    words = Vocabulary({}, names={**known, str(eps): eps}, unknown_name=constant)
    return read_formula(value.replace("^", "**"), words, name)


def number_value(name: str, value: Number) -> Expr:
    """Return a constant's value without eps. Raises ValueError for a small constant."""
    number = constant_value(name, value)
    if number.has(eps):
        raise ValueError(
            f"{name} must not depend on eps here, got {shown(str(number))} (substitute "
            f"a small constant first: lattice.with_values({{{name!r}: {str(number)!r}}}))"
        )
    return number


def values_of(
    given: Mapping[str, Number],
    constants: Mapping[str, Symbol],
    lattice: str,
    value: Callable[[str, Number], Expr] = number_value,
) -> dict[Symbol, Expr]:
    """Return ``value(name, given[name])`` of each given constant, by its symbol.

    Raises ValueError, which names the ``lattice``, for a name that is not in ``constants``.
    """
    for name in given:
        if name not in constants:
            raise ValueError(
                f"constants must be among {', '.join(constants) or 'none'}, got {shown(name)} "
                f"({did_you_mean(name, constants) or f'those are the constants of {lattice}'})"
            )
    return {constants[name]: value(name, number) for name, number in given.items()}


def check_constants(constants: Sequence[Symbol], fields: Sequence[str] = ()) -> None:
    """Raise ValueError if a constant's name is reserved, or that of a field or other constant."""
    names = [str(constant) for constant in constants]
    check_names("constants", names)
    for name in names:
        if name in fields:
            raise ValueError(
                f"constants must have names other than the fields', got {name} ({name} is a field: "
                "in the force of a bond or site write x, its stretch)"
            )
        if names.count(name) > 1:
            raise ValueError(
                f"constants must have different names, got {name} twice (symbols of one name with "
                "other assumptions are other symbols: take those of longwave.derive.symbols)"
            )


def check_names(label: str, names: Sequence[str]) -> None:
    """Raise ValueError if a name is reserved; ``label`` is the message's word for the names."""
    for name in names:
        if name in RESERVED:
            raise ValueError(
                f"{label} must have names other than {', '.join(sorted(RESERVED))}, got {name} "
                f"({name} is {RESERVED[name]}: write another name, such as {name}1)"
            )


def powers_of_eps(value: Expr) -> dict[int, Expr]:
    """Return the coefficients of a polynomial in eps by their powers.

    >>> from longwave.derive.symbols import K2, K3
    >>> powers_of_eps(K2 + eps**2 * K3)
    {0: K2, 2: K3}
    """
    if not value.has(eps):
        return {0: value}
    numerator, denominator = fraction(together(value))
    terms = numerator.as_poly(eps).terms()
    return {int(power): part / denominator for (power,), part in sorted(terms)}
