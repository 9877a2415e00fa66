"""Certificates are repeated by the checker, and one changed digit is rejected."""

import copy
import json
import random
import re
from typing import Any

import pytest

from solutions import CATALOGUE, closed_form
from verify.proof import CertificateError, check_certificate, form_domains, prove
from verify.proof.digest import digest


def certificate(name: str) -> dict[str, Any]:
    form = closed_form(name)
    domains = form_domains(form)
    verdict = prove(form.equation, form.expression, name=name, domains=domains, certify=True)
    return json.loads(json.dumps(verdict.certificate))


@pytest.mark.parametrize("name", [form.name for form in CATALOGUE])
def test_every_certificate_is_accepted(name: str) -> None:
    check_certificate(certificate(name))


def reject_changed_digits(name: str, share: float, least: int) -> None:
    """Change one digit of the text at a time, at random places or everywhere."""
    text = json.dumps(certificate(name))
    draw = random.Random(name)
    places = list(re.finditer(r"[0-9]", text))
    for match in draw.sample(places, min(len(places), max(least, int(share * len(places))))):
        other = draw.choice([d for d in "0123456789" if d != match.group()])
        changed = text[: match.start()] + other + text[match.end() :]
        with pytest.raises(ValueError, match=r"."):  # no JSON, or a CertificateError
            check_certificate(json.loads(changed))


@pytest.mark.parametrize("name", [form.name for form in CATALOGUE])
def test_one_digit_changed_is_rejected(name: str) -> None:
    reject_changed_digits(name, 0, 60)


@pytest.mark.slow
@pytest.mark.parametrize("name", [form.name for form in CATALOGUE])
def test_one_digit_changed_anywhere_is_rejected(name: str) -> None:
    reject_changed_digits(name, 1, 0)


PARTS = ("image", "generators", "equation", "expression", "coefficients", "factors")


def reject_forged_digits(name: str, count: int) -> None:
    """Change ``count`` digits of each part, one at a time, with the digest that then fits."""
    data, draw = certificate(name), random.Random(5)
    for part in PARTS:
        text = json.dumps(data[part])
        digits = list(re.finditer(r"[0-9]", text))
        for match in draw.sample(digits, min(len(digits), count)):
            # one more or less: a forged ninth derivative would take minutes
            other = "8" if match.group() == "9" else str(int(match.group()) + 1)
            forged = copy.deepcopy(data)
            forged[part] = json.loads(text[: match.start()] + other + text[match.end() :])
            if forged[part] == data[part] or _renames(forged, data):
                continue
            forged["digest"] = digest(forged)
            with pytest.raises(CertificateError):
                check_certificate(forged)


@pytest.mark.parametrize("name", [form.name for form in CATALOGUE])
def test_one_digit_changed_is_rejected_even_with_a_matching_digest(name: str) -> None:
    reject_forged_digits(name, 2)


@pytest.mark.slow
@pytest.mark.parametrize("name", [form.name for form in CATALOGUE])
def test_many_digits_changed_are_rejected_even_with_a_matching_digest(name: str) -> None:
    reject_forged_digits(name, 60)


def _renames(left: dict[str, Any], right: dict[str, Any]) -> bool:
    """Whether only the names of generators differ, which prove nothing."""
    nameless = [
        {**data, "digest": "", "generators": [{**g, "name": ""} for g in data["generators"]]}
        for data in (left, right)
    ]
    return nameless[0] == nameless[1]


def test_a_certificate_of_a_wrong_formula_cannot_be_forged() -> None:
    data = certificate("kink")
    data["image"]["numerator"][0][0] = "2"
    data["digest"] = digest(data)
    with pytest.raises(CertificateError, match="image of the formula"):
        check_certificate(data)


def test_garbage_is_rejected_in_words() -> None:
    with pytest.raises(CertificateError, match=r"lacks .digest"):
        check_certificate({"format": "longwave proof 1"})


def test_a_relation_that_holds_at_the_point_only_is_rejected() -> None:
    """With k = (its value) every formula of one point would be proved."""
    data = certificate("wave_cn")
    names = [generator["name"] for generator in data["generators"]]
    place = names.index("k")
    values = {data["nodes"][node][1]: value for node, value in data["point"]}
    data["generators"][place]["relation"] = [[1, [[values["k"], [0] * len(names)]]]]
    data["digest"] = digest(data)
    with pytest.raises(CertificateError, match="relation"):
        check_certificate(data)


def test_a_relation_with_itself_is_rejected() -> None:
    data = certificate("wave_cn")
    names = [generator["name"] for generator in data["generators"]]
    place = names.index("sn")
    square = [2 * int(i == place) for i in range(len(names))]
    data["generators"][place]["relation"] = [[2, [["1", square]]]]
    data["digest"] = digest(data)
    with pytest.raises(CertificateError, match="must be in earlier generators"):
        check_certificate(data)
