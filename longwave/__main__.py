"""Entry point of the command `longwave`, including shell completion."""

import os
import sys
from collections.abc import Sequence

from longwave.support.interruption import interruptible


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit status, as `run_words` does."""
    return interruptible("longwave", lambda: _main(argv), argv is None)


def _main(argv: Sequence[str] | None) -> int:
    from click.shell_completion import shell_complete  # imported late: Ctrl-C is handled by then

    from longwave.cli.command_tree import COMPLETION, longwave
    from longwave.support.command_line import run_words

    if COMPLETION in os.environ:
        return shell_complete(longwave, {}, "longwave", COMPLETION, os.environ[COMPLETION])
    words = sys.argv[1:] if argv is None else argv
    return run_words(longwave, "longwave", argv if words else ["--help"])


if __name__ == "__main__":
    sys.exit(main())
