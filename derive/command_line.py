"""What the commands of all rooms share: wrong words are told in one line, with exit status 2."""

import argparse
import sys
from typing import NoReturn


class OneLineParser(argparse.ArgumentParser):
    """An argument parser whose errors are one line on stderr and exit status 2."""

    def error(self, message: str) -> NoReturn:
        """Print ``error: message (see ... --help)`` and stop."""
        fail(f"{message} (see {self.prog} --help)")
        sys.exit(2)


def fail(message: object) -> int:
    """Print ``error: message`` in one line on stderr; return the exit status 2."""
    print(f"error: {' '.join(str(message).split())}", file=sys.stderr)
    return 2
