"""Inverse functions by continuity: what the kernel accepts, and what it refuses."""

from __future__ import annotations

from typing import Any

import pytest

from longwave.verify.kernel import CertificateError, check_certificate
from longwave.verify.kernel.limits import FORMAT, digest

SUM = "1/2*pi - atan(x)"


def certificate(
    solution: str, equation: str, domain: list[str], point: str = "1/2", **proof: Any
) -> dict[str, Any]:
    """A certificate with a value by hand of one inverse function of x."""
    body: dict[str, Any] = {"format": FORMAT, "name": "angle"}
    body["statement"] = {
        "variables": ["x"],
        "equations": [equation],
        "solutions": [solution],
        "parameters": [],
        "domain": domain,
    }
    body["proof"] = {"signs": [], "parts": [], "point": [[0, point]], **proof}
    return {**body, "digest": digest(body)}


def arctangents(
    domain: list[str], value: str, half: str, times: str = "-2", more: str = "pi", **parts: str
) -> dict[str, Any]:
    """atan(x) + atan(1/x), with ``value`` for atan(1/x); ``half`` is the share of pi in it."""
    formulas = ["x", "I", "pi", "atan(#0)", "1/#0", "atan(#4)", value]
    formulas += ["I*#2", "I*#3", "exp(2*I*#6)", f"exp(2*({half})*#7 + ({times})*#8)", more]
    return certificate(
        "u = atan(x) + atan(1/x)",
        parts.pop("equation", "u - 1/2*pi"),
        domain,
        formulas=formulas,
        generators=[["atom", place] for place in (0, 1, 2, 3, *([11] if more != "pi" else []))],
        values=[[5, 6], [9, 10]],
        **parts,
    )


def test_a_value_is_principal_everywhere_if_it_is_at_a_point() -> None:
    assert "u - 1/2*pi" in check_certificate(arctangents(["x > 0"], SUM, "1/2"))


@pytest.mark.parametrize(("inner", "continuous"), [("x", True), ("x - 9", False)])
def test_a_logarithm_is_continuous_where_its_argument_is_positive(
    inner: str, continuous: bool
) -> None:
    more = f"log({inner})"
    data = arctangents(["x > 0"], f"{SUM} + 0*{more}", "1/2", more=more)
    if continuous:
        assert "u - 1/2*pi" in check_certificate(data)
    else:
        with pytest.raises(CertificateError, match="not shown to be a principal value"):
            check_certificate(data)


@pytest.mark.parametrize(
    ("domain", "value", "half", "equation", "point"),
    [
        ([], SUM, "1/2", "u - 1/2*pi", "1/2"),  # 1/x jumps from one branch to another
        (["x > 0"], "3/2*pi - atan(x)", "3/2", "u - 3/2*pi", "1/2"),  # the next branch
        (["x > 0"], "-1/2*pi - atan(x)", "-1/2", "u + 1/2*pi", "1/2"),  # the one before
        (["x < 0"], SUM, "1/2", "u - 1/2*pi", "-1/2"),
        (["1 < x**2"], SUM, "1/2", "u - 1/2*pi", "2"),  # in two parts
    ],
)
def test_other_branches_are_refused(
    domain: list[str], value: str, half: str, equation: str, point: str
) -> None:
    with pytest.raises(CertificateError, match="not shown to be a principal value"):
        check_certificate(arctangents(domain, value, half, equation=equation, point=point))


def test_what_has_another_tangent_is_refused() -> None:
    equation = "u - 1/2*pi + atan(x)"
    wrong = arctangents(["x > 0"], "1/2*pi - 2*atan(x)", "1/2", "-4", equation=equation)
    with pytest.raises(CertificateError, match="is that of another argument"):
        check_certificate(wrong)
