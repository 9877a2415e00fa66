"""What is left of a run that Ctrl-C ended."""

from collections.abc import Callable

import xarray as xr

LONG = 10.0
"""Seconds from which work is announced."""


class UnfinishedRun(KeyboardInterrupt):
    """Ctrl-C during a run, which had recorded something: ``run``.

    The run's attribute ``unfinished`` says why it is not what the scene asks for.
    """

    def __init__(self, run: xr.Dataset) -> None:
        super().__init__("interrupted")
        self.run = run


def unfinished(
    run: xr.Dataset | None, error: float | None, planning_seconds: float
) -> KeyboardInterrupt:
    """The best run of a search that Ctrl-C ended; ``error`` is its estimated one, if measured."""
    if run is None:
        return KeyboardInterrupt("before anything was recorded")
    found = run.assign_attrs(planning_seconds=planning_seconds)
    why = run.attrs.get("unfinished", "Ctrl-C before the tolerance was met")
    if error is None:
        found.attrs["unfinished"] = f"{why}, its error not estimated"
    else:
        found.attrs |= {"unfinished": why, "error_estimate": error}
    return UnfinishedRun(found)


class Announcer:
    """Passes on how many seconds are expected, if they are many and not what was said before.

    >>> told = Announcer(print)
    >>> for seconds in (3.0, 30.0, 40.0, 90.0):
    ...     told(seconds)
    30.0
    90.0
    """

    def __init__(self, announce: Callable[[float], None]) -> None:
        self._announce = announce
        self._said = LONG / 2.0

    def __call__(self, seconds: float) -> None:
        """Announce work to come."""
        if seconds >= max(LONG, 2.0 * self._said):
            self._said = seconds
            self._announce(seconds)
