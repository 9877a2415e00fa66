"""The LaTeX engine: found, installed where that is possible, and run on the report."""

import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

ENGINE = "latexmk"
APT_PACKAGES = ("latexmk", "texlive-latex-recommended", "texlive-fonts-recommended", "lmodern")
NO_APT = "LONGWAVE_NO_APT"
LOCKED = 300
"""Seconds in which another apt-get must end."""


class EngineMissingError(RuntimeError):
    """No LaTeX engine is there and none may be installed."""


class CompileError(RuntimeError):
    """LaTeX ran and failed."""


def ensure_engine(say: Callable[[str], None]) -> None:
    """Find latexmk and pdflatex; install them with apt where this process may.

    `say` is told before anything is installed. The environment variable LONGWAVE_NO_APT,
    set to anything but the empty string, forbids installing.

    Raises EngineMissingError, whose one line says what to install.
    """
    if engine_present():
        return
    prefix = apt_prefix()
    if prefix is None:
        raise EngineMissingError(
            f"no LaTeX engine: install {' '.join(APT_PACKAGES)} (or any TeX Live with latexmk)"
        )
    say(f"No LaTeX engine: installing {' '.join(APT_PACKAGES)} with apt-get ({NO_APT}=1 forbids).")
    apt_install(prefix)
    if not engine_present():
        raise EngineMissingError(
            f"no LaTeX engine after apt-get: install {' '.join(APT_PACKAGES)} by hand"
        )


def engine_present() -> bool:
    """Tell whether latexmk and pdflatex are on the path."""
    return all(shutil.which(program) for program in (ENGINE, "pdflatex"))


def apt_prefix() -> list[str] | None:
    """Return the words to put before apt-get, or None where apt may not be used.

    Root needs none; others need sudo that asks for no password.
    """
    if os.environ.get(NO_APT) or shutil.which("apt-get") is None:
        return None
    if os.geteuid() == 0:
        return []
    if shutil.which("sudo") and run_quietly(["sudo", "-n", "true"]).returncode == 0:
        return ["sudo", "-n"]
    return None


def apt_install(prefix: list[str]) -> None:
    """Install the LaTeX packages with apt-get; raise EngineMissingError if that fails.

    Another apt-get, of the machine's own updates say, is waited for.
    """
    install = ["apt-get", "-qq", f"-oDPkg::Lock::Timeout={LOCKED}", "install", "-y"]
    install += ["--no-install-recommends", *APT_PACKAGES]
    for command in (
        [*prefix, "apt-get", "-qq", "update"],
        [*prefix, "env", "DEBIAN_FRONTEND=noninteractive", *install],
    ):
        done = run_quietly(command)
        if done.returncode:
            reason = (done.stderr.strip().splitlines() or ["no message"])[-1]
            raise EngineMissingError(
                f"apt-get failed ({reason}): install {' '.join(APT_PACKAGES)} by hand"
            )


def compile_pdf(tex: Path) -> Path:
    """Run LaTeX on `tex` in its own directory, without shell escape; return the PDF's path.

    Raises CompileError with LaTeX's first error line.
    """
    command = [
        ENGINE,
        "-pdf",
        "-norc",
        "-interaction=nonstopmode",
        "-halt-on-error",
        "-file-line-error",
        "-pdflatex=pdflatex -no-shell-escape %O %S",
        tex.name,
    ]
    done = run_quietly(command, tex.parent)
    if done.returncode:
        raise CompileError(f"LaTeX failed on {tex}: {first_error(tex.with_suffix('.log'))}")
    return tex.with_suffix(".pdf")


def first_error(log: Path) -> str:
    """Return the first error line of a LaTeX log."""
    if not log.exists():
        return "it wrote no log"
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
    errors = (line for line in lines if line.startswith("!") or ".tex:" in line)
    return next(errors, f"see {log}")


def run_quietly(
    command: list[str], directory: Path | None = None
) -> subprocess.CompletedProcess[str]:
    """Run a command without stdin, keeping what it prints."""
    return subprocess.run(
        command,
        cwd=directory,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
