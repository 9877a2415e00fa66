"""The explorer without its page and server: choices, scenes, runs, texts."""

import multiprocessing
import time
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from longwave.explore import explore_text as text
from longwave.explore.exploration import (
    FRAMES,
    Choices,
    bounds,
    examples,
    initial_choices,
    scene_of_choices,
    settings,
    slider_ends,
    waves_by_equation,
)
from longwave.explore.exploration_run import (
    Answer,
    Comparison,
    Explorer,
    Refusal,
    WaveTexts,
    compare,
)
from longwave.scenes.description.named_scenes import load_scene, shipped_scenes
from longwave.scenes.starts.lattice_derivation import derivation
from longwave.scenes.starts.moving_wave import moving_wave
from longwave.solutions import CATALOGUE, closed_form
from longwave.support.request_limits import RequestLimits
from tests.families import WAVES, family

LONG = initial_choices("rational_3").changed(eps="0.005", tolerance="1e-8")
SOLITON = initial_choices("soliton_sech").changed(begin="0", end="0.1", half_width="8")

PATIENT = RequestLimits(2e9, 600.0)
"""A run is expected to take what its first steps take, and on a loaded machine that is long."""


HOMELESS = ["mkdv_burgers_shock"]
"""No shipped scene has its losses."""

AT_HOME = [name for name in CATALOGUE.names if name not in HOMELESS]


def ratio(text: str) -> float:
    top, _, below = text.partition("/")
    return float(top) / float(below or 1)


@pytest.mark.slow
def test_every_wave_of_the_catalogue_and_every_lattice_scene_can_be_chosen() -> None:
    waves = [*HOMELESS, *(name for all_ in waves_by_equation().values() for name in all_.values())]
    assert sorted(waves) == sorted(CATALOGUE.names)
    assert {setting for _, setting in examples().values()} == {*shipped_scenes("lattices")}
    for wave, setting in examples().values():
        scene, shipped = scene_of_choices(initial_choices(wave, setting)), load_scene(setting)
        assert len(scene.slow_times) == FRAMES
        assert scene.changed(slow_times=shipped.slow_times) == shipped


@pytest.mark.parametrize("wave", family(AT_HOME, quick=WAVES))
def test_the_first_choices_of_every_wave_are_admitted(wave: str) -> None:
    assert settings(wave)
    for setting in settings(wave):
        choices = initial_choices(wave, setting.name)
        scene = scene_of_choices(choices)
        closed_form(wave).check({name: ratio(str(value)) for name, value in scene.parameters})
        if scene.has_moving_wave:
            assert moving_wave(scene).wave
            assert len(scene.snapshots) == FRAMES


@pytest.mark.parametrize("wave", ["gardner_kink", "modified_kawahara_soliton", "nls_dark"])
def test_waves_of_no_shipped_scene_solve_the_equation_of_their_lattice(wave: str) -> None:
    for setting in settings(wave):
        scene = scene_of_choices(initial_choices(wave, setting.name))
        assert derivation(scene)


@pytest.mark.parametrize("wave", family(AT_HOME, quick=WAVES))
def test_sliders_stay_where_the_catalogue_admits_values(wave: str) -> None:
    values = {name: ratio(text) for name, text in initial_choices(wave).parameters.items()}
    for parameter in closed_form(wave).parameters:
        for end in slider_ends(parameter, values):
            parameter.check({**values, parameter.name: end})
        low, high = bounds(parameter, values)
        reach = slider_ends(parameter, values)
        if low is not None and high is not None:
            assert reach[1] - reach[0] > 0.9 * (high - low)


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"eps": "small"}, "eps must be a number, got 'small' (such as 0.05)"),
        ({"eps": "-1"}, "eps must satisfy eps > 0, got -1 (such as 0.05)"),
        ({"eps": "nan"}, "eps must be finite, got nan (such as 0.05)"),
        ({"end": "-3"}, "end must satisfy end > begin = 0, got -3 (increase end)"),
        ({"half_width": "0"}, "half_width must satisfy half_width > 0, got 0 (such as 0.5)"),
        ({"tolerance": "1e-30"}, "tolerance must satisfy tolerance >= 1e-11, got 1e-30 (rou"),
    ],
)
def test_a_wrong_entry_shows_the_librarys_message(changes: dict[str, object], line: str) -> None:
    with pytest.raises(ValueError) as message:  # noqa: PT011  (the whole line is looked at)
        scene_of_choices(SOLITON.changed(**changes))
    assert str(message.value).startswith(line)
    assert "\n" not in str(message.value)


