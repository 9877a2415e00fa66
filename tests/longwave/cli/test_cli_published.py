"""The library of published solutions: its contents, and that every verdict is as expected."""

import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from statistics import median

import pytest

from longwave.__main__ import main
from longwave.solutions import CATALOGUE
from longwave.verify.problem_file import ProblemText, problem_texts
from longwave.verify.proof.statement_verdict import decide_statement
from longwave.verify.published import FROM_MEMORY, chosen, published, records, source_of
from longwave.verify.verdict import Outcome

Output = pytest.CaptureFixture[str]

LIBRARY = published()
VARIANTS = {text.variant_of for text in LIBRARY if text.expect == Outcome.REFUTED}


def test_no_statement_has_the_name_of_a_closed_form() -> None:
    """A certificate with the name of a closed form must state that form."""
    assert not {text.name for text in published()} & set(CATALOGUE.names)


def test_names_are_unique_and_need_no_quotes_in_a_shell() -> None:
    counts = Counter(text.name for text in LIBRARY)
    assert not [name for name, count in counts.items() if count > 1]
    assert not [name for name in counts if not name.replace("_", "").isalnum()]


def test_a_right_statement_has_a_wrong_variant_and_a_wrong_one_is_explained() -> None:
    for text in LIBRARY:
        assert text.equation_name, text.name
        assert text.source, text.name
        assert text.looked_up.startswith("http") or not text.looked_up, text.name
        if text.expect == Outcome.PROVED:
            assert text.name in VARIANTS
            assert not text.variant_of, text.name
        else:
            assert text.expect == Outcome.REFUTED, text.name
            assert text.note, text.name
            assert text.variant_of or text.misprint_in, text.name


def test_there_are_as_many_as_promised() -> None:
    right = [text for text in LIBRARY if text.expect == Outcome.PROVED]
    assert len(right) >= 120
    assert len({text.equation_name for text in right}) >= 40


def test_a_source_that_was_not_read_is_marked() -> None:
    for text in LIBRARY:
        if not text.variant_of and not text.misprint_in:
            assert source_of(text).endswith(f"({FROM_MEMORY})") == (not text.looked_up)
    (misprint,) = chosen(["toronto_kdv_soliton"])
    assert source_of(misprint).startswith("misprint in V. Ivrii")


def test_statements_are_chosen_by_their_name_or_their_equation() -> None:
    assert [text.name for text in chosen(["kdv_one_soliton"])] == ["kdv_one_soliton"]
    assert {text.equation_name for text in chosen(["Korteweg-de Vries"])} == {"Korteweg-de Vries"}
    assert len(chosen(["Korteweg-de Vries"])) > 1
    with pytest.raises(ValueError, match=r"got 'kdv_one_solition' .did you mean kdv_one_soliton."):
        chosen(["kdv_one_solition"])


def test_the_list_shows_every_statement(capsys: Output) -> None:
    assert main(["list", "--library", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == json.loads(json.dumps(records()))
    assert main(["list", "--library"]) == 0
    printed = capsys.readouterr().out
    assert all(f" {text.name} " in printed for text in LIBRARY)


def test_statements_of_the_library_are_decided_by_name(capsys: Output) -> None:
    assert main(["library", "kdv_one_soliton", "kdv_soliton_speed", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [record["verdict"] for record in found] == ["PROVED", "REFUTED"]


def test_a_variant_inherits_missing_keys_from_its_original(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    first = '[[problem]]\nname = "a"\nequation = "u_x - c"\nsolution = "u = c*x"\n'
    first += 'parameters = "c: c>0"\nexpect = "PROVED"\nnote = "right"\n'
    second = '[[problem]]\nvariant_of = "a"\nsolution = "u = 2*c*x"\n'
    path.write_text(first + second, encoding="utf-8")
    original, variant = problem_texts(path)
    assert (variant.equation, variant.parameters) == (original.equation, "c: c>0")
    assert (variant.solution, variant.expect, variant.note) == (("u = 2*c*x",), "", "")
    path.write_text(second + first, encoding="utf-8")
    with pytest.raises(ValueError, match="problem 1: variant_of must be the name of a problem"):
        problem_texts(path)


QUICK = slice(None, None, 32)
"""The statements that the default suite decides; all of them take the slow one."""


def seconds_of(texts: Sequence[ProblemText]) -> list[float]:
    """Return the seconds for the statements; raise AssertionError if one is not decided as
    expected."""
    verdicts = [decide_statement(text.problem().statement) for text in texts]
    pairs = zip(texts, verdicts, strict=True)
    assert not [(v.name, v.outcome, v.detail) for text, v in pairs if v.outcome != text.expect]
    return [verdict.seconds for verdict in verdicts]


def test_verdicts_are_as_expected() -> None:
    assert seconds_of(LIBRARY[QUICK])


@pytest.mark.slow
def test_every_verdict_is_as_expected_and_quick() -> None:
    seconds = seconds_of(LIBRARY)
    assert median(seconds) < 0.5
    assert max(seconds) < 20
