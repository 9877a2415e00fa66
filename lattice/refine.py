"""Error estimation: repeat a run with finer steps, more points and a wider domain, and compare.

All numerical choices of a run are one record, `Choices`. A *control run* varies all of them at
once: a shorter step, denser sampling, a wider domain with its ends elsewhere, a weaker absorber.
Its result is the one returned. The estimated error is its difference from the run before, times
``SAFETY`` or the engine's own factor, plus the error that the engine knows both runs to share. This
bounds the error as long as the control run's error is at most two thirds of the other's, for each
choice varied.

That holds only where the step's error obeys its law, step^order. Near the longest stable step it
does not: two steps may have the same error, and so the two runs may agree. Therefore no run is
judged with a step for which the law has not been confirmed: the change by a shorter step must have
fallen, from the change at a longer one, as the order predicts, and is never estimated below that
prediction.

The estimate does not depend on how the choices were found. The search uses scaling laws: the error
of a step falls like step^order, that of a domain like a power of its size. If a control run shows
too large an error, each choice is varied alone to find the cause. This is skipped if only a domain
is chosen besides the step, and the effect of the step is known: the rest is the domain's, until
widening it does not help.

If rounding errors grow above the tolerance, no step size meets it. So when an error stops falling,
and on backgrounds on which perturbations may grow, a run is repeated with the last digits of its
data changed.
"""

import math
from collections.abc import Callable, Collection
from concurrent.futures import CancelledError, ThreadPoolExecutor, wait
from dataclasses import dataclass, replace

from longwave.lattice.trial import (
    SAFETY,
    Choices,
    Engine,
    Kind,
    Progress,
    StoppedTrial,
    Trial,
    difference,
    difference_around,
)
from longwave.support.checkpoint import branches
from longwave.support.compiled.cores import usable_cores
from longwave.support.request_limits import OverBudgetError

Announce = Callable[[float], None]
"""Callback with the expected seconds of the next runs."""

FRACTIONS: dict[Kind, float] = {"step": 0.5, "sampling": 0.2, "domain": 0.3}
"""Fraction of the tolerance allowed for the error of each kind of choice, varied alone."""

TIGHTENING = 1.5
"""Least factor by which to reduce each error if all are within `FRACTIONS` but their sum is not."""

STEP: tuple[Kind, ...] = ("step",)
STEP_AND_DOMAIN: tuple[Kind, ...] = ("step", "domain")

MAX_CONTROL_RUNS = 12
"""Largest number of control runs in one search."""

MAX_BLOW_UPS = 3
"""Number of successive control runs that blow up after which the blow-up counts as physical."""

BLOW_UP_REDUCTION = 32.0
"""Factor by which to reduce all errors after a blow-up."""

MAX_STALLED_RUNS = 3
"""Number of control runs without progress after which rounding is blamed for the remaining
error."""

STALLED_RATIO = 0.7
"""Ratio of an error to the previous one above which it has stopped falling."""

FIRST_DIGIT_FACTOR = 100.0
"""Safety factor on the effect of changed last digits at the longest step: a hundred times that
effect was seen with shorter steps, which round more often (scenes of `searches/estimates.py`)."""

DIGIT_FACTOR = 1.5
"""Factor on the effect of changed last digits on the returned run: it is one sample of the rounding
error (with 1, a test found an error of 1.08 times its estimate)."""

MAX_LAWFUL_RATIO = 3.0
"""Largest ratio of a change, caused by shortening a step, to the change predicted by the law
step^order at which the law counts as confirmed, if the change has also fallen as half of the order
predicts."""

NEGLIGIBLE_FRACTION = 0.01
"""Error due to the step, as a fraction of the tolerance, below which the error may deviate from the
law step^order: it may be rounding."""

MIN_RING_ERROR = 0.05
"""Least error reported on a ring, as a fraction of the tolerance. Runs of a kink whose steps turned
short waves by many radians agreed, with errors of 0.021 of the tolerance
(`tests/scenes/engines/test_comparison_honesty.py`)."""

MIN_ERROR = 1e-5
"""Least error reported for other domains than rings, as a fraction of the tolerance: no run was
examined more closely."""


