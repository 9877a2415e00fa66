"""The one judge of a run's error: run again, finer, wider and elsewhere, and compare.

Everything that is chosen about a run is one record, `Choices`. A *control* run varies all of it at
once: a shorter step, a denser sampling, a wider domain with its ends elsewhere, a weaker absorber.
Its result is the one that is given; what separates it from the run before it, times ``SAFETY`` or
what the engine calls for, is its estimated error, with what the engine knows that both runs do
alike. That bounds the error as soon as the control run is no worse than two thirds of the run
before it, in each of the things that were varied.

That is so only where the error of the step obeys its law, step^order. Near the longest stable step
it does not: there the errors of two steps may agree, and so may the runs. So no run is judged by a
step at which the law has not been seen: what a shorter step changes must have fallen from what it
changed at a longer one as the order says, and is not believed to be less than that.

How the choices are come by does not matter for that. They are searched for by laws: the error of a
step falls like step^order, that of a domain like a power of its size. Where a control run says
that it is not enough, each of the choices is varied by itself, to see which one it is; but not
where only a domain is chosen beside the step, and what the step changes is known: the rest is the
domain's, until widening it does not help.

No step helps where the lattice amplifies rounding above the tolerance. So where an error ceases to
fall, and on backgrounds about which perturbations may grow, a run is done again with the last
digits of its data changed.
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
"""Called with the seconds that the runs to come are expected to take, however few."""

SHARES: dict[Kind, float] = {"step": 0.5, "sampling": 0.2, "domain": 0.3}
"""Shares of the tolerance, where each of the choices is varied by itself."""

TIGHTER = 1.5
"""By how much all errors are to fall where each keeps its share and their sum does not."""

STEP: tuple[Kind, ...] = ("step",)
STEP_AND_DOMAIN: tuple[Kind, ...] = ("step", "domain")

ATTEMPTS = 12
"""Most control runs."""

BLOWN = 3
"""Control runs after which a lattice that still blows up does so by itself."""

CURE = 32.0
"""By how much all errors are to fall after a blow-up."""

PATIENCE = 3
"""Control runs without progress after which rounding is what is left."""

PROGRESS = 0.7
"""An error that is more than this share of the one before it has ceased to fall."""

WARY = 100.0
"""Factor on what the nudge changes with the longest step: a hundred times as much was seen with
shorter ones, whose roundings are more (scenes of `searches/estimates.py`)."""

DRAWN = 1.5
"""Factor on what the nudge changes of the run that is shown: it is one draw of what rounding grows
to (with 1 an opponent met an error of 1.08 times its estimate)."""

LAWFUL = 3.0
"""What a step changes obeys its law if it is at most this much larger than the law has it, and has
fallen as half of the order would have it."""

NEGLIGIBLE = 0.01
"""Share of the tolerance below which the change of a step needs obey no law, for it may be rounding
or what comes round a ring."""

LEAST_ON_RING = 0.05
"""Least share of the tolerance that an error is told as on a ring. There negligible changes
hid errors of 0.021 of it: the steps of a kink that turned short waves by many radians agreed
(`tests/scenes/engines/test_comparison_honesty.py`)."""

LEAST = 1e-5
"""Least share that an error is told as elsewhere: no run was looked at more closely."""


USUAL_WORK = 4.5
"""Work of a search, in units of its first run's: 3.9 or 4.9 where that run's step will do."""


class StoppedSearch(KeyboardInterrupt):
    """Ctrl-C during the search: its best run, if any can be shown, and the seconds of all others.

    ``error`` is what its error is estimated at, above the tolerance; None if it was not measured.
    """

    def __init__(self, trial: Trial | None, error: float | None, before: float) -> None:
        super().__init__("interrupted")
        self.trial, self.error, self.before = trial, error, before


@dataclass(frozen=True)
class Refined:
    """The last control run, and by how much y/eps is estimated to miss the infinite lattice's.

    ``error`` stands for everything that was chosen, and for rounding, whose part is ``rounding``;
    it is infinite if the lattice blows up by itself. ``next_decade`` is the factor by which ten
    times more accuracy costs more.
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
    """Run until the estimated error is at most ``tolerance``.

    ``progress`` is called with the share of the work that is done, 0 .. 1, of ``USUAL_WORK`` or
    what is known to be more. Raises ValueError if the tolerance cannot be reached: the error
    ceases to fall above it; StoppedSearch on Ctrl-C.
    """
    search = _Search(engine, tolerance, progress, announce)
    try:
        return _refined(search, engine, tolerance)
    except KeyboardInterrupt as stop:
        raise search.stopped(stop) from None


