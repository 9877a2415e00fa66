"""The command `longwave`: what the words of `longwave.commands` end with.

Exit status: 0 if all is well; 1 if something is refuted, undecided, rejected, missing or did not
come to its end; 2 for wrong input, told in one line; 130 after Ctrl-C; 141 if the reader of the
output has gone.
"""

import os
import sys
from collections.abc import Sequence

from click.shell_completion import shell_complete

from derive.command_line import run_command
from longwave.commands import COMPLETION, longwave


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit status."""
    if COMPLETION in os.environ:
        return shell_complete(longwave, {}, "longwave", COMPLETION, os.environ[COMPLETION])
    words = list(sys.argv[1:] if argv is None else argv)
    return run_command(longwave, "longwave", words or ["--help"])


if __name__ == "__main__":
    sys.exit(main())