USUAL_WORK = 4.5
"""Usual work of a search, as a multiple of its first run's work: 3.9 or 4.9 if the first step is
short enough."""


class StoppedSearch(KeyboardInterrupt):
    """Raised on Ctrl-C: the best run, its error if measured, and the seconds of all other runs."""

    def __init__(self, trial: Trial | None, error: float | None, before: float) -> None:
        super().__init__("interrupted")
        self.trial, self.error, self.before = trial, error, before


@dataclass(frozen=True)
class Refined:
    """The last control run, and the estimated error of its values.

    ``error`` covers all numerical choices and rounding; it is infinite if the lattice blows up by
    itself. ``rounding`` is the part of the error due to rounding. ``next_decade`` is the factor by
    which a run with a tenth of the error costs more.
    """

    trial: Trial
    error: float
    rounding: float
    next_decade: float


def refine(
    engine: Engine,
    tolerance: float,
    progress: Progress = lambda _: None,
    announce: Announce = lambda _: None,
) -> Refined:
    """Repeat runs with better choices until the estimated error is at most ``tolerance``.

    ``progress`` is called with the fraction done, 0 .. 1, of the expected work, which is
    ``USUAL_WORK`` or more; ``announce`` with the expected seconds of the next runs. Raises
    ValueError if the error stops falling above the tolerance, StoppedSearch on Ctrl-C.
    """
    search = _Search(engine, tolerance, progress, announce)
    try:
        return _search_choices(search, engine, tolerance)
    except KeyboardInterrupt as stop:
        raise search.stopped(stop) from None


def _search_choices(search: "_Search", engine: Engine, tolerance: float) -> Refined:
    """Search for choices whose control run meets the tolerance."""
    scouting = search.scouting(engine.coarse_engine())
    choices = _with_lawful_step(search, scouting, engine.first())
    search.seconds = scouting.seconds
    best, without_progress, blow_ups = math.inf, 0, 0
    for _ in range(MAX_CONTROL_RUNS):
        trial, control = search.pair(choices)
        rounding = max(trial.rounding, control.rounding)
        step_change = max(difference(trial, control), search.known_change(choices))
        change = max(engine.safety * step_change, SAFETY * scouting.lawful_change(choices))
        least = MIN_RING_ERROR if "sampling" in engine.kinds else MIN_ERROR
        error = max(change + rounding + control.common_error, least * tolerance)
        if error <= tolerance and search.wary:
            digit_effect = DIGIT_FACTOR * search.digit_effect(choices)
            rounding, error = rounding + digit_effect, error + digit_effect
        if error <= tolerance and not scouting.is_lawful(choices):
            shorter = _with_lawful_step(search, scouting, choices)
            if shorter != choices:
                choices = shorter
                continue
        blow_ups = blow_ups + 1 if math.isinf(error) else 0
        if error <= tolerance or blow_ups == MAX_BLOW_UPS:
            decade = 10.0 ** (1.0 / engine.order)
            if not control.choices.causal:
                decade *= 10.0 ** (1.0 / engine.decay)
            return Refined(control, error, rounding, decade)
        search.judged = control, error
        has_fallen = error < STALLED_RATIO * best or math.isinf(error)
        if not has_fallen or search.wary:
            search.check_rounding(choices)
        without_progress = 0 if has_fallen else without_progress + 1
        best = min(best, error)
        # a wider domain may still help: waves round a ring obey no law of the step
        may_widen = "domain" in engine.kinds and not choices.causal
        stalled = 0 if may_widen else scouting.stalled
        is_stuck = MAX_STALLED_RUNS in (without_progress, stalled)
        if is_stuck and math.isfinite(best):
            raise ValueError(
                _refusal_message(best, tolerance, search.leftover_message(choices, rounding, error))
            )
        step_change = scouting.known_change(choices) if has_fallen else 0.0
        choices = search.improved(choices, trial, error, step_change)
    remedy = f"after {MAX_CONTROL_RUNS} control runs, each with better choices"
    raise ValueError(_refusal_message(best, tolerance, remedy))


