"""The step of a build that puts the text of compiled kernels into the package.

`longwave.support.compiled.shipped_kernels` says what for. A build never fails for it: where numba
cannot be imported, or cannot compile, nothing is put there, and the first run compiles as it does
in a checkout.
"""

import subprocess
import sys
from pathlib import Path

from setuptools.command.build_py import build_py

WRITE = """
import sys
sys.path.insert(0, sys.argv[1])
from longwave.support.compiled.kernel_writer import write_kernels
print(write_kernels(), "compiled kernels come with the package")
"""

LONGEST = 300.0
"""Seconds after which a build goes on without kernels. They take 15 s of a processor."""


class BuildWithKernels(build_py):
    """Copy the package's files, then have the copy write the text of its kernels."""

    def run(self) -> None:
        """Build the package. An editable installation has no copy and gets no kernels."""
        super().run()
        if not self.editable_mode:
            self.write_kernels()

    def write_kernels(self) -> None:
        """Write the kernels' text in a process of its own, or warn that there is none, and why."""
        built = str(Path(self.build_lib).absolute())
        command = [sys.executable, "-P", "-B", "-c", WRITE, built]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=LONGEST, check=False
            )
            failed, reason = done.returncode != 0, done.stderr
        except (OSError, subprocess.TimeoutExpired) as error:
            failed, reason = True, str(error)
        if failed:
            [last] = reason.strip().splitlines()[-1:] or ["no reason given"]
            self.warn(f"no compiled kernels in the package, the first run makes them: {last}")
        else:
            self.announce(done.stdout.strip(), level=2)
