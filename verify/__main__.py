"""``python -m verify``: prove the closed forms, check certificates, or run a scene on the lattice.

Exit status: 0 if every form stands, 1 if one does not, 2 for bad input (one line on stderr).
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence


def main(argv: Sequence[str] | None = None) -> int:
    """Dispatch to a subcommand, or to the table of verdicts; return the exit status."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    command = COMMANDS.get(arguments[0]) if arguments else None
    try:
        return command(arguments[1:]) if command else table_command(arguments)
    except KeyboardInterrupt:
        from derive.command_line import interrupted

        return interrupted(" ".join(["python -m verify", *(arguments[:1] if command else ())]))


def table_command(argv: list[str]) -> int:
    """Print the table of verdicts."""
    from verify.cli.verdicts import verdicts_command

    return verdicts_command(argv)


def certificate_command(argv: list[str]) -> int:
    """Check certificates."""
    from verify.cli.certificates import certificate_command as check

    return check(argv)


def mutations_command(argv: list[str]) -> int:
    """Refute misprints."""
    from verify.cli.mutations import mutations_command as refute

    return refute(argv)


def run_command(argv: list[str]) -> int:
    """Run a scene; numba and xarray are imported here and not for the table."""
    from verify.cli.run import run_command as run_scene

    return run_scene(argv)


def accuracy_command(argv: list[str]) -> int:
    """Print the worst evaluation errors per wave; numba is imported here and not for the table."""
    from verify.cli.accuracy import accuracy_command as measure

    return measure(argv)


COMMANDS: dict[str, Callable[[list[str]], int]] = {
    "accuracy": accuracy_command,
    "check-certificate": certificate_command,
    "mutations": mutations_command,
    "run": run_command,
}


if __name__ == "__main__":
    sys.exit(main())
