"""The checker repeats certificates and rejects forged ones."""

import copy
import json
import random
import re
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import pytest
import sympy as sp

from longwave.solutions import CATALOGUE, closed_form
from longwave.verify.kernel import check_certificate as check_content
from longwave.verify.kernel.limits import digest
from longwave.verify.proof import (
    CertificateError,
    check_certificate,
    prove,
    prove_equal,
    prove_form,
)
from longwave.verify.proof.catalogue_proofs import form_domains
from longwave.verify.proof.certificate_writer import FUNCTIONS
from longwave.verify.verdict import Outcome, ProofVerdict
from tests.families import family

Data = dict[str, Any]
X, T = sp.symbols("X T", real=True)
Y = sp.Function("Y")(X, T)
MKDV = Y.diff(T) + 6 * Y**2 * Y.diff(X) + Y.diff(X, 3)


def plain(certificate: object) -> Data:
    return json.loads(json.dumps(certificate))


@cache
def proved(name: str) -> ProofVerdict:
    form = closed_form(name)
    return prove(form.equation, form.expression, name=name, domains=form_domains(form))


def certificate(name: str) -> Data:
    return plain(proved(name).certificate)


def redigested(data: Data) -> Data:
    return data | {"digest": digest(data)}


@pytest.mark.parametrize("name", family(CATALOGUE.of("mKdV").names, slow=("rogue_cn",)))
def test_every_certificate_is_accepted_with_its_statement(name: str) -> None:
    verdict = proved(name)
    assert verdict.outcome is Outcome.PROVED, verdict.detail
    assert verdict.assumptions
    statement = check_certificate(certificate(name))
    sign = "6" if closed_form(name).equation.s > 0 else "-6"
    unknown = "U_" if name == "soliton_background" else "U"  # U_0 would read as its derivative
    assert f"{sign}*{unknown}**2*diff({unknown}, xi)" in statement.replace("- 6", "-6")
    assert f"solution: {unknown} = " in statement


def test_the_statement_has_the_domains() -> None:
    statement = check_certificate(certificate("breather_sn"))
    assert "alpha: 0 < alpha < elliptic_k(k**2)" in statement
    assert "k: 0 < k < 1" in statement
    assert "for all real X_0, alpha, k, tau, xi with" in statement


@pytest.mark.parametrize("name", ["kink", "breather_sn", "rogue_cn"])
def test_one_digit_changed_is_rejected(name: str) -> None:
    text, draw = json.dumps(certificate(name)), random.Random(name)
    for match in draw.sample(list(re.finditer(r"[0-9]", text)), 60):
        other = draw.choice([d for d in "0123456789" if d != match.group()])
        changed = text[: match.start()] + other + text[match.end() :]
        with pytest.raises(ValueError, match=r"."):  # no JSON, or a CertificateError
            check_content(json.loads(changed))


def test_a_certificate_says_nothing_of_slopes_relations_or_images() -> None:
    """The checker derives these itself, so they cannot be forged."""
    data = certificate("rogue_cn")
    assert set(data) == {"format", "name", "statement", "proof", "digest"}
    hints = {"formulas", "generators", "values", "signs", "point", "parts"}
    assert set(data["proof"]) == hints


@pytest.mark.parametrize("place", ["0", "3/4"])
def test_y_equal_to_x_does_not_solve_mkdv(place: str) -> None:
    """Old forgeries: a T-slope that vanishes at X = 0; one that fits a digest's point at 3/4."""
    zero = prove(Y.diff(T) + Y.diff(X, 3), X).certificate
    forged = plain(zero)
    mkdv = prove(MKDV, sp.Integer(3)).certificate
    assert mkdv is not None
    forged["statement"]["equations"] = mkdv["statement"]["equations"]
    forged["proof"]["point"] = [[z, place] for z, _ in forged["proof"]["point"]]
    with pytest.raises(CertificateError, match="residual is not 0"):
        check_certificate(redigested(forged))


@pytest.mark.parametrize(
    ("equation", "message"),
    [
        ("0", "does not contain the unknown"),
        ("xi - xi", "does not contain the unknown"),
        ("V", "does not contain the unknown"),
        ("", "expected a formula"),
    ],
)
def test_an_emptied_equation_is_refused(equation: str, message: str) -> None:
    data = certificate("kink")
    data["statement"]["equations"] = [equation]
    with pytest.raises(CertificateError, match=message):
        check_certificate(redigested(data))


def test_a_renamed_form_is_refused() -> None:
    data = certificate("soliton_sech") | {"name": "rogue_cn"}
    with pytest.raises(CertificateError, match="rogue_cn is a closed form of the catalogue"):
        check_certificate(redigested(data))
    other = certificate("soliton_sech") | {"name": "mine"}
    assert "U = " in check_certificate(redigested(other))


def test_the_form_in_lab_variables_has_its_name() -> None:
    verdict = prove_form(closed_form("soliton_sech"))
    assert "for all real A, T, X, a, c" in check_certificate(plain(verdict.certificate))


def test_a_narrower_domain_has_not_the_name() -> None:
    data = certificate("kink")
    data["statement"]["domain"].append("A < 7")
    with pytest.raises(CertificateError, match="not the one stated"):
        check_certificate(redigested(data))


def forged_root(text: str) -> Data:
    """Return the certificate of u = sqrt(x**2) on x > 0, with its domain removed."""
    x = sp.Symbol("x", real=True)
    u = sp.Function("u")(x)
    verdict = prove(u.diff(x) - 1, sp.sqrt(x**2), domains={x: sp.Interval.open(0, sp.oo)})
    assert verdict.outcome is Outcome.PROVED
    data = plain(verdict.certificate)
    data["statement"]["domain"] = [] if text == "none" else data["statement"]["domain"]
    return data


