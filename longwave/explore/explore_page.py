"""The page of `longwave explore`: controls on the left, pictures on the right.

What is typed goes to `exploration`, what comes of it is shown; nothing is decided here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from io import BytesIO
from typing import Any, ClassVar

import panel as pn

from longwave.explore import explore_text as text
from longwave.explore.exploration import (
    FRAMES,
    Chosen,
    bounds,
    examples,
    first_choices,
    plain_value,
    scene_of_choices,
    settings,
    slider_ends,
    waves_by_equation,
)
from longwave.explore.exploration_run import Comparison, Explorer, Refusal
from longwave.explore.explore_figures import ErrorPicture, Profile, SpaceTimeMap
from longwave.scenes.description.scene import Scene

LOOK = 100
"""Milliseconds between two looks at the run."""

FIRST_WAVE = "rogue_cn"

NO_EXAMPLE = "none"

SCALES = {
    "eps": ("small parameter \u03b5", 0.02, 0.2),
    "half_width": ("compared: |X| up to", 5.0, 40.0),
}
"""Numbers of every scene that have a slider: what they are called, and its reach."""

TEXTS = {
    "begin": "from slow time T",
    "end": "to slow time T",
    "tolerance": "tolerance of the run",
}


STYLE = """
body, #main, #content { background: #f3f5f7; }
:host(.panel) {
  background: #ffffff; border: 1px solid #dde3e9; border-radius: 8px;
  padding: 6px 4px 10px 4px; margin: 6px 10px 10px 10px;
}
@media (max-width: 760px) {
  #header { padding: 2px 6px; }
  a.title { font-size: 1.05em; }
  #main { padding: 4px 0; }
  #sidebar {
    position: fixed; z-index: 10; width: 100%; height: calc(100% - 40px); left: 0;
    transform: translateX(-100%); background: #f3f5f7;
  }
  #sidebar.hidden { width: 100%; transform: none; padding: 15px 10px; overflow-y: auto; }
  :host(.panel) { margin: 4px 4px 8px 4px; }
  :host(.maps) { display: block; }
}
"""
"""Where the screen is narrow the controls are a drawer: the header's button, which hides them
beside the pictures elsewhere, brings them in over the pictures."""

TEXTS_STYLE = """
:host { font: 14px/1.45 system-ui, sans-serif; color: #22303c; }
h2 { font-size: 15px; font-weight: 600; margin: 4px 0 0 0; }
h3 { font-size: 13px; font-weight: 600; margin: 4px 0 0 0; border-bottom: 1px solid #dde3e9; }
code { font-size: 13px; }
.tiles { display: flex; flex-wrap: wrap; gap: 12px; }
.tile {
  flex: 1 1 170px; background: #ffffff; border: 1px solid #dde3e9; border-radius: 8px;
  padding: 10px 14px;
}
.what { color: #5a6b7b; font-size: 13px; }
.value { font-size: 24px; font-weight: 600; }
.hint { color: #5a6b7b; font-size: 12px; }
.refusal {
  background: #fdecea; color: #8c1d18; border: 1px solid #f2b8b5; border-radius: 8px;
  padding: 10px 14px; margin: 0 0 8px 0; overflow-wrap: anywhere;
}
:host(.status) { color: #5a6b7b; font-size: 13px; }
:host(.running) { color: #0072b2; font-weight: 600; }
:host(.refused) { color: #8c1d18; }
:host(.formula), :host(.equation) { overflow-x: auto; }
math { font-size: 17px; margin: 6px 0; }
"""

WIDE: dict[str, Any] = {"sizing_mode": "stretch_width"}


class PlainTemplate(pn.template.VanillaTemplate):
    """The template without the font that it would fetch from another host."""

    _resources: ClassVar[dict[str, dict[str, str]]] = {}


class Quiet:
    """Whether changes are the page's own, and are answered by nothing."""

    def __init__(self) -> None:
        self.holds = False

    @contextmanager
    def kept(self) -> Iterator[None]:
        """Have what is changed in the body answered by nothing."""
        before, self.holds = self.holds, True
        try:
            yield
        finally:
            self.holds = before


class NumberEntry:
    """A number that is typed, or drawn with a slider; the text is what counts."""

    def __init__(self, name: str, label: str, value: str, changed: Callable[[], None]) -> None:
        self.name = name
        self.changed = changed
        self.box = pn.widgets.TextInput(
            name=label, value=value, **WIDE, css_classes=[f"entry-{name}"]
        )
        self.slider: Any = None
        self._quiet = Quiet()
        self.box.param.watch(self._typed, "value")

    def reach(self, low: float, high: float) -> NumberEntry:
        """Let the slider, which is added at first, go from ``low`` to ``high``."""
        ends = {"start": low, "end": high, "step": (high - low) / 200.0}
        ends["value"] = self._within(low, high)
        if self.slider is not None:
            with self._quiet.kept():
                self.slider.param.update(**ends)
            return self
        self.slider = pn.widgets.FloatSlider(
            **ends, show_value=False, **WIDE, css_classes=[f"slider-{self.name}"]
        )
        self.slider.param.watch(self._drawn, "value_throttled")
        return self

    def _within(self, low: float, high: float) -> float:
        value = plain_value(self.box.value)
        return low if value is None else min(max(value, low), high)

    def _typed(self, _: Any) -> None:
        if self._quiet.holds:
            return
        if self.slider is not None:
            with self._quiet.kept():
                self.slider.value = self._within(self.slider.start, self.slider.end)
        self.changed()

    def _drawn(self, event: Any) -> None:
        if self._quiet.holds:
            return
        with self._quiet.kept():
            self.box.value = f"{event.new:.4g}"
        self.changed()

    def view(self) -> Any:
        """The text, and the slider below it if there is one."""
        parts = [self.box] if self.slider is None else [self.box, self.slider]
        return pn.Column(*parts, **WIDE, margin=0)


class ExplorePage:
    """One visitor's page: what is chosen, the run of it, and the pictures of that.

    Nothing is run before it has begun.
    """

    def __init__(self, explorer: Explorer) -> None:
        self.explorer, self._has_begun = explorer, False
        self.scene: Scene | None = None
        self.found: Comparison | None = None
        self._quiet = Quiet()
        self.entries: dict[str, NumberEntry] = {}
        self._make_choosers()
        self._make_results()
        self._choose(FIRST_WAVE, None)

    def begin(self) -> None:
        """Have what is chosen run, now that a browser shows the page."""
        self._has_begun = True
        self._ask()

    def turn_away(self, line: str) -> None:
        """Tell why nothing will be run."""
        self._refuse(Refusal(line))

    def _make_choosers(self) -> None:
        self.example = pn.widgets.Select(
            name="ready example", options={"\u2013": NO_EXAMPLE, **examples()},
            **WIDE, css_classes=["choose-example"],
        )  # fmt: skip
        groups = {f"{name} equation": waves for name, waves in waves_by_equation().items()}
        self.wave = pn.widgets.Select(
            name="wave", groups=groups, value=FIRST_WAVE, **WIDE, css_classes=["choose-wave"]
        )
        self.setting = pn.widgets.Select(
            name="on the lattice", **WIDE, css_classes=["choose-lattice"]
        )
        self.controls = pn.Column(**WIDE, margin=0)
        self.example.param.watch(self._example_chosen, "value")
        self.wave.param.watch(lambda event: self._chosen(event.new, None), "value")
        self.setting.param.watch(lambda event: self._chosen(self.wave.value, event.new), "value")

    def _make_results(self) -> None:
        def words(name: str) -> Any:
            return _html("", css_classes=[name], margin=(0, 10), **WIDE)

        self.status, self.refusal, self.outcome = map(words, ("status", "refused", "outcome"))
        self.moment, self.lines = map(words, ("moment", "lines"))
        self.equation, self.formula = map(words, ("equation", "formula"))
        self.profile, self.errors = Profile(), ErrorPicture()
        self.lattice_map = SpaceTimeMap("the lattice", "viridis", symmetric=False)
        self.difference_map = SpaceTimeMap("lattice less wave", "RdBu_r", symmetric=True)
        self.player = pn.widgets.Player(
            start=0, end=FRAMES - 1, value=FRAMES // 2, interval=120, loop_policy="loop",
            show_loop_controls=False, **WIDE, css_classes=["player"], height=60,
        )  # fmt: skip
        self.player.param.watch(lambda _: self._show_frame(), "value")
        self.toml = pn.widgets.TextAreaInput(disabled=True, **WIDE, rows=14, css_classes=["toml"])
        self.copy = pn.widgets.Button(name="Copy the scene", css_classes=["copy"])
        self.copy.js_on_click(
            args={"toml": self.toml}, code="navigator.clipboard.writeText(toml.value)"
        )
        self.download = pn.widgets.FileDownload(
            callback=lambda: BytesIO(self.toml.value.encode("utf-8")), filename="scene.toml",
            button_type="primary", label="Download scene.toml", css_classes=["download"],
        )  # fmt: skip

    def _example_chosen(self, event: Any) -> None:
        if event.new != NO_EXAMPLE and not self._quiet.holds:
            self._choose(*event.new)

    def _chosen(self, wave: str, setting: str | None) -> None:
        if not self._quiet.holds:
            with self._quiet.kept():
                self.example.value = NO_EXAMPLE
            self._choose(wave, setting)

    def _choose(self, wave: str, setting: str | None) -> None:
        """Begin with a wave on a lattice: fill the controls with its first choices."""
        choices = first_choices(wave, setting)
        with self._quiet.kept():
            self.wave.value = wave
            self.setting.options = {one.title: one.name for one in settings(wave)}
            self.setting.value = choices.setting
            self._fill_controls(choices)
        self._ask()

    def _fill_controls(self, choices: Chosen) -> None:
        from longwave.solutions import closed_form

        self.entries = {}
        waves = [
            self._entry("parameters", one.name, choices.parameters[one.name], one.domain)
            for one in closed_form(choices.wave).parameters
        ]
        self._reach_parameters(choices)
        constants = [
            self._entry("constants", name, value, name) for name, value in choices.constants.items()
        ]
        scales = [
            self._entry("", name, getattr(choices, name), label).reach(low, high)
            for name, (label, low, high) in SCALES.items()
        ]
        others = [
            self._entry("", name, getattr(choices, name), label) for name, label in TEXTS.items()
        ]
        none = [_html("this wave has none")]
        self.controls.objects = [
            _group("the wave's parameters", [one.view() for one in waves] or none),
            _group("the lattice's constants", _pairs(one.view() for one in constants)),
            _group("scale", [one.view() for one in scales]),
            _group("time and accuracy", _pairs(one.view() for one in others)),
        ]

    def _entry(self, group: str, name: str, value: str, label: str) -> NumberEntry:
        entry = NumberEntry(name, label, value, self._changed)
        self.entries[f"{group}.{name}"] = entry
        return entry

    def _reach_parameters(self, choices: Chosen) -> None:
        """Let the parameters' sliders go where the catalogue admits values, given the others."""
        from longwave.solutions import closed_form

        values = {name: plain_value(value) for name, value in choices.parameters.items()}
        for one in closed_form(choices.wave).parameters:
            if None not in bounds(one, values) or not _depends(one):
                self.entries[f"parameters.{one.name}"].reach(*slider_ends(one, values))

    def choices(self) -> Chosen:
        """What is chosen now."""
        typed: dict[str, dict[str, str]] = {"parameters": {}, "constants": {}, "": {}}
        for key, entry in self.entries.items():
            group, _, name = key.partition(".")
            typed[group][name] = entry.box.value_input or entry.box.value
        return Chosen(
            wave=self.wave.value, setting=self.setting.value, parameters=typed["parameters"],
            constants=typed["constants"], **typed[""],
        )  # fmt: skip

    def _changed(self) -> None:
        if not self._quiet.holds:
            with self._quiet.kept():
                self.example.value = NO_EXAMPLE
                self._reach_parameters(self.choices())
            self._ask()

    def _ask(self) -> None:
        """Have what is chosen run, or say why it cannot be."""
        try:
            self.scene = scene_of_choices(self.choices())
        except ValueError as error:
            self.toml.value = ""
            self.explorer.drop()
            self._refuse(Refusal(str(error)))
            return
        self.toml.value = self.scene.toml()
        if self._has_begun:
            self.explorer.ask(self.scene)
            self._tell("running", "running ...")

    def look(self) -> None:
        """Show what is new about the run."""
        answer = self.explorer.answer()
        if isinstance(answer, float):
            self.status.object = f"running: {100.0 * min(1.0, answer):.0f} %"
        elif isinstance(answer, Refusal):
            self._refuse(answer)
        elif answer is not None:
            self._show(answer)

    def _refuse(self, refusal: Refusal) -> None:
        self.refusal.object = text.refusal_html(refusal)
        self._tell("refused", "not run; the pictures below are of what was chosen before")

    def _tell(self, state: str, words: str) -> None:
        self.status.object = words
        self.status.css_classes = ["status", state]

    def _show(self, found: Comparison) -> None:
        self.found = found
        self.refusal.object = ""
        self._tell("done", "done")
        self.outcome.object = text.outcome_html(found)
        self.equation.object = text.equation_html(found)
        self.formula.object = text.wave_html(found)
        self.lines.object = text.lines_html(found)
        self.profile.show(found)
        self.lattice_map.show(found, found.lattice)
        self.difference_map.show(found, found.lattice - found.wave)
        self.errors.show(found)
        last = len(found.times) - 1
        frame = min(self.player.value, last) if self.player.end == last else last // 2
        self.player.param.update(end=last, value=frame)
        self._show_frame()

    def _show_frame(self) -> None:
        if self.found is None:
            return
        frame = min(self.player.value, len(self.found.times) - 1)
        self.profile.show_frame(self.found, frame)
        self.moment.object = text.moment(self.found, frame)
        for picture in (self.lattice_map, self.difference_map, self.errors):
            picture.at(float(self.found.slow_times[frame]))

    def view(self) -> Any:
        """The page itself."""
        introduction = _html(text.INTRODUCTION, **WIDE)
        page = PlainTemplate(
            title="longwave: lattice against wave", sidebar_width=360,
            header_background="#12324a", raw_css=[STYLE],
        )  # fmt: skip
        page.sidebar[:] = [introduction, self.example, self.wave, self.setting, self.controls]
        profile, errors, *maps = (
            pn.pane.Bokeh(one.picture, **WIDE)
            for one in (self.profile, self.errors, self.lattice_map, self.difference_map)
        )
        both = pn.Row(*maps, **WIDE, css_classes=["maps"], stylesheets=[STYLE])
        buttons = pn.Row(self.download, self.copy)
        file = "this scene as a file, for longwave run scene.toml"
        panels = (
            _panel("at one time", profile, self.moment, self.player),
            _panel("at all times, in the moving frame", both),
            _panel("difference of lattice and wave over time", errors, self.lines),
            _panel("the equation", self.equation, self.formula),
            _panel(file, buttons, self.toml),
        )
        page.main[:] = [pn.Column(self.status, self.refusal, self.outcome, *panels, **WIDE)]
        return page


def _depends(parameter: Any) -> bool:
    """Whether an end of the domain hangs on another parameter."""
    return any(bound and bound.value.free_symbols for bound in (parameter.lower, parameter.upper))


def _html(words: str, **look: Any) -> Any:
    return pn.pane.HTML(words, stylesheets=[TEXTS_STYLE], **look)


def _group(title: str, parts: Iterable[Any]) -> Any:
    head = _html(f"<h3>{title}</h3>", margin=(8, 10, 0, 10))
    return pn.Column(head, *parts, **WIDE, margin=0)


def _pairs(parts: Iterable[Any]) -> list[Any]:
    """The parts two by two."""
    found = list(parts)
    return [pn.Row(*found[i : i + 2], **WIDE, margin=0) for i in range(0, len(found), 2)]


def _panel(title: str, *parts: Any) -> Any:
    head = _html(f"<h2>{title}</h2>", margin=(4, 10))
    return pn.Column(head, *parts, **WIDE, css_classes=["panel"], stylesheets=[STYLE])
