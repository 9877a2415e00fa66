"""``longwave plot``: check where the picture goes before anything of it is imported."""

from __future__ import annotations

from typing import Any

from longwave.support.command_line import fail
from longwave.support.console import check_output, default_output, picture_path


def plot_and_print(
    source: str, program: str, *, output: str | None = None, force: bool = False, **options: Any
) -> int:
    """Draw a run, a scene or a sweep, and print the picture's path; return the exit status."""
    path = default_output(source) if output is None else output
    try:
        check_output(path, "run.png", force=force)
        picture_path(path)
    except (ValueError, OSError) as error:
        return fail(error)
    from longwave.reports.pictures.plotting import draw  # Matplotlib, half a second

    return draw(source, path, program, **options)
