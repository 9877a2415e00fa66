"""Certificates of statements that are false by balls: forged, and changed from true ones."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from random import Random
from typing import Any

from flint import fmpq

from longwave.solutions.catalogue import CATALOGUE
from longwave.verify.kernel.limits import digest
from longwave.verify.proof.catalogue_proofs import prove_form
from longwave.verify.proof.statement_verdict import decide_statement
from longwave.verify.proof.text_prover import prove
from longwave.verify.published import published
from searches.forged_proofs import Data, Proof, signed
from searches.random_texts import ONE_PLACE, RandomText, condition, points
from searches.text_balls import CannotJudge, TextBalls, words

Texts = Mapping[str, Sequence[str]]

LONGEST = 5_000
"""Characters of a certificate that is changed; the longest take seconds."""

SEEN = 2
"""Points at which an equation must fail: more than an isolated jump."""

PROVED = [
    ("u_t + 6*u*u_x + u_xxx", "u = 2*k**2*sech(k*(x - 4*k**2*t))**2", "k: k>0", ""),
    ("I*u_t + u_xx + 2*abs(u)**2*u", "u = a*sech(a*x)*exp(I*a**2*t)", "a: a>0", ""),
    ("sqrt(u**2) - u", "u = exp(I*x)", "", "-1 < x < 1"),
    ("u - abs(x)*sign(x)", "u = x", "", ""),
    ("u - v", "u = sqrt(x**2*k) ;; v = x*sqrt(k)", "k: k>0", "x > 0"),
    ("u - v", "u = log(x**2*y) ;; v = 2*log(x) + log(y)", "", "x > 0, y > 0"),
    ("u - v", "u = log(exp(I*x)) ;; v = I*x", "", "-1 < x < 1"),
    ("u - v", "u = acos(cos(x)) ;; v = x", "", "0 < x < 3"),
    ("u - v", "u = sqrt(1 - jacobi_cn(x, m)**2 - (1 - m)*jacobi_sn(x, m)**2)"
     " ;; v = sqrt(m)*abs(jacobi_sn(x, m))", "m: 0<m<1", ""),
    ("u[n+1] + 2*u[n]", "u = (-2)**n", "", ""),
    ("u[n+1]*u[n-1] - u[n]**2", "u = (-1)**n*exp(a*n)", "", ""),
    ("u - v", "u = conjugate((x + I*k)**2) ;; v = (x - I*k)**2", "", ""),
    ("u - v", "u = cos(pi/6)*x ;; v = sqrt(3)*x/2", "", ""),
]  # fmt: skip
"""Statements of many rules, beside the catalogue's and the library's."""


@cache
def true_certificates(whole: bool) -> list[Data]:
    """Return certificates of the catalogue and of library statements, those that are not long."""
    found: list[Mapping[str, Any]] = []
    for equation, solution, parameters, domain in PROVED:
        verdict = prove(equation, solution, parameters=parameters, domain=domain)
        found += getattr(verdict, "certificates", ())
    if whole:
        found += [v.certificate for v in map(prove_form, CATALOGUE) if v.certificate is not None]
        found += library_certificates()
    texts = (json.dumps(data) for data in found)
    return [json.loads(text) for text in texts if len(text) < LONGEST]


def shown_false(rng: Random, texts: Texts) -> bool:
    """Return whether an equation fails at two points of the domain at least."""
    balls, failures = TextBalls(texts), 0
    for point in points(rng, texts, 4):
        for text in texts["equations"]:
            try:
                failures += not balls.value(text, point).contains(0)
                break
            except (CannotJudge, LookupError, ValueError, TypeError, AttributeError):
                continue
        if failures >= SEEN:
            return True
    return False


def library_certificates() -> list[Mapping[str, Any]]:
    """Return every sixteenth statement of the library."""
    found: list[Mapping[str, Any]] = []
    for text in published()[::16]:
        found += decide_statement(text.problem().statement).certificates
    return found


SWAPS = (
    *(
        ("sech", "tanh"),
        ("tanh", "coth"),
        ("sin", "cos"),
        ("jacobi_sn", "jacobi_cn"),
        ("log", "exp"),
    ),
    *(("jacobi_cn", "jacobi_dn"), ("+", "-"), ("-", "+"), ("*", "/"), ("re", "im"), ("abs", "re")),
    *(("conjugate", "abs"), ("sign", "abs"), ("I", "1"), ("<", ">"), ("x", "t"), ("exp", "cosh")),
    *(
        ("abs", "sign"),
        ("/", "*"),
        ("conjugate", "re"),
        ("n", "(n+1)"),
        ("sqrt", "log"),
        ("log", "exp"),
    ),
)


def changed_text(rng: Random, text: str) -> str:
    """Return a text with one word changed: a number, a sign, a function, a letter."""
    found = list(words(text))
    place = rng.randrange(len(found))
    word, others = found[place], [b for a, b in SWAPS if a == found[place]]
    if word.isdigit() and found[place - 1] != "#":
        found[place] = str(max(0, int(word) + rng.choice((-2, -1, 1, 2))))
    elif others:
        found[place] = rng.choice(others)
    elif word[0].isalpha() and rng.random() < 0.3:
        found[place] = f"(-{word})"
    return "".join(f" {w} " if w in "+-<>=" else w for w in found).replace("# ", "#")


def changed(rng: Random, data: Data) -> Data:
    """Return a certificate with its statement or its hints changed, or both alike."""
    found = copy.deepcopy(data)
    texts, proof = found["statement"], found["proof"]
    part = rng.choice([p for p in ("equations", "solutions", "solutions", "parameters", "domain")
                       if texts[p]])  # fmt: skip
    place = rng.randrange(len(texts[part]))
    before = texts[part][place]
    if part in ("parameters", "domain") and rng.random() < 0.5:
        texts[part].pop(place)
    else:
        texts[part][place] = changed_text(rng, before)
    if rng.random() < 0.4:
        swap = rng.choice(SWAPS)
        for each in (texts["solutions"], texts["equations"], proof["formulas"]):
            each[:] = ["".join(swap[1] if w == swap[0] else f" {w} " if w in "+-" else w
                               for w in words(text)) for text in each]  # fmt: skip
    for _ in range(rng.choice((0, 1, 1, 3))):
        change_hint(rng, proof)
    return found | {"digest": digest(found)}


def change_hint(rng: Random, proof: Data) -> None:
    """Change a hint: edit it, remove it, swap it with another, or copy another one."""
    part = rng.choice([p for p in proof if proof[p]])
    entries = proof[part]
    one, other = rng.randrange(len(entries)), rng.randrange(len(entries))
    kind = rng.random()
    if part == "formulas":
        entries[one] = changed_text(rng, entries[one])
    elif kind < 0.25:
        entries.pop(one)
    elif kind < 0.5:
        entries[one], entries[other] = entries[other], entries[one]
    elif kind < 0.7 and part == "point":
        entries[one][1] = rng.choice(("0", "1", "-1", "1/3", "2", "-7/2"))
    elif isinstance(entries[one][-1], int):
        entries[one][-1] = rng.randrange(len(proof["formulas"]))


PAIRS = {
    "({f}**2)**(1/2)": ("{f}", "-1*{f}", "abs({f})", "(-1)*abs({f})", "I*{f}"),
    "((-1)*{f}**2)**(1/2)": ("I*{f}", "(-1)*I*{f}", "I*abs({f})"),
    "({f}**3)**(1/3)": ("{f}", "-1*{f}"),
    "({f}*{g})**(1/2)": ("{f}**(1/2)*{g}**(1/2)", "(-1)*{f}**(1/2)*{g}**(1/2)"),
    "abs({f})": ("{f}", "-1*{f}", "sign({f})*{f}", "({f}**2)**(1/2)", "re({f})"),
    "abs({f}*{g})": ("{f}*{g}", "{f}*abs({g})", "abs({f})*abs({g})*(-1)**n"),
    "sign({f})": ("1", "(-1)", "{f}/abs({f})", "sign({f})**3*(-1)"),
    "sign({f})**2": ("1", "(-1)", "sign({f})"),
    "log({f}*{g})": ("log({f}) + log({g})", "log(-1*{f}) + log(-1*{g})"),
    "log({f}**2)": ("2*log({f})", "2*log(-1*{f})"),
    "log(exp({f}))": ("{f}", "-1*{f}"),
    "log(exp(I*{f}))": ("I*{f}", "(-1)*I*{f}"),
    "atan(tan({f}))": ("{f}", "-1*{f}"),
    "asin(sin({f}))": ("{f}", "pi - {f}"),
    "acos(cos({f}))": ("{f}", "-1*{f}"),
    "acosh(cosh({f}))": ("{f}", "-1*{f}"),
    "atan({f}) + atan(1/{f})": ("pi/2", "(-1)*pi/2"),
    "conjugate({f}**(1/2))": ("{f}**(1/2)", "(-1)*{f}**(1/2)"),
    "4**(1/2)*{f}": ("2*{f}", "(-2)*{f}", "2*(-1)**(2 - 1)*{f}", "2*(-1)**3*{f}", "2*(-1)**n*{f}"),
    "4**(1/2)": ("2", "-2", "2*(-1)**(2 - 1)", "2*(-1)**3", "2*(-1)**n"),
    "{f} + 1": ("{f} + 2", "{f} + 0", "{f}", "2*{f} + 1"),
    "(-1)**(n + 1)*{f}": ("(-1)**n*{f}", "{f}", "-1*{f}", "cos(pi*n)*{f}"),
    "(-2)**n": ("2**n", "(-1)**n*2**n", "(-1)*2**n*(-1)**n"),
    "{f}": ("{f} + 1", "{g}", "{f}*{g}/{g} + 1", "-1*{f}", "2*{f}"),
    "(1 - jacobi_sn({f}, 1/2)**2)**(1/2)": ("jacobi_cn({f}, 1/2)", "(-1)*jacobi_cn({f}, 1/2)"),
    "(1 - 1/2*jacobi_sn({f}, 1/2)**2)**(1/2)": ("jacobi_dn({f}, 1/2)", "(-1)*jacobi_dn({f}, 1/2)"),
    "exp({f} + {g})": ("exp({f})*exp({g})", "exp({f})/exp({g})"),
}
"""Formulas, and what a forged hint says that they are: mostly on some domains."""

GAPS = (
    *("(abs({f}) - {f})", "(({f}**2)**(1/2) + {f})", "(1 - (-1)**n)", "(1 + (-1)**(2 - 1))"),
    *("(sign({f}) - 1)", "cos(pi*n/2)", "(abs({f}) + (-1)**n*{f})", "(log({f}**2) - 2*log({f}))"),
)
"""Denominators that vanish on a part of the domain."""


def forged(rng: Random) -> Data:
    """Return a statement that a formula equals a hint, with all hints that could support it."""
    draft = RandomText(rng, ["x", "x", "n", "k", "I", "y"], (*ONE_PLACE[:12], "jacobi"))
    f, g = (f"({draft.formula(rng.choice((0, 0, 1, 2)))})" for _ in range(2))
    pattern = rng.choice(list(PAIRS))
    left, value = (p.format(f=f, g=g) for p in (pattern, rng.choice(PAIRS[pattern])))
    gap = rng.choice(GAPS).format(f=f)
    size = rng.choice(
        (f"abs({f})", f"({f}**2)**(1/2)", f"{f}", f"{f}**2/{f}", f"{g}", f"1 + {f}**2")
    )
    texts = {
        "variables": ["x", "n"],
        "parameters": ["k: 0 < k < 1", rng.choice(("y: real", "y: complex", "y: y < 0"))],
        "domain": [condition(rng, ["x", "n", "y"]) for _ in range(rng.choice((0, 1, 1, 2)))],
        "equations": [f"u - ({value})"],
        "solutions": [f"u = {left}"],
    }
    signs = {value: rng.choice((size, f"{size}*{gap}**2/{gap}**2")), f: rng.choice((size, g))}
    atoms = ["I", "x", "n", "k", "y", "pi", "(-1)**n", f"abs({f})", f"{f}**(1/2)", f"{g}**(1/2)"]
    atoms += [f"abs({g})", f"exp({f})", f"exp(I*{f})", f"log({f})", f"log({g})", f"exp({g})"]
    atoms += [f"jacobi_{name}({f}, 1/2)" for name in ("sn", "cn", "dn")]
    used = [atom for atom in atoms[6:] if atom in f"{left} {value} {signs}" or rng.random() < 0.05]
    rng.shuffle(used)
    inside = next(points(rng, texts, 1), None) or {}
    point = {k: str(v) for k, v in inside.items() if isinstance(v, fmpq)}
    point |= dict.fromkeys({"x", "n", "k", "y"} - point.keys(), rng.choice(("1", "1/2", "-1/3")))
    if rng.random() < 0.1:
        point["n"] = "1/3"
    proof = Proof()
    whole, part = proof.place("1"), proof.place(value)
    more: list[Any] = [["part", 0]] if rng.random() < 0.3 else []
    same = proof.data(atoms[:6] + used, point)
    logs = {f"log({f}*{g})": {f: "1", g: "1"}, f"log({f}**2)": {f: "2"}}
    logs |= {f"log(exp({f}))": {f"exp({f})": "1"}, f"log(exp(I*{f}))": {f"exp(I*{f})": "1"}}
    data = proof.data(
        [*atoms[:6], *used, *([rng.choice(("2", "0"))] if more else [])],
        point,
        more=more,
        parts=[[whole, whole, same], [part, part, same]][: 1 + rng.randrange(2)] if more else [],
        values={left: value, f"abs({f})": rng.choice((f, f"-1*{f}")), f"{f}**(1/2)": g},
        signs=signs,
        sums={f"exp({f} + {g})": {f: "1", g: rng.choice(("1", "-1"))}},
        logs=logs,
    )
    if rng.random() < 0.5:
        data["values"] = data["values"][:1]
    return signed(texts, proof, data)


def void(rng: Random) -> Data:
    """Return a statement of nothing: no integer lies in the domain, or no number does."""
    low = rng.randint(-5, 5)
    domain, value = rng.choice(
        (([f"{low} < n < {low + 1}"], f"{3 * low + 1}/3"), ([f"n > {low}", f"n < {low}"], f"{low}"),
         ([f"{low} < x", f"x < {low}"], "1"), ([f"x**2 < {-abs(low)}"], "1"))
    )  # fmt: skip
    proof = Proof()
    texts = {"variables": ["n", "x"], "domain": domain, "equations": [f"u - {rng.randint(1, 9)}*n"]}
    texts["solutions"] = ["u = n"] if rng.random() < 0.5 else ["u = x"]
    return signed(texts, proof, proof.data(["x", "n"], {"n": value, "x": str(low)}))


def false_certificates(rng: Random, whole: bool = True) -> Iterator[tuple[str, Data]]:
    """Yield a few certificates of false statements, each with its kind."""
    yield "void", void(rng)
    for kind in ("forged", "forged", "forged", "changed", "changed"):
        true = rng.choice(true_certificates(whole and rng.random() < 0.15))
        make = forged(rng) if kind == "forged" else changed(rng, true)
        try:
            if shown_false(rng, make["statement"]):
                yield kind, make
        except (LookupError, ValueError, TypeError):
            continue
