"""Polynomials in constants as dictionaries of terms, and their real and imaginary parts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import sympy as sp
from flint import fmpq

from .factors import exact

Monomial = tuple[tuple[sp.Expr, int], ...]
"""Constants and their powers, in a fixed order."""

Terms = Mapping[Monomial, fmpq]
"""Polynomial in constants: coefficients by monomial."""

Relations = dict[sp.Expr, tuple[int, Terms]]
"""Algebraic constants; each has a degree n and the polynomial equal to its n-th power."""


def is_turn(constant: sp.Expr) -> bool:
    """Return whether a constant is exp of an expression that contains I."""
    return isinstance(constant, sp.exp) and constant.has(sp.I)


def real_parts(terms: Terms) -> list[Terms]:
    """Return the nonzero real and imaginary parts, with complex exponentials as cos and sin."""
    parts: tuple[dict[Monomial, fmpq], dict[Monomial, fmpq]] = {}, {}
    for monomial, c in _centred(terms).items():
        turning = [pair for pair in monomial if pair[0] is sp.I or is_turn(pair[0])]
        plain = Counter({g: n for g, n in monomial if (g, n) not in turning})
        whole = sp.expand(sp.Mul(*(_turned(g if n > 0 else 1 / g) ** abs(n) for g, n in turning)))
        for term in sp.Add.make_args(whole):
            number, rest = term.as_coeff_Mul(rational=True)
            factors = [f.as_base_exp() for f in sp.Mul.make_args(rest) if f not in (1, sp.I)]
            powers = plain + Counter({g: int(n) for g, n in factors})
            key = tuple(sorted(powers.items(), key=str))
            part = parts[1 if sp.I in sp.Mul.make_args(rest) else 0]
            part[key] = part.get(key, fmpq(0)) + c * exact(number)
    nonzero = ({key: c for key, c in part.items() if c} for part in parts)
    return [part for part in nonzero if part]


def _centred(terms: Terms) -> Terms:
    """Divide by powers of complex exponentials, so that the exponents of each are around 0."""
    turns = {g for monomial in terms for g, _ in monomial if is_turn(g)}
    middles = {}
    for g in turns:
        powers = [dict(monomial).get(g, 0) for monomial in terms]
        middles[g] = (min(powers) + max(powers)) // 2
    if not any(middles.values()):
        return terms
    centred = {}
    for monomial, c in terms.items():
        shifted = {**dict.fromkeys(turns, 0), **dict(monomial)}
        rest = ((g, n - middles.get(g, 0)) for g, n in shifted.items())
        centred[tuple(pair for pair in rest if pair[1])] = c
    return centred


def _turned(constant: sp.Expr) -> sp.Expr:
    if not is_turn(constant):
        return constant
    real, angle = constant.args[0].as_real_imag()
    return sp.exp(real) * (sp.cos(angle) + sp.I * sp.sin(angle))


def as_terms(entries: Sequence[Terms | sp.Expr], relations: Relations) -> list[Terms]:
    """Return expressions as polynomials; add the relations of new roots to ``relations``."""
    polynomials: list[Terms] = []
    for entry in entries:
        if not isinstance(entry, sp.Expr):
            polynomials.append(entry)
            continue
        above = sp.numer(sp.together(entry))
        if above.is_number:
            polynomials.append({(): fmpq(1)} if above != 0 else {})
            continue
        polynomial = sp.Poly(above)
        polynomials.append(terms_of(polynomial))
        for g in polynomial.gens:
            if g.is_Pow and g.exp.is_Rational and g.exp.p == 1 and g not in relations:
                relations[g] = (int(g.exp.q), terms_of(sp.Poly(g.base)))
    return polynomials


def terms_of(polynomial: sp.Poly) -> Terms:
    """Return the terms of a SymPy polynomial."""
    terms = {}
    for powers, c in polynomial.terms():
        pairs = zip(polynomial.gens, powers, strict=True)
        terms[tuple((g, int(n)) for g, n in pairs if n)] = exact(sp.Rational(c))
    return terms
