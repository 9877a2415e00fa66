"""The command `longwave`: one word, then what that room's own command takes."""

import sys
from collections.abc import Callable
from importlib import import_module

from longwave import __version__

Command = Callable[[list[str]], int]

_COMMANDS: dict[str, tuple[str, str, str]] = {
    "derive": ("derive.__main__", "main", "derive the reduced equation and its coefficients"),
    "verify": ("verify.__main__", "main", "prove every closed form"),
    "run": ("verify.lattice.cli", "run_command", "run the lattice on a scene (TOML file or name)"),
    "report": ("reports.__main__", "main", "write the report, longwave-report/longwave.pdf"),
}


def usage() -> str:
    """Return the help text.

    >>> usage().splitlines()[0]
    'usage: longwave COMMAND [ARGUMENTS]'
    """
    lines = [f"  {word:8}{says}" for word, (_, _, says) in _COMMANDS.items()]
    head = ["usage: longwave COMMAND [ARGUMENTS]", "", "commands:"]
    return "\n".join([*head, *lines, "", "`longwave COMMAND --help` says more; --version."])


def main(argv: list[str] | None = None) -> int:
    """Run the command line; return its exit status (2 for a command that does not exist)."""
    word, *rest = (sys.argv[1:] if argv is None else argv) or ["--help"]
    if word in ("-h", "--help"):
        print(usage())
        return 0
    if word == "--version":
        print(f"longwave {__version__}")
        return 0
    if word not in _COMMANDS:
        known = ", ".join(_COMMANDS)
        given = " ".join(word.split())
        print(f"error: COMMAND must be a known one, got {given} (one of {known})", file=sys.stderr)
        return 2
    try:
        return command(word)(rest)
    except KeyboardInterrupt:
        print(f"longwave {word}: interrupted", file=sys.stderr)
        return 130


def command(word: str) -> Command:
    """Import the function behind the command word."""
    module, function, _ = _COMMANDS[word]
    found: Command = getattr(import_module(module), function)
    return found


if __name__ == "__main__":
    sys.exit(main())