@pytest.mark.parametrize(
    ("choices", "line"),
    [
        (SOLITON.changed(parameters={"A": "-1"}), "A must satisfy 0 < A, got -1.0 (A = 0 is"),
        (SOLITON.changed(parameters={"A": "<b>"}), "A: expected a number, a name or '('"),
        (SOLITON.changed(parameters={"A": ""}), "A must satisfy 0 < A, got nothing (give A)"),
        (SOLITON.changed(constants={"K3": "1"}), "wave must solve the KdV equation, which is"),
        (SOLITON.changed(constants={"K2": "one"}), "K2: expected "),
        (SOLITON.changed(half_width="1e6"), "half_width / eps must ask for at most 100000 cells"),
        (SOLITON.changed(eps="1e-4"), "half_width / eps must ask for at most 100000 cells"),
        (LONG, "the run must take at most 10 s, got about "),
    ],
)
def test_a_scene_that_cannot_run_is_a_one_line_message(choices: Choices, line: str) -> None:
    begun = time.process_time()
    with pytest.raises(ValueError) as message:  # noqa: PT011  (the whole line is looked at)
        compare(scene_of_choices(choices))
    assert str(message.value).startswith(line)
    assert "\n" not in str(message.value)
    assert time.process_time() - begun < 30.0


def test_limits_of_the_page_can_be_set() -> None:
    limits = RequestLimits(1e8, 60.0)
    with pytest.raises(ValueError, match=r"must fit 100 MB, got about .* or raise --max-memory"):
        compare(scene_of_choices(SOLITON), limits=limits)


@pytest.fixture(scope="module")
def found() -> Comparison:
    return compare(scene_of_choices(SOLITON), limits=PATIENT)


@pytest.mark.slow
def test_a_comparison_holds_what_the_run_holds(found: Comparison, tmp_path: Path) -> None:
    from longwave.scenes.engines.scene_run import run

    path = tmp_path / "explored.toml"
    path.write_text(scene_of_choices(SOLITON).toml(), encoding="utf-8")
    again = load_scene(str(path))
    data = run(again)
    np.testing.assert_array_equal(found.lattice, data.strain / again.eps)
    np.testing.assert_array_equal(found.wave, data.analytic / again.eps)
    np.testing.assert_allclose(found.relative, data.error, rtol=1e-12)
    np.testing.assert_allclose(found.errors, np.abs(found.lattice - found.wave).max(axis=1))
    assert found.estimate == data.attrs["error_estimate"] <= again.tolerance
    crest = found.X[-1][np.argmax(found.wave[-1])]
    # c t is left behind at c/24 a^2 per slow time
    assert abs(crest - found.slow_times[-1] / 24 * 2.0**2 * 3) < 0.5
    assert "focusing mKdV" in found.equation
    assert found.lines[0].startswith(str(data.attrs["engine"]))


def test_the_map_keeps_every_crest(found: Comparison) -> None:
    wide = np.zeros((2, 1000))
    wide[0, 437], wide[1, 998] = 3.0, -2.0
    columns = found.columns(wide)
    assert columns.shape == (2, 250)
    assert columns[0].max() == 3.0
    assert columns[1].min() == -2.0