def _refined(search: "_Search", engine: Engine, tolerance: float) -> Refined:
    scouting = search.scouting(engine.coarse_engine())
    choices = _followed(search, scouting, engine.first())
    search.seconds = scouting.seconds
    best, since, blown = math.inf, 0, 0
    for _ in range(ATTEMPTS):
        trial, control = search.pair(choices)
        rounding = max(trial.rounding, control.rounding)
        seen = max(difference(trial, control), search.seen_change(choices))
        change = max(engine.safety * seen, SAFETY * scouting.lawful_change(choices))
        least = LEAST_ON_RING if "sampling" in engine.kinds else LEAST
        error = max(change + rounding + control.common_error, least * tolerance)
        if error <= tolerance and search.wary:
            grown = DRAWN * search.grown(choices)
            rounding, error = rounding + grown, error + grown
        if error <= tolerance and not scouting.has_seen_law(choices):
            shorter = _followed(search, scouting, choices)
            if shorter != choices:
                choices = shorter
                continue
        blown = blown + 1 if math.isinf(error) else 0
        if error <= tolerance or blown == BLOWN:
            decade = 10.0 ** (1.0 / engine.order)
            if not control.choices.causal:
                decade *= 10.0 ** (1.0 / engine.decay)
            return Refined(control, error, rounding, decade)
        search.judged = control, error
        fell = error < PROGRESS * best or math.isinf(error)
        if not fell or search.wary:
            search.check_rounding(choices)
        since = 0 if fell else since + 1
        best = min(best, error)
        stuck = since == PATIENCE or (
            scouting.stalled == PATIENCE and not _may_widen(engine, choices)
        )
        if stuck and math.isfinite(best):
            raise ValueError(_refusal(best, tolerance, search.left(choices, rounding, error)))
        seen = scouting.seen_change(choices) if fell else 0.0
        choices = search.improved(choices, trial, error, seen)
    left = f"after {ATTEMPTS} control runs, each with better choices"
    raise ValueError(_refusal(best, tolerance, left))


def _refusal(best: float, tolerance: float, left: str) -> str:
    """Why a tolerance is refused; ``left`` is what keeps the error at ``best``, inf if unknown."""
    least = f"satisfy tolerance >= {1.05 * best:.2g} here" if best < math.inf else "be larger here"
    return f"tolerance must {least}, got {tolerance:g} ({left}; raise it or shorten the run)"


def _may_widen(engine: Engine, choices: Choices) -> bool:
    """Whether a wider domain may still help: what comes round a ring obeys no law of the step."""
    return "domain" in engine.kinds and not choices.causal


def _followed(search: "_Search", scouting: "_Search", choices: Choices) -> Choices:
    """The choices with the longest step, from theirs on, that the scout finds good and lawful."""
    if scouting is search:
        return search.with_step(choices)
    begun = replace(scouting.engine.first(), step=choices.step)
    return replace(choices, step=scouting.with_step(begun).step)