def test_a_root_needs_its_domain() -> None:
    check_certificate(redigested(forged_root("kept")))
    with pytest.raises(CertificateError, match="not shown to be >= 0"):
        check_certificate(redigested(forged_root("none")))


def test_a_point_outside_the_domain_is_refused() -> None:
    data = forged_root("kept")
    data["proof"]["point"] = [[place, "-1"] for place, _ in data["proof"]["point"]]
    with pytest.raises(CertificateError, match="point is not in the domain"):
        check_certificate(redigested(data))


def test_a_formula_that_is_nowhere_defined_proves_nothing() -> None:
    x = sp.Symbol("x", real=True)
    nothing = 1 / (sp.cosh(x) ** 2 - sp.sinh(x) ** 2 - 1)
    assert prove_equal(nothing, 2 * nothing, [x]).outcome is Outcome.UNDECIDED
    good = plain(prove_equal(sp.cosh(x) ** 2, 1 + sp.sinh(x) ** 2, [x]).certificate)
    hidden = "1/(cosh(x)**2 - sinh(x)**2 - 1)"
    good["statement"] |= {"equations": [f"u - {hidden}"], "solutions": [f"u = {hidden}"]}
    with pytest.raises(CertificateError, match="denominator vanishes identically"):
        check_certificate(redigested(good))


def mutated(value: Any, draw: random.Random, count: int) -> Any:
    """Return a part of a certificate with one leaf changed, or one entry dropped or doubled."""
    if isinstance(value, list) and value:
        choice = draw.random()
        place = draw.randrange(len(value))
        if choice < 0.1:
            return value[:place] + value[place + 1 :]
        if choice < 0.2:
            return [*value, value[place]]
        return [mutated(v, draw, count) if i == place else v for i, v in enumerate(value)]
    if isinstance(value, dict) and value:
        key = draw.choice(sorted(value))
        return value | {key: mutated(value[key], draw, count)}
    if isinstance(value, int):
        return draw.choice([value + 1, value - 1, draw.randrange(count)])
    if isinstance(value, str):
        digits = list(re.finditer(r"[0-9]", value))
        if digits:
            match = draw.choice(digits)
            return value[: match.start()] + draw.choice("0123456789") + value[match.end() :]
        words = re.findall(r"[a-z_]+|[-+*/<]", value)
        other = draw.choice(["sin", "cosh", "+", "-", "*", "jacobi_cn", "<", "<=", "atom"])
        return value.replace(draw.choice(words), other, 1) if words else other
    return value


def true_statements() -> Iterator[tuple[Data, Callable[[str], bool]]]:
    """Yield certificates, each with a function that recognises its statement in words."""
    for name in ("kink", "wave_cn", "soliton_dn", "two_soliton", "breather", "breather_sn"):
        data = certificate(name) | {"name": "mine"}
        original = check_certificate(redigested(data))
        yield data, original.__eq__


def reject_forgeries(count: int) -> tuple[int, int]:
    """Mutate each certificate ``count`` times; return the numbers of accepted and all forgeries.

    A mutated hint must not change what is stated; another statement must be accepted only with
    hints that prove it, which a digit changed at random in the statement does not have.
    """
    draw, accepted, total = random.Random(8), 0, 0
    for data, is_original in true_statements():
        for _ in range(count):
            forged = copy.deepcopy(data)
            part = draw.choice(["statement", "proof"])
            forged[part] = mutated(forged[part], draw, len(data["proof"]["formulas"]))
            total += 1
            try:
                statement = check_content(redigested(forged))
            except CertificateError:
                continue
            accepted += 1
            assert is_original(statement) or is_true(forged), statement
    return accepted, total


def is_true(data: Data) -> bool:
    """Return whether balls far from the point show no error in the statement of ``data``.

    The texts are parsed by SymPy, not by the checker.
    """
    from longwave.verify.proof.balls import residual_ball

    stated = data["statement"]
    names = {name: sp.Symbol(name, real=True) for name in stated["variables"]}
    unknown = sp.Function("U_unknown")(*names.values())
    meanings: dict[str, Any] = {
        **names,
        **{f.__name__: f for f in FUNCTIONS.values() if f.__name__.startswith(("jacobi", "elli"))},
        "diff": sp.diff,
    }
    for text in stated["parameters"]:
        name, _, formula = text.partition(" = ")
        if formula and ":" not in name:
            meanings[name] = sp.sympify(formula, locals=meanings)
        else:
            symbol = sp.Symbol(name.partition(":")[0], real=True)
            meanings.setdefault(symbol.name, symbol)
    name, _, formula = stated["solutions"][0].partition(" = ")
    solution = sp.sympify(formula, locals=meanings)
    residual = sp.sympify(stated["equations"][0], locals=meanings | {name: unknown})
    real = {s: sp.Symbol(s.name, real=True) for s in residual.free_symbols | solution.free_symbols}
    residual, solution = residual.xreplace(real), solution.xreplace(real)
    given = {data["proof"]["formulas"][p]: sp.Rational(v) for p, v in data["proof"]["point"]}
    for step in ("1/1009", "-1/2003", "1/347"):
        point = {s: given.get(s.name, sp.S.One) * (1 + sp.Rational(step)) for s in real.values()}
        if not residual_ball(residual, unknown, solution, point, 200).contains(0):
            return False
    return True


@pytest.mark.slow
def test_forged_certificates_are_rejected() -> None:
    accepted, total = reject_forgeries(6)
    assert accepted < total / 2


@pytest.mark.slow
def test_many_forged_certificates_are_rejected() -> None:
    accepted, total = reject_forgeries(60)
    assert accepted < total / 2
