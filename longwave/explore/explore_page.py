"""The page of `longwave explore`: controls on the left, pictures on the right.

What is typed goes to `exploration`, what comes of it is shown; nothing is decided here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
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
from longwave.explore.explore_style import STYLE, TEXTS_STYLE
from longwave.scenes.scene import Scene

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


class PlainTemplate(pn.template.VanillaTemplate):
    """The template without the font that it would fetch from another host."""

    _resources: ClassVar[dict[str, dict[str, str]]] = {}


class NumberEntry:
    """A number that is typed, or drawn with a slider; the text is what counts."""

    def __init__(self, name: str, label: str, value: str, changed: Callable[[], None]) -> None:
        self.name = name
        self.changed = changed
        self.box = pn.widgets.TextInput(
            name=label, value=value, sizing_mode="stretch_width", css_classes=[f"entry-{name}"]
        )
        self.slider: Any = None
        self._follows = False
        self.box.param.watch(self._typed, "value")

    def with_slider(self, low: float, high: float) -> NumberEntry:
        """Add a slider from ``low`` to ``high``."""
        self.slider = pn.widgets.FloatSlider(
            start=low, end=high, step=(high - low) / 200.0, value=self._within(low, high),
            show_value=False, sizing_mode="stretch_width", css_classes=[f"slider-{self.name}"],
        )  # fmt: skip
        self.slider.param.watch(self._drawn, "value_throttled")
        return self

    def reach(self, low: float, high: float) -> None:
        """Let the slider go from ``low`` to ``high``."""
        with self._following():
            self.slider.param.update(
                start=low, end=high, step=(high - low) / 200.0, value=self._within(low, high)
            )

    def _within(self, low: float, high: float) -> float:
        value = plain_value(self.box.value)
        return low if value is None else min(max(value, low), high)

    def _typed(self, _: Any) -> None:
        if self._follows:
            return
        if self.slider is not None:
            with self._following():
                self.slider.value = self._within(self.slider.start, self.slider.end)
        self.changed()

    def _drawn(self, event: Any) -> None:
        if self._follows:
            return
        with self._following():
            self.box.value = f"{event.new:.4g}"
        self.changed()

    @contextmanager
    def _following(self) -> Iterator[None]:
        self._follows = True
        try:
            yield
        finally:
            self._follows = False

    def view(self) -> Any:
        """The text, and the slider below it if there is one."""
        parts = [self.box] if self.slider is None else [self.box, self.slider]
        return pn.Column(*parts, sizing_mode="stretch_width", margin=0)


class ExplorePage:
    """One visitor's page: what is chosen, the run of it, and the pictures of that."""

    def __init__(self, explorer: Explorer) -> None:
        self.explorer = explorer
        self.scene: Scene | None = None
        self.found: Comparison | None = None
        self._quiet = False
        self.entries: dict[str, NumberEntry] = {}
        self._make_choosers()
        self._make_results()
        self._choose(FIRST_WAVE, None)

    def _make_choosers(self) -> None:
        self.example = pn.widgets.Select(
            name="ready example", options={"\u2013": NO_EXAMPLE, **examples()},
            sizing_mode="stretch_width", css_classes=["choose-example"],
        )  # fmt: skip
        groups = {f"{name} equation": waves for name, waves in waves_by_equation().items()}
        self.wave = pn.widgets.Select(
            name="wave", groups=groups, value=FIRST_WAVE, sizing_mode="stretch_width",
            css_classes=["choose-wave"],
        )  # fmt: skip
        self.setting = pn.widgets.Select(
            name="on the lattice", sizing_mode="stretch_width", css_classes=["choose-lattice"]
        )
        self.controls = pn.Column(sizing_mode="stretch_width", margin=0)
        self.example.param.watch(self._example_chosen, "value")
        self.wave.param.watch(lambda event: self._chosen(event.new, None), "value")
        self.setting.param.watch(lambda event: self._chosen(self.wave.value, event.new), "value")

    def _make_results(self) -> None:
        def words(name: str) -> Any:
            return pn.pane.HTML(
                "", sizing_mode="stretch_width", stylesheets=[TEXTS_STYLE], css_classes=[name],
                margin=(0, 10),
            )  # fmt: skip

        self.status, self.outcome, self.moment = (
            words("status"), words("outcome"), words("moment")
        )  # fmt: skip
        self.refusal, self.equation, self.lines = (
            words("refused"), words("equation"), words("lines")
        )  # fmt: skip
        self.formula = words("formula")
        self.profile, self.errors = Profile(), ErrorPicture()
        self.lattice_map = SpaceTimeMap("the lattice", "viridis", symmetric=False)
        self.difference_map = SpaceTimeMap("lattice less wave", "RdBu_r", symmetric=True)
        self.player = pn.widgets.Player(
            start=0, end=FRAMES - 1, value=FRAMES // 2, interval=120, loop_policy="loop",
            show_loop_controls=False, sizing_mode="stretch_width", css_classes=["player"],
            height=60,
        )  # fmt: skip
        self.player.param.watch(lambda _: self._show_frame(), "value")
        self.toml = pn.widgets.TextAreaInput(
            disabled=True, sizing_mode="stretch_width", rows=14, css_classes=["toml"]
        )
        self.copy = pn.widgets.Button(name="Copy the scene", css_classes=["copy"])
        self.copy.js_on_click(
            args={"toml": self.toml}, code="navigator.clipboard.writeText(toml.value)"
        )
        self.download = pn.widgets.FileDownload(
            callback=self._file, filename="scene.toml", button_type="primary",
            label="Download scene.toml", css_classes=["download"],
        )  # fmt: skip

    def _file(self) -> Any:
        from io import BytesIO

        return BytesIO(self.toml.value.encode("utf-8"))

    def _example_chosen(self, event: Any) -> None:
        if event.new != NO_EXAMPLE and not self._quiet:
            self._choose(*event.new)

    def _chosen(self, wave: str, setting: str | None) -> None:
        if not self._quiet:
            with self._quietly():
                self.example.value = NO_EXAMPLE
            self._choose(wave, setting)

    @contextmanager
    def _quietly(self) -> Iterator[None]:
        before, self._quiet = self._quiet, True
        try:
            yield
        finally:
            self._quiet = before

    def _choose(self, wave: str, setting: str | None) -> None:
        """Begin with a wave on a lattice: fill the controls with its first choices."""
        choices = first_choices(wave, setting)
        with self._quietly():
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
            self._entry("", name, getattr(choices, name), label).with_slider(low, high)
            for name, (label, low, high) in SCALES.items()
        ]
        others = [
            self._entry("", name, getattr(choices, name), label) for name, label in TEXTS.items()
        ]
        none = [pn.pane.HTML("this wave has none", stylesheets=[TEXTS_STYLE])]
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
            if None in bounds(one, values) and _depends(one):
                continue
            entry, ends = self.entries[f"parameters.{one.name}"], slider_ends(one, values)
            if entry.slider is None:
                entry.with_slider(*ends)
            else:
                entry.reach(*ends)

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
        if not self._quiet:
            with self._quietly():
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
        self.explorer.ask(self.scene)
        self.status.object = "running ..."
        self.status.css_classes = ["status", "running"]

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
        self.status.object = "not run; the pictures below are of what was chosen before"
        self.status.css_classes = ["status", "refused"]

    def _show(self, found: Comparison) -> None:
        self.found = found
        self.refusal.object = ""
        self.status.object = "done"
        self.status.css_classes = ["status", "done"]
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
        self.profile.at(self.found, frame)
        self.moment.object = text.moment(self.found, frame)
        for picture in (self.lattice_map, self.difference_map, self.errors):
            picture.at(float(self.found.slow_times[frame]))

    def view(self) -> Any:
        """The page itself."""
        introduction = pn.pane.HTML(
            text.INTRODUCTION, sizing_mode="stretch_width", stylesheets=[TEXTS_STYLE]
        )
        page = PlainTemplate(
            title="longwave: lattice against wave", sidebar_width=360,
            header_background="#12324a", raw_css=[STYLE],
        )  # fmt: skip
        page.sidebar[:] = [introduction, self.example, self.wave, self.setting, self.controls]
        maps = pn.Row(
            pn.pane.Bokeh(self.lattice_map.picture, sizing_mode="stretch_width"),
            pn.pane.Bokeh(self.difference_map.picture, sizing_mode="stretch_width"),
            sizing_mode="stretch_width",
        )
        buttons = pn.Row(self.download, self.copy)
        page.main[:] = [
            pn.Column(
                self.status, self.refusal, self.outcome,
                _panel("at one time", [
                    pn.pane.Bokeh(self.profile.picture, sizing_mode="stretch_width"),
                    self.moment, self.player,
                ]),
                _panel("at all times, in the frame that moves with the wave", [maps]),
                _panel("how far lattice and wave part", [
                    pn.pane.Bokeh(self.errors.picture, sizing_mode="stretch_width"), self.lines,
                ]),
                _panel("the equation", [self.equation, self.formula]),
                _panel("this scene as a file: longwave run scene.toml repeats it",
                       [buttons, self.toml]),
                sizing_mode="stretch_width",
            )
        ]  # fmt: skip
        return page


def _depends(parameter: Any) -> bool:
    """Whether an end of the domain hangs on another parameter."""
    return any(bound and bound.value.free_symbols for bound in (parameter.lower, parameter.upper))


def _group(title: str, parts: Iterable[Any]) -> Any:
    head = pn.pane.HTML(f"<h3>{title}</h3>", stylesheets=[TEXTS_STYLE], margin=(8, 10, 0, 10))
    return pn.Column(head, *parts, sizing_mode="stretch_width", margin=0)


def _pairs(parts: Iterable[Any]) -> list[Any]:
    """The parts two by two."""
    found = list(parts)
    return [
        pn.Row(*found[i : i + 2], sizing_mode="stretch_width", margin=0)
        for i in range(0, len(found), 2)
    ]


def _panel(title: str, parts: list[Any]) -> Any:
    head = pn.pane.HTML(f"<h2>{title}</h2>", stylesheets=[TEXTS_STYLE], margin=(4, 10))
    return pn.Column(
        head, *parts, sizing_mode="stretch_width", css_classes=["panel"], stylesheets=[STYLE]
    )
