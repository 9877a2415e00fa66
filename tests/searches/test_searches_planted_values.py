"""The search for values that are missed: its judge, and old faults that it finds."""

import pytest

from longwave.derive.algebra import bounded_building
from longwave.verify.proof import conditions
from longwave.verify.proof.case_tree import CaseTree
from longwave.verify.proof.restrictions import KnownSigns
from longwave.verify.proof.typed_values import TypedValues
from searches.planted_values import FINDINGS, judged
from searches.texts.mp_values import CLOSE, FAR, Residuals, holds, mp
from searches.texts.planted import MAKERS, Planted, planted

NLS = "I*u_t + u_xx + 2*abs(u)**2*u"


def test_the_judge_differentiates_signs_and_moduli() -> None:
    wave = "u = a*sech(a*(x - 4*t))*sign(exp(I*x))**2*exp(I*w*t)"
    residuals = Residuals([NLS], [wave])
    point = {"a": mp.mpf("1.3"), "x": mp.mpf("0.7"), "t": mp.mpf("0.3")}
    assert residuals.largest({**point, "w": mp.mpf("1.3") ** 2 - 4}) < CLOSE
    assert residuals.largest({**point, "w": mp.mpf("1.3") ** 2}) > FAR
    sites = Residuals(["u[n+1] - b*u[n]"], ["u[n] = (-2)**n"])
    assert sites.largest({"b": mp.mpf(-2), "n": 3}) == 0


def test_conditions_are_read() -> None:
    point = {"a": mp.mpf(2), "b": mp.mpf(-1)}
    assert holds("a*b >= 0", point) is False
    assert holds("a + 2*b = 0", point) is True
    assert holds("sqrt(b) is real", point) is False
    assert holds("x takes finitely many values up to periods", point) is None


@pytest.mark.parametrize("index", range(len(MAKERS)))
def test_no_planted_value_is_missed(index: int) -> None:
    word, reason = judged(planted(5, index))
    assert word in ("only if", "found, others not excluded", "not found, not excluded"), reason


def misread(_: object) -> bool:
    """Whether a sign is a quotient: never, as SymPy has it."""
    return False


FAULTS = {
    "signs as SymPy reads them, and no comparison": (
        ((bounded_building, "_is_complex", misread), (TypedValues, "difference", lambda *_: "")),
        Planted(
            "sign", ("u_x - 2*a*I*u",), ("u = b*sign(exp(I*x))**2",), {"a": "1"},
            parameters="a: a>0; b: b>0", bounds={"x": (-1, 1), "b": (0.5, 2)},
        ),
    ),
    "polynomials at finitely many sites": (
        ((conditions, "_doubts", lambda *_: ()),),
        Planted(
            "finite", ("u[n+1] - u[n] - 2*(2*n + 1 + (n - 1))",), ("u[n] = a*n**2",), {"a": "2"},
            domain="0<n<2", bounds={"n": (1, 1)},
        ),
    ),
    "no case of a square that vanishes": (
        ((CaseTree, "_vanishing_square", lambda *_: None),),
        Planted(
            "vanishing", ("u_xx - 2*q*(p - 1)**2*u",), ("u = exp(w*x)",), {"w": "0", "p": "1"},
            bounds={"x": (-1, 1), "q": (-2, -1)},
        ),
    ),
}  # fmt: skip
"""What was done before, and a planted value that is missed then."""


@pytest.mark.parametrize("name", FAULTS)
def test_old_faults_are_found(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    patches, given = FAULTS[name]
    assert judged(given)[0] not in FINDINGS
    for owner, attribute, fault in patches:
        monkeypatch.setattr(owner, attribute, fault)
    assert judged(given)[0] == "MISSED"


def test_a_condition_that_always_holds_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    given = Planted(
        "root", ("p*u_xx - q*u",), ("u = exp(w*x)",), {"w": "sqrt(q/p)"},
        parameters="p: p<0; q: q<0; w: w>0", bounds={"x": (-1, 1), "p": (-2, -1), "q": (-2, -1)},
    )  # fmt: skip
    assert judged(given)[0] == "only if"
    monkeypatch.setattr(KnownSigns, "implies", lambda *_: False)
    assert judged(given)[0] == "IDLE"
