"""``python -m verify``: the command `verify` of `longwave.cli.commands`.

Exit status: 0 if every form is verified, 1 if one is not, 2 for bad input (one line on stderr).
"""

import sys
from collections.abc import Sequence

from longwave.cli.commands import verify
from longwave.support.command_line import run_words


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit status."""
    return run_words(verify, "python -m verify", argv)


if __name__ == "__main__":
    sys.exit(main())