def _refusal_message(best: float, tolerance: float, left: str) -> str:
    """Return why a tolerance is refused; ``best`` is the least error met, ``left`` its cause."""
    least = f"satisfy tolerance >= {1.05 * best:.2g} here" if best < math.inf else "be larger here"
    return f"tolerance must {least}, got {tolerance:g} ({left}; raise it or shorten the run)"


def _with_lawful_step(search: "_Search", scouting: "_Search", choices: Choices) -> Choices:
    """Return choices with a step that the search ``scouting`` finds accurate and lawful."""
    if scouting is search:
        return search.with_step(choices)
    started = replace(scouting.engine.first(), step=choices.step)
    return replace(choices, step=scouting.with_step(started).step)


class _Search:
    """State of a search: the runs so far, and the laws that give the next choices."""

    def __init__(
        self, engine: Engine, tolerance: float, progress: Progress, announce: Announce
    ) -> None:
        self.engine, self._tolerance = engine, tolerance
        self._progress, self._announce = progress, announce
        self._done: dict[Choices, Trial] = {}
        self._changes: dict[float, float] = {}  # change of the values by shortening each step
        self._longest_lawful = 0.0  # longest step for which the law is confirmed
        self._negligible = NEGLIGIBLE_FRACTION * tolerance / SAFETY
        self._last_share, self._first_work, self._done_work, self._pending_work = 0.0, 0.0, 0.0, 0.0
        self._stopped, self._is_scout = False, False
        self.seconds = 0.0
        self.wary: bool | None = None
        self.stalled = 0
        self.judged: tuple[Trial, float] | None = None

    def scouting(self, scout: Engine) -> "_Search":
        """Return the search that runs the engine ``scout``: this one if it has the same engine."""
        if scout is self.engine:
            return self
        search = _Search(scout, self._tolerance, self._progress, self._announce)
        search._is_scout = True
        return search

    def stopped(self, stop: KeyboardInterrupt) -> StoppedSearch:
        """Return the exception for Ctrl-C, with the last run of known error or another run."""
        if self.judged is not None and math.isfinite(self.judged[1]):
            trial, error = self.judged
            return StoppedSearch(trial, error, self.seconds - trial.seconds)
        finished = [
            trial
            for trial in self._done.values()
            if trial.has_observables and trial.values is not None
        ]
        if finished:
            return StoppedSearch(finished[-1], None, self.seconds - finished[-1].seconds)
        unfinished = (
            stop.trial if isinstance(stop, StoppedTrial) and stop.trial.has_observables else None
        )
        return StoppedSearch(unfinished, None, self.seconds)

    def with_step(self, choices: Choices) -> Choices:
        """Return choices with a step that is accurate enough and obeys step^order, if found."""
        unstable, last, self.stalled = 0, math.inf, 0
        change: float | None = None
        for _ in range(MAX_CONTROL_RUNS):
            excess = self._excess(choices, "step", change)
            if self.wary is None and math.isfinite(excess):
                self.wary = (
                    self.engine.amplifies_rounding
                    and FIRST_DIGIT_FACTOR * self.digit_effect(choices) > self._tolerance
                )
            unstable += math.isinf(excess)
            is_stuck = 1.0 < excess < math.inf and excess > STALLED_RATIO * last
            self.stalled = self.stalled + 1 if is_stuck else 0
            if is_stuck:
                self.check_rounding(choices)
            is_good = excess <= 1.0 and self.is_lawful(choices)
            if is_good or unstable == self.engine.unstable or self.stalled == MAX_STALLED_RUNS:
                break
            last, change = excess, None
            if excess <= 1.0:
                choices = self.engine.control(choices, STEP)
                change = self._lawful_in_wider(choices)
            else:
                choices = self.engine.improved(choices, "step", excess)
            self._done = {one: run for one, run in self._done.items() if one.step <= choices.step}
        return choices

    def _lawful_in_wider(self, choices: Choices) -> float | None:
        """Return the change by these choices' control run; None if it does not confirm the law.

        The control run has a shorter step and a wider domain. If both together change no more than
        the law predicts for the step, a run with a shorter step alone is saved.
        """
        if self._is_scout or self.engine.kinds != STEP_AND_DOMAIN or choices.causal:
            return None
        control = self.engine.control(choices, self.engine.kinds)
        self._run({choices: False, control: True})
        self._drop_payload(choices)
        change = difference(self._done[choices], self._done[control])
        if not change <= self._most_lawful(choices):
            return None
        self._note_change(choices, change)
        return change

    def is_lawful(self, choices: Choices) -> bool:
        """Return whether the law step^order is confirmed for the step of these choices."""
        return self.engine.taken(choices) <= self._longest_lawful

    def lawful_change(self, choices: Choices) -> float:
        """Return the change by a shorter step that the law predicts from a longer step, or 0."""
        step = self.engine.taken(choices)
        longer = [one for one in self._changes.items() if one[0] > step]
        if not longer:
            return 0.0
        other, change = min(longer)
        if change <= self._negligible:
            return change
        return float(change * (step / other) ** self.engine.order)

    def known_change(self, choices: Choices) -> float:
        """Return the change measured by shortening this step; 0 if it was not measured."""
        return self._changes.get(self.engine.taken(choices), 0.0)

    def _note_change(self, choices: Choices, change: float) -> None:
        """Record the change by shortening a step, and whether it confirms the law step^order."""
        if not math.isfinite(change):
            return
        step = self.engine.taken(choices)
        if change <= self._most_lawful(choices):
            self._longest_lawful = max(self._longest_lawful, step)
        self._changes[step] = change

    def _most_lawful(self, choices: Choices) -> float:
        """Return the largest change that confirms the law step^order; -1 without a longer step."""
        step = self.engine.taken(choices)
        longer = min((one for one in self._changes if one > step), default=math.inf)
        if longer == math.inf:
            return -1.0
        slack = min(MAX_LAWFUL_RATIO, (longer / step) ** (self.engine.order / 2.0))
        return max(slack * self.lawful_change(choices), self._negligible)

    def digit_effect(self, choices: Choices) -> float:
        """Return the effect of rounding: ``SAFETY`` times the change by other last digits."""
        nudged = replace(choices, nudged=True)
        self._run({choices: False, nudged: False})
        return SAFETY * difference_around(self._done[choices], self._done[nudged])

    def leftover_message(self, choices: Choices, rounding: float, error: float) -> str:
        """Return why an error has stopped falling, and how much of it is rounding."""
        rounding += DIGIT_FACTOR * self.digit_effect(choices)
        kinds = {"step": "finer steps", "sampling": "denser points", "domain": "wider domains"}
        text = f"{' and '.join(kinds[kind] for kind in self.engine.kinds)} no longer help"
        if rounding > 0.5 * error:
            return f"{text}: of the error of {error:.1g} rounding has grown to {rounding:.1g}"
        return f"{text}, and rounding is only {rounding:.1g} of the error of {error:.1g}"

    def check_rounding(self, choices: Choices) -> None:
        """Raise ValueError if rounding alone exceeds the tolerance, also with a shorter step.

        Near the longest stable step a scheme may amplify perturbations that the lattice does not
        amplify.
        """
        effect = self.digit_effect(choices)
        if self._tolerance < effect < math.inf:
            effect = min(effect, self.digit_effect(self.engine.control(choices, STEP)))
        if self._tolerance < effect < math.inf:
            raise ValueError(
                f"tolerance must satisfy tolerance >= {2.5 * effect:.2g} here, got "
                f"{self._tolerance:g} (neighbouring states of the lattice part so fast that "
                "rounding comes to that much with this step and a shorter one; raise it or shorten "
                "the run)"
            )

    def pair(self, choices: Choices) -> tuple[Trial, Trial]:
        """Return the run with these choices, and its control run with observables."""
        control = self.engine.control(choices, self.engine.kinds)
        self._run({choices: False, control: True})
        self._drop_payload(choices)
        return self._done[choices], self._done.pop(control)

    def _drop_payload(self, choices: Choices) -> None:
        """Discard the payload of a run without observables, to free its memory."""
        trial = self._done[choices]
        if not trial.has_observables:
            self._done[choices] = replace(trial, payload=None)

    def improved(self, choices: Choices, trial: Trial, error: float, step_change: float) -> Choices:
        """Return choices improved in each kind whose error exceeds its share, or else in all kinds.

        ``step_change`` is the known change by a shorter step, 0 if unknown. If the step's error is
        within its share and the domain is the only other choice, the rest of the error is
        attributed to the domain without another run.
        """
        engine, better = self.engine, choices
        if trial.values is None:
            for kind in engine.kinds:
                better = engine.improved(better, kind, BLOW_UP_REDUCTION)
            return better
        domain_share = self._tolerance - engine.safety * step_change
        if step_change and math.isfinite(error) and engine.kinds == STEP_AND_DOMAIN:
            if domain_share >= (1.0 - FRACTIONS["step"]) * self._tolerance:
                better = engine.improved(choices, "domain", max(TIGHTENING, error / domain_share))
            if better != choices:
                return better
        for kind in engine.kinds:
            excess = self._excess(choices, kind)
            if excess > 1.0:
                better = engine.improved(better, kind, excess)
            if kind == "step" and excess * FRACTIONS["step"] > 0.5 * error / self._tolerance:
                break
        if better == choices:
            for kind in engine.kinds:
                better = engine.improved(better, kind, max(TIGHTENING, error / self._tolerance))
        return better

    def _excess(self, choices: Choices, kind: Kind, change: float | None = None) -> float:
        """Return the error due to one kind of choice, divided by the error allowed for it."""
        if change is None:
            change = self._change(choices, kind)
        share = FRACTIONS[kind] if len(self.engine.kinds) > 1 else 1.0
        return SAFETY * change / (share * self._tolerance)

    def _change(self, choices: Choices, kind: Kind) -> float:
        """Return the change of the values when only choices of that kind are refined."""
        other = self.engine.control(choices, (kind,))
        self._run({choices: False, other: False})
        self._drop_payload(choices)
        change = difference(self._done[choices], self._done[other])
        if kind == "step":
            self._note_change(choices, change)
        return change

    def _run(self, requested: dict[Choices, bool]) -> None:
        """Make those ``requested`` runs that are missing; with observables if the value is True."""
        missing = [choices for choices in requested if choices not in self._done]
        self._announce_runs(missing)

        def run(choices: Choices) -> Trial:
            return self.engine.run(choices, requested[choices], self._report_progress)

        threads = min(self.engine.threads, usable_cores())
        if threads == 1:
            for choices in missing:
                self._record(choices, run(choices))
            return
        with ThreadPoolExecutor(threads) as pool:
            pairs = zip(missing, branches(len(missing)), strict=True)
            started = {one: pool.submit(context.run, run, one) for one, context in pairs}
            try:
                wait(started.values())
            except KeyboardInterrupt:
                self._stopped = True
                pool.shutdown(cancel_futures=True)
        stops = []
        for choices, future in started.items():
            try:
                self._record(choices, future.result())
            except StoppedTrial as stop:
                stops.append(stop)
            except CancelledError:
                continue
        if self._stopped:
            raise max(stops, key=lambda one: one.trial.has_observables, default=KeyboardInterrupt())

    def _record(self, choices: Choices, trial: Trial) -> None:
        """Record a finished run, its work and its seconds."""
        self._done[choices] = trial
        self._done_work += trial.work
        self._first_work = self._first_work or trial.work
        self._pending_work = max(0.0, self._pending_work - trial.work)
        self.seconds += trial.seconds

    def _report_progress(self, fraction: float) -> None:
        """Report the whole search's progress, given the fraction done of the pending runs."""
        if self._stopped:
            raise KeyboardInterrupt
        usual = USUAL_WORK * (self._first_work or self._pending_work)
        whole = max(usual, self._done_work + self._pending_work)
        done = (self._done_work + fraction * self._pending_work) / whole if whole else fraction
        self._last_share = max(self._last_share, min(done, 1.0))
        self._progress(self._last_share)

    def _announce_runs(self, missing: Collection[Choices]) -> None:
        """Announce the seconds that missing runs take; raise OverBudgetError if too many."""
        self._pending_work = pending = sum(map(self.engine.work, missing))
        if pending > self.engine.most_work:
            raise OverBudgetError(f"runs that take {pending:.2g}", pending)
        spent = sum(trial.seconds for trial in self._done.values())
        work = sum(trial.work for trial in self._done.values())
        if work > 0.0:
            self._announce(spent / work * pending)
