"""``python -m verify``: the words of `longwave.verify.cli.commands`.

Exit status: 0 if every form stands, 1 if one does not, 2 for bad input (one line on stderr).
"""

import sys
from collections.abc import Sequence

from longwave.derive.command_line import run_words
from longwave.verify.cli.commands import verify


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit status."""
    return run_words(verify, "python -m verify", argv)


if __name__ == "__main__":
    sys.exit(main())