class _Search:
    """The runs so far, and the laws by which the next choices are made."""

    def __init__(
        self, engine: Engine, tolerance: float, progress: Progress, announce: Announce
    ) -> None:
        self.engine, self._tolerance = engine, tolerance
        self._progress, self._announce = progress, announce
        self._done: dict[Choices, Trial] = {}
        self._changes: dict[float, float] = {}  # what was changed by shortening each step
        self._lawful = 0.0  # the longest step of which the law was seen
        self._negligible = NEGLIGIBLE * tolerance / SAFETY
        self._shown, self._first_work, self._worked, self._asked = 0.0, 0.0, 0.0, 0.0
        self._stopped, self._is_scout = False, False
        self.seconds = 0.0
        self.wary: bool | None = None
        self.stalled = 0
        self.judged: tuple[Trial, float] | None = None

    def scouting(self, scout: Engine) -> "_Search":
        """A search by another engine, for the same tolerance; itself, if that is its own."""
        if scout is self.engine:
            return self
        found = _Search(scout, self._tolerance, self._progress, self._announce)
        found._is_scout = True
        return found

    def stopped(self, stop: KeyboardInterrupt) -> StoppedSearch:
        """The last run whose error was measured, or the last that can be shown, or what was begun.

        Runs whose error is not known come from the first control run, or from what led to it.
        """
        if self.judged is not None and math.isfinite(self.judged[1]):
            trial, error = self.judged
            return StoppedSearch(trial, error, self.seconds - trial.seconds)
        known = [trial for trial in self._done.values() if trial.shown and trial.values is not None]
        if known:
            return StoppedSearch(known[-1], None, self.seconds - known[-1].seconds)
        begun = stop.trial if isinstance(stop, StoppedTrial) and stop.trial.shown else None
        return StoppedSearch(begun, None, self.seconds)

    def with_step(self, choices: Choices) -> Choices:
        """Choices whose step keeps its share and was seen to obey its law, if there are any."""
        unstable, last, self.stalled = 0, math.inf, 0
        change: float | None = None
        for _ in range(ATTEMPTS):
            excess = self._excess(choices, "step", change)
            if self.wary is None and math.isfinite(excess):
                self.wary = (
                    self.engine.amplifies_rounding and WARY * self.grown(choices) > self._tolerance
                )
            unstable += math.isinf(excess)
            stuck = 1.0 < excess < math.inf and excess > PROGRESS * last
            self.stalled = self.stalled + 1 if stuck else 0
            if stuck:
                self.check_rounding(choices)
            kept = excess <= 1.0 and self.has_seen_law(choices)
            if kept or unstable == self.engine.unstable or self.stalled == PATIENCE:
                break
            last, change = excess, None
            if excess <= 1.0:
                choices = self.engine.control(choices, STEP)
                change = self._lawful_in_wider(choices)
            else:
                choices = self.engine.improved(choices, "step", excess)
            self._forget_longer(choices.step)
        return choices

    def _lawful_in_wider(self, choices: Choices) -> float | None:
        """What the run changes that is to control these choices, if the law is seen by that.

        It has a wider domain, too: where both change no more than the law has it of the step, a run
        with a shorter step alone is spared. None where it is to be made.
        """
        if self._is_scout or self.engine.kinds != STEP_AND_DOMAIN or choices.causal:
            return None
        control = self.engine.control(choices, self.engine.kinds)
        self._run({choices: False, control: True})
        self._keep_values_alone(choices)
        change = difference(self._done[choices], self._done[control])
        if not change <= self._most_lawful(choices):
            return None
        self._note_change(choices, change)
        return change

    def _forget_longer(self, step: float) -> None:
        """Let go of runs with longer steps, which are not compared with any more."""
        for choices in [one for one in self._done if one.step > step]:
            del self._done[choices]

    def has_seen_law(self, choices: Choices) -> bool:
        """Whether what such a step changes has fallen by the law, or is next to nothing."""
        return self.engine.taken(choices) <= self._lawful

    def lawful_change(self, choices: Choices) -> float:
        """What the step changes at least, going by the nearest longer one that was tried.

        What is next to nothing may be rounding, or what comes round a ring, and obeys no law.
        """
        step = self.engine.taken(choices)
        longer = [one for one in self._changes.items() if one[0] > step]
        if not longer:
            return 0.0
        other, change = min(longer)
        if change <= self._negligible:
            return change
        return float(change * (step / other) ** self.engine.order)

    def seen_change(self, choices: Choices) -> float:
        """What this engine has seen that such a step changes; 0 if it has not looked."""
        return self._changes.get(self.engine.taken(choices), 0.0)

    def _note_change(self, choices: Choices, change: float) -> None:
        """Keep what a step changes, and whether it is what the law expects."""
        if not math.isfinite(change):
            return
        step = self.engine.taken(choices)
        if change <= self._most_lawful(choices):
            self._lawful = max(self._lawful, step)
        self._changes[step] = change

    def _most_lawful(self, choices: Choices) -> float:
        """The most that such a step may change for its law to be seen; less than 0 if none was."""
        step = self.engine.taken(choices)
        longer = min((one for one in self._changes if one > step), default=math.inf)
        if longer == math.inf:
            return -1.0
        slack = min(LAWFUL, (longer / step) ** (self.engine.order / 2.0))
        return max(slack * self.lawful_change(choices), self._negligible)

    def grown(self, choices: Choices) -> float:
        """What rounding has come to: ``SAFETY`` times what changes with the data's last digits."""
        nudged = replace(choices, nudged=True)
        self._run({choices: False, nudged: False})
        return SAFETY * difference_around(self._done[choices], self._done[nudged])

    def left(self, choices: Choices, rounding: float, error: float) -> str:
        """What is left of an error that has ceased to fall, as far as it was measured."""
        rounding += DRAWN * self.grown(choices)
        kinds = {"step": "finer steps", "sampling": "denser points", "domain": "wider domains"}
        told = f"{' and '.join(kinds[kind] for kind in self.engine.kinds)} no longer help"
        if rounding > 0.5 * error:
            return f"{told}: of the error of {error:.1g} rounding has grown to {rounding:.1g}"
        return f"{told}, and rounding is only {rounding:.1g} of the error of {error:.1g}"

    def check_rounding(self, choices: Choices) -> None:
        """Raise ValueError if rounding alone comes to more than the tolerance.

        With a shorter step, too: near the longest stable one a scheme may amplify what the lattice
        does not.
        """
        grown = self.grown(choices)
        if self._tolerance < grown < math.inf:
            grown = min(grown, self.grown(self.engine.control(choices, STEP)))
        if self._tolerance < grown < math.inf:
            raise ValueError(
                f"tolerance must satisfy tolerance >= {2.5 * grown:.2g} here, got "
                f"{self._tolerance:g} (neighbouring states of the lattice part so fast that "
                "rounding comes to that much with this step and a shorter one; raise it or shorten "
                "the run)"
            )

    def pair(self, choices: Choices) -> tuple[Trial, Trial]:
        """The run with these choices and its control, which is shown."""
        control = self.engine.control(choices, self.engine.kinds)
        self._run({choices: False, control: True})
        self._keep_values_alone(choices)
        return self._done[choices], self._done.pop(control)

    def _keep_values_alone(self, choices: Choices) -> None:
        """Let go of what else there is of a run that others control, if it cannot be shown."""
        trial = self._done[choices]
        if not trial.shown:
            self._done[choices] = replace(trial, payload=None)

    def improved(self, choices: Choices, trial: Trial, error: float, seen: float) -> Choices:
        """Better choices: in what exceeds its share when it is varied by itself, or in all.

        ``seen`` is what a shorter step is known to change, 0 if it is not. Where that keeps its
        share, and there is but the domain beside, nothing need be varied: the rest is the domain's.
        """
        engine, found = self.engine, choices
        if trial.values is None:
            for kind in engine.kinds:
                found = engine.improved(found, kind, CURE)
            return found
        left = self._tolerance - engine.safety * seen
        if seen and math.isfinite(error) and engine.kinds == STEP_AND_DOMAIN:
            if left >= (1.0 - SHARES["step"]) * self._tolerance:
                found = engine.improved(choices, "domain", max(TIGHTER, error / left))
            if found != choices:
                return found
        for kind in engine.kinds:
            excess = self._excess(choices, kind)
            if excess > 1.0:
                found = engine.improved(found, kind, excess)
            if kind == "step" and excess * SHARES["step"] > 0.5 * error / self._tolerance:
                break
        if found == choices:
            for kind in engine.kinds:
                found = engine.improved(found, kind, max(TIGHTER, error / self._tolerance))
        return found

    def _excess(self, choices: Choices, kind: Kind, change: float | None = None) -> float:
        """By how much the error is above its share when that kind alone is varied.

        What that changes is measured if it is not told.
        """
        if change is None:
            change = self._change(choices, kind)
        share = SHARES[kind] if len(self.engine.kinds) > 1 else 1.0
        return SAFETY * change / (share * self._tolerance)

    def _change(self, choices: Choices, kind: Kind) -> float:
        """What is changed where that kind alone is varied."""
        other = self.engine.control(choices, (kind,))
        self._run({choices: False, other: False})
        self._keep_values_alone(choices)
        change = difference(self._done[choices], self._done[other])
        if kind == "step":
            self._note_change(choices, change)
        return change

    def _run(self, wanted: dict[Choices, bool]) -> None:
        missing = [choices for choices in wanted if choices not in self._done]
        self._tell(missing)

        def run(choices: Choices) -> Trial:
            return self.engine.run(choices, wanted[choices], self._share)

        threads = min(self.engine.threads, usable_cores())
        if threads == 1:
            for choices in missing:
                self._keep(choices, run(choices))
            return
        with ThreadPoolExecutor(threads) as pool:
            places = zip(missing, branches(len(missing)), strict=True)
            begun = {one: pool.submit(place.run, run, one) for one, place in places}
            try:
                wait(begun.values())
            except KeyboardInterrupt:
                self._stopped = True
                pool.shutdown(cancel_futures=True)
        stops = []
        for choices, future in begun.items():
            try:
                self._keep(choices, future.result())
            except StoppedTrial as stop:
                stops.append(stop)
            except CancelledError:
                continue
        if self._stopped:
            raise max(stops, key=lambda stop: stop.trial.shown, default=KeyboardInterrupt())

    def _keep(self, choices: Choices, trial: Trial) -> None:
        self._done[choices] = trial
        self._worked += trial.work
        self._first_work = self._first_work or trial.work
        self._asked = max(0.0, self._asked - trial.work)
        self.seconds += trial.seconds

    def _share(self, share: float) -> None:
        if self._stopped:
            raise KeyboardInterrupt
        usual = USUAL_WORK * (self._first_work or self._asked)
        whole = max(usual, self._worked + self._asked)
        done = (self._worked + share * self._asked) / whole if whole else share
        self._shown = max(self._shown, min(done, 1.0))
        self._progress(self._shown)

    def _tell(self, missing: Collection[Choices]) -> None:
        """Announce runs that will take long, going by what those before them took.

        Raises OverBudgetError for more than the engine is given.
        """
        self._asked = asked = sum(map(self.engine.work, missing))
        if asked > self.engine.most_work:
            raise OverBudgetError(f"runs that take {asked:.2g}", asked)
        spent = sum(trial.seconds for trial in self._done.values())
        work = sum(trial.work for trial in self._done.values())
        if work > 0.0:
            self._announce(spent / work * asked)
