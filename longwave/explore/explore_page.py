"""The page of `longwave explore`: controls on the left, pictures on the right.

`exploration` interprets what is typed, and `exploration_run` computes what is shown.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from io import BytesIO
from typing import Any, ClassVar

import panel as pn

from longwave.explore import exploration
from longwave.explore import explore_text as text
from longwave.explore.exploration_run import Comparison, Explorer, Refusal
from longwave.explore.explore_figures import ErrorPicture, Profile, SpaceTimeMap
from longwave.scenes.description.scene import Scene

POLL_MS = 100
"""Milliseconds between two checks on the run."""

FIRST_WAVE = "rogue_cn"

NO_EXAMPLE = "none"

SLIDERS = {
    "eps": ("small parameter \u03b5", 0.02, 0.2),
    "half_width": ("compared: |X| up to", 5.0, 40.0),
}
"""Numbers of every scene that have a slider -> (label, lower end, upper end)."""

TEXT_FIELDS = {
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
"""CSS of the page. On a narrow screen the controls are a drawer: the header's button, which else
hides the controls, slides them over the pictures."""

PANE_STYLE = """
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
    """Panel's template without the font that it would load from another host."""

    _resources: ClassVar[dict[str, dict[str, str]]] = {}


class EventBlock:
    """Flag by which event handlers ignore changes that the page makes itself."""

    def __init__(self) -> None:
        self.is_active = False

    @contextmanager
    def active(self) -> Iterator[None]:
        """Make event handlers ignore the changes made within the context."""
        previous, self.is_active = self.is_active, True
        try:
            yield
        finally:
            self.is_active = previous


class NumberEntry:
    """A number with a text box and a slider; the typed text is the value that is used."""

    def __init__(self, name: str, label: str, value: str, changed: Callable[[], None]) -> None:
        self.name = name
        self.changed = changed
        self.box = pn.widgets.TextInput(
            name=label, value=value, **WIDE, css_classes=[f"entry-{name}"]
        )
        self.slider: Any = None
        self._event_block = EventBlock()
        self.box.param.watch(self._on_typed, "value")

    def set_range(self, low: float, high: float) -> NumberEntry:
        """Set the range of the slider, which is created at the first call."""
        ends = {"start": low, "end": high, "step": (high - low) / 200.0}
        ends["value"] = self._within(low, high)
        if self.slider is not None:
            with self._event_block.active():
                self.slider.param.update(**ends)
            return self
        self.slider = pn.widgets.FloatSlider(
            **ends, show_value=False, **WIDE, css_classes=[f"slider-{self.name}"]
        )
        self.slider.param.watch(self._on_slider, "value_throttled")
        return self

    def _within(self, low: float, high: float) -> float:
        value = exploration.plain_value(self.box.value)
        return low if value is None else min(max(value, low), high)

    def _on_typed(self, _: Any) -> None:
        if self._event_block.is_active:
            return
        if self.slider is not None:
            with self._event_block.active():
                self.slider.value = self._within(self.slider.start, self.slider.end)
        self.changed()

    def _on_slider(self, event: Any) -> None:
        if self._event_block.is_active:
            return
        with self._event_block.active():
            self.box.value = f"{event.new:.4g}"
        self.changed()

    def view(self) -> Any:
        """Return the text box, with the slider below it if there is one."""
        parts = [self.box] if self.slider is None else [self.box, self.slider]
        return pn.Column(*parts, **WIDE, margin=0)


