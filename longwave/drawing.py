"""The work of `longwave plot`: a run drawn into a file, or a scene that is run first."""

from contextlib import suppress
from pathlib import Path

from derive.command_line import fail, interrupted
from longwave.plotting import plot
from verify.cli.run import check_output, plain_console, progress_bar
from verify.comparison.recording import UnfinishedRun


def draw(source: str, output: str | None, kind: str, program: str) -> int:
    """Draw and print the picture's path; return the exit status.

    0, 2 for wrong input, 130 after Ctrl-C, which ``program`` tells: what was run is drawn.
    """
    path = default_output(source) if output is None else output
    errors = plain_console(stderr=True, soft_wrap=True)
    try:
        check_output(path, "run.png")
        with progress_bar(Path(source).name, source, errors) as (advance, tell):
            plot(source, path, kind, advance, tell)
    except UnfinishedRun as stop:
        with suppress(ValueError, OSError):
            plot(stop.run, path, kind)
            return interrupted(program, f"what was run until then is in {path}")
        return interrupted(program, "too little was run to be drawn")
    except KeyboardInterrupt:
        return interrupted(program, "nothing was drawn yet")
    except (ValueError, OSError) as error:
        return fail(error)
    except MemoryError as error:
        return fail(f"sites must fit the memory, got a scene that does not: {error} (take fewer)")
    print(path)
    return 0


def default_output(source: str) -> str:
    """The picture's file in the working folder, named after the run or scene.

    >>> default_output("runs/rogue_cn_k_0.5.nc"), default_output("rogue_cn_k_0.5")
    ('rogue_cn_k_0.5.png', 'rogue_cn_k_0.5.png')
    """
    return f"{Path(source).name.removesuffix('.nc').removesuffix('.toml')}.png"
