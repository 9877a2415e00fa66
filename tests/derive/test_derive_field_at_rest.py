"""Catches: an envelope that is refused for another reason than the true one."""

import pytest

from longwave.derive.__main__ import main


def test_a_field_at_rest_is_told_as_that(capsys: pytest.CaptureFixture[str]) -> None:
    numbers = "m1=1,m2=3,K2=1,K3=0,K4=1"
    words = ["mass_dimer", "--envelope", "k=pi", "--set", numbers, "--branch"]
    assert main([*words, "acoustic"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: k must have a carrier that moves u, got 3.1415927, where u is ")
    assert main([*words, "optical"]) == 0
    assert main([*words[:-2], "m1=4,m2=1,K2=1,K3=0,K4=1", "--branch", "acoustic"]) == 0