class ExplorePage:
    """One visitor's page: the current choices, their run and the pictures of the run."""

    def __init__(self, explorer: Explorer) -> None:
        self.explorer, self._has_started = explorer, False
        self.scene: Scene | None = None
        self.comparison: Comparison | None = None
        self._event_block = EventBlock()
        self.entries: dict[str, NumberEntry] = {}
        self._build_choosers()
        self._build_results()
        self._choose(FIRST_WAVE, None)

    def start(self) -> None:
        """Run the current choices, now that a browser shows the page."""
        self._has_started = True
        self._submit()

    def refuse_with(self, line: str) -> None:
        """Show a message why nothing will be run."""
        self._show_refusal(Refusal(line))

    def _build_choosers(self) -> None:
        self.example = pn.widgets.Select(
            name="ready example", options={"\u2013": NO_EXAMPLE, **exploration.examples()},
            **WIDE, css_classes=["choose-example"],
        )  # fmt: skip
        groups = {
            f"{name} equation": waves for name, waves in exploration.waves_by_equation().items()
        }
        self.wave = pn.widgets.Select(
            name="wave", groups=groups, value=FIRST_WAVE, **WIDE, css_classes=["choose-wave"]
        )
        self.setting = pn.widgets.Select(
            name="on the lattice", **WIDE, css_classes=["choose-lattice"]
        )
        self.controls = pn.Column(**WIDE, margin=0)
        self.example.param.watch(self._on_example, "value")
        self.wave.param.watch(lambda event: self._on_choice(event.new, None), "value")
        self.setting.param.watch(lambda event: self._on_choice(self.wave.value, event.new), "value")

    def _build_results(self) -> None:
        def text_pane(name: str) -> Any:
            return _html("", css_classes=[name], margin=(0, 10), **WIDE)

        self.status, self.refusal, self.outcome = map(text_pane, ("status", "refused", "outcome"))
        self.moment, self.lines = map(text_pane, ("moment", "lines"))
        self.equation, self.formula = map(text_pane, ("equation", "formula"))
        self.profile, self.errors = Profile(), ErrorPicture()
        self.lattice_map = SpaceTimeMap("the lattice", "viridis", symmetric=False)
        self.difference_map = SpaceTimeMap("lattice less wave", "RdBu_r", symmetric=True)
        self.player = pn.widgets.Player(
            start=0, end=exploration.FRAMES - 1, value=exploration.FRAMES // 2, interval=120,
            loop_policy="loop", show_loop_controls=False, **WIDE, css_classes=["player"], height=60,
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

    def _on_example(self, event: Any) -> None:
        if event.new != NO_EXAMPLE and not self._event_block.is_active:
            self._choose(*event.new)

    def _on_choice(self, wave: str, setting: str | None) -> None:
        if not self._event_block.is_active:
            with self._event_block.active():
                self.example.value = NO_EXAMPLE
            self._choose(wave, setting)

    def _choose(self, wave: str, setting: str | None) -> None:
        """Select a wave and a lattice, and fill the controls with their initial choices."""
        choices = exploration.initial_choices(wave, setting)
        with self._event_block.active():
            self.wave.value = wave
            self.setting.options = {one.title: one.name for one in exploration.settings(wave)}
            self.setting.value = choices.setting
            self._fill_controls(choices)
        self._submit()

    def _fill_controls(self, choices: exploration.Choices) -> None:
        from longwave.solutions import closed_form

        self.entries = {}
        waves = [
            self._entry("parameters", one.name, choices.parameters[one.name], one.domain)
            for one in closed_form(choices.wave).parameters
        ]
        self._update_sliders(choices)
        constants = [
            self._entry("constants", name, value, name) for name, value in choices.constants.items()
        ]
        scales = [
            self._entry("", name, getattr(choices, name), label).set_range(low, high)
            for name, (label, low, high) in SLIDERS.items()
        ]
        others = [
            self._entry("", name, getattr(choices, name), label)
            for name, label in TEXT_FIELDS.items()
        ]
        none_message = [_html("this wave has none")]
        self.controls.objects = [
            _group("the wave's parameters", [one.view() for one in waves] or none_message),
            _group("the lattice's constants", _pairs(one.view() for one in constants)),
            _group("scale", [one.view() for one in scales]),
            _group("time and accuracy", _pairs(one.view() for one in others)),
        ]

    def _entry(self, group: str, name: str, value: str, label: str) -> NumberEntry:
        entry = NumberEntry(name, label, value, self._on_change)
        self.entries[f"{group}.{name}"] = entry
        return entry

    def _update_sliders(self, choices: exploration.Choices) -> None:
        """Set each parameter's slider to its domain, whose ends may depend on other parameters."""
        from longwave.solutions import closed_form

        values = {
            name: exploration.plain_value(value) for name, value in choices.parameters.items()
        }
        for one in closed_form(choices.wave).parameters:
            if None not in exploration.bounds(one, values) or not _has_dependent_bound(one):
                self.entries[f"parameters.{one.name}"].set_range(
                    *exploration.slider_ends(one, values)
                )

    def choices(self) -> exploration.Choices:
        """Return the current choices."""
        typed: dict[str, dict[str, str]] = {"parameters": {}, "constants": {}, "": {}}
        for key, entry in self.entries.items():
            group, _, name = key.partition(".")
            typed[group][name] = entry.box.value_input or entry.box.value
        return exploration.Choices(
            wave=self.wave.value, setting=self.setting.value, parameters=typed["parameters"],
            constants=typed["constants"], **typed[""],
        )  # fmt: skip

    def _on_change(self) -> None:
        if not self._event_block.is_active:
            with self._event_block.active():
                self.example.value = NO_EXAMPLE
                self._update_sliders(self.choices())
            self._submit()

    def _submit(self) -> None:
        """Run the current choices, or show why they cannot run."""
        try:
            self.scene = exploration.scene_of_choices(self.choices())
        except ValueError as error:
            self.toml.value = ""
            self.explorer.cancel()
            self._show_refusal(Refusal(str(error)))
            return
        self.toml.value = self.scene.toml()
        if self._has_started:
            self.explorer.submit(self.scene)
            self._set_status("running", "running ...")

    def poll(self) -> None:
        """Show news about the run."""
        answer = self.explorer.answer()
        if isinstance(answer, float):
            self.status.object = f"running: {100.0 * min(1.0, answer):.0f} %"
        elif isinstance(answer, Refusal):
            self._show_refusal(answer)
        elif answer is not None:
            self._show(answer)

    def _show_refusal(self, refusal: Refusal) -> None:
        self.refusal.object = text.refusal_html(refusal)
        self._set_status("refused", "not run; the pictures below are of what was chosen before")

    def _set_status(self, state: str, words: str) -> None:
        self.status.object = words
        self.status.css_classes = ["status", state]

    def _show(self, comparison: Comparison) -> None:
        self.comparison = comparison
        self.refusal.object = ""
        self._set_status("done", "done")
        self.outcome.object = text.outcome_html(comparison)
        self.equation.object = text.equation_html(comparison)
        self.formula.object = text.wave_html(comparison)
        self.lines.object = text.lines_html(comparison)
        self.profile.show(comparison)
        self.lattice_map.show(comparison, comparison.lattice)
        self.difference_map.show(comparison, comparison.lattice - comparison.wave)
        self.errors.show(comparison)
        last = len(comparison.times) - 1
        frame = min(self.player.value, last) if self.player.end == last else last // 2
        self.player.param.update(end=last, value=frame)
        self._show_frame()

    def _show_frame(self) -> None:
        if self.comparison is None:
            return
        frame = min(self.player.value, len(self.comparison.times) - 1)
        self.profile.show_frame(self.comparison, frame)
        self.moment.object = text.frame_caption(self.comparison, frame)
        for picture in (self.lattice_map, self.difference_map, self.errors):
            picture.set_time(float(self.comparison.slow_times[frame]))

    def view(self) -> Any:
        """Return the page's layout."""
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


def _has_dependent_bound(parameter: Any) -> bool:
    """Whether an end of the parameter's domain depends on another parameter."""
    return any(bound and bound.value.free_symbols for bound in (parameter.lower, parameter.upper))


def _html(words: str, **options: Any) -> Any:
    return pn.pane.HTML(words, stylesheets=[PANE_STYLE], **options)


def _group(title: str, parts: Iterable[Any]) -> Any:
    head = _html(f"<h3>{title}</h3>", margin=(8, 10, 0, 10))
    return pn.Column(head, *parts, **WIDE, margin=0)


def _pairs(parts: Iterable[Any]) -> list[Any]:
    """Arrange the controls ``parts`` in rows of two."""
    part_list = list(parts)
    return [pn.Row(*part_list[i : i + 2], **WIDE, margin=0) for i in range(0, len(part_list), 2)]


def _panel(title: str, *parts: Any) -> Any:
    head = _html(f"<h2>{title}</h2>", margin=(4, 10))
    return pn.Column(head, *parts, **WIDE, css_classes=["panel"], stylesheets=[STYLE])