class Reader(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.texts: list[str] = []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.tags.append(tag)

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def read(html: str) -> Reader:
    reader = Reader()
    reader.feed(html)
    return reader


def test_the_texts_show_errors_and_the_runs_own_error(found: Comparison) -> None:
    shown = read(text.outcome_html(found)).texts
    assert "largest difference" in shown
    assert f"{found.errors.max():.3g} ε" in shown
    assert f"± {found.estimate:.2g} ε" in shown
    assert text.frame_caption(found, 0).startswith("T = 0, t = 0: difference 0 ε")
    assert "math" in read(text.equation_html(found)).tags
    assert read(text.wave_html(found)).tags.count("math") == 2


def test_typed_text_is_escaped_in_html() -> None:
    hostile = "<script>alert(1)</script>"
    for html in (
        text.refusal_html(Refusal(hostile)),
        text.formula_html(r"\nonsense{", hostile),
        text.lines_html(_empty(lines=(hostile,))),
        text.outcome_html(_empty(ended=hostile)),
        text.wave_html(_empty(wave_texts=WaveTexts(hostile, hostile, "x", ""))),
        text.equation_html(_empty(equation=f"{hostile}: {hostile}", equation_latex="{")),
    ):
        assert "script" not in read(html).tags
        assert hostile in "".join(read(html).texts)


def _empty(**changes: object) -> Comparison:
    rows = [np.zeros((1, 3))] * 5
    texts = WaveTexts("kink", "", "x", "")
    one = Comparison(
        rows[0], *[np.zeros(1)] * 2, *rows[:2], *[np.zeros(1)] * 2, 0.0, "eps", "", "x", texts, ()
    )
    return replace(one, **changes)  # type: ignore[arg-type]


def answered(explorer: Explorer) -> Answer:
    """Wait for the final answer; the time limit only ends a hanging test."""
    for _ in range(1200):
        answer = explorer.answer()
        if answer is not None and not isinstance(answer, float):
            return answer
        time.sleep(0.1)
    raise AssertionError("no answer")


def kill() -> None:
    """Kill the only worker process of the explorer."""
    (process,) = multiprocessing.active_children()
    process.kill()
    process.join()


@pytest.mark.slow
def test_the_newest_choice_is_answered_and_a_dead_process_is_replaced(
    found: Comparison,
) -> None:
    explorer = Explorer(PATIENT)
    try:
        explorer.submit(scene_of_choices(SOLITON.changed(eps="0.01", end="1")))
        time.sleep(1.0)
        assert not isinstance(explorer.answer(), Comparison)
        explorer.submit(scene_of_choices(SOLITON))
        answer = answered(explorer)
        assert isinstance(answer, Comparison)
        np.testing.assert_array_equal(answer.lattice, found.lattice)
        explorer.submit(scene_of_choices(SOLITON.changed(parameters={"A": "-1"})))
        refusal = answered(explorer)
        assert isinstance(refusal, Refusal)
        assert refusal.line.startswith("A must satisfy 0 < A, got -1")
        kill()
        explorer.submit(scene_of_choices(SOLITON))
        assert isinstance(answered(explorer), Comparison)
        explorer.submit(scene_of_choices(SOLITON))
        kill()
        assert answered(explorer) == Refusal(
            "the worker process ended before its run (too little memory?)"
        )
        explorer.cancel()
        assert explorer.answer() is None
    finally:
        explorer.close()


@pytest.mark.slow
def test_a_memory_limit_below_that_of_the_process_is_a_one_line_refusal(
    capfd: pytest.CaptureFixture[str],
) -> None:
    explorer = Explorer(RequestLimits(99.0, 60.0))
    try:
        explorer.submit(scene_of_choices(SOLITON))
        refusal = answered(explorer)
    finally:
        explorer.close()
    assert isinstance(refusal, Refusal)
    assert "must fit 0.099 kB, got about" in refusal.line
    assert capfd.readouterr().err == ""


@pytest.mark.slow
@pytest.mark.parametrize("wave", AT_HOME)
def test_every_wave_runs_on_its_first_lattice(wave: str) -> None:
    found = compare(scene_of_choices(initial_choices(wave)), limits=PATIENT)
    assert found.estimate <= float(initial_choices(wave).tolerance)
    assert np.isfinite(found.lattice).all()
    assert float(np.nanmax(found.relative)) < 0.5
