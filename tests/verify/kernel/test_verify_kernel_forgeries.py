"""Forged certificates that the kernel once accepted."""

import pytest

from benchmarks.forged_proofs import Data, Proof, certificate, signed
from verify.kernel import CertificateError, check_certificate


def refused(data: Data, message: str) -> None:
    with pytest.raises(CertificateError, match=message):
        check_certificate(data)


def test_one_number_does_not_stand_for_another() -> None:
    """After a part 1 = 1 every number was known as a function of equal arguments, of none."""
    proof = Proof()
    one = proof.place("1")
    same = proof.data(["x"], {"x": "1"})
    data = proof.data(["x", "2"], {"x": "1"}, parts=[[one, one, same]], more=[["part", 0]])
    statement = {"equations": ["u - v"], "solutions": ["u = 1", "v = 2"]}
    refused(signed(statement, proof, data), "number is no generator")


@pytest.mark.parametrize("real", ["re", "abs"])
def test_a_tanh_of_complex_argument_has_poles(real: str) -> None:
    """tanh(x + i pi/2) is coth x, so that 1/(1 + coth(x)**2) is 0 at 0, and its root has a kink."""
    odd, even = "(exp(x) - exp(-x))", "(exp(2*x) + exp(-2*x))"
    radicand = f"({odd}**2/(2*{even}))"
    v, w, root = f"(2*{even})**(1/2)", f"{radicand}**(1/2)", f"({odd}**2)**(1/2)"
    gap = f"({v}*{w} - {odd})"
    hints = {
        "values": {root: f"-1*{odd}"},
        "signs": {
            f"-1*{odd}": f"{v}*{w}*{gap}**2/{gap}**2",
            radicand: f"1/(1 + {real}(tanh(x + I*pi/2))**2)",
        },
        "sums": {
            "exp(2*x)": {"x": "2"},
            "exp(-x)": {"x": "-1"},
            "exp(-2*x)": {"x": "-2"},
            "exp(x + I*pi/2)": {"x": "1", "I*pi": "1/2"},
            "exp(x - I*pi/2)": {"x": "1", "I*pi": "-1/2"},
        },
    }
    atoms = ["x", "I", "pi", "exp(x)", v, w]
    data = certificate(f"u + {odd}", f"u = {root}", atoms, {"x": "-1"}, **hints)
    refused(data, "a denominator is not shown")


@pytest.mark.parametrize("white", ["\r", "\f", "\v", "\t"])
def test_no_white_space_hides_a_part_of_what_is_printed(white: str) -> None:
    """A carriage return lets what follows it be written over what stands before it."""
    printed = check_certificate(certificate(f"u -{white}x", "u = x", ["x"], {"x": "1"}))
    assert "equation: u - x\n" in printed
