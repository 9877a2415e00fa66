"""The LaTeX engine: look for it and run it on the report. Nothing is installed here."""

import shutil
import subprocess
from pathlib import Path

ENGINE = "latexmk"
"""Program that runs LaTeX as often as cross-references need."""

APT_PACKAGES = ("latexmk", "texlive-latex-recommended", "texlive-fonts-recommended", "lmodern")
"""Debian and Ubuntu packages that contain the engine; `make latex` installs them."""


class EngineMissingError(RuntimeError):
    """No LaTeX engine is installed."""


class CompileError(RuntimeError):
    """LaTeX ran and failed."""


def ensure_engine() -> None:
    """Raise EngineMissingError, with the packages to install, if latexmk or pdflatex is missing."""
    if not engine_present():
        raise EngineMissingError(
            f"no LaTeX engine: install {' '.join(APT_PACKAGES)} (or any TeX Live with latexmk)"
        )


def engine_present() -> bool:
    """Return whether latexmk and pdflatex are on the path."""
    return all(shutil.which(program) for program in (ENGINE, "pdflatex"))


def compile_pdf(tex: Path) -> Path:
    """Run LaTeX on `tex` in its folder; return the PDF's path, or raise CompileError."""
    options = ["-pdf", "-norc", "-interaction=nonstopmode", "-halt-on-error", "-file-line-error"]
    safe = "-pdflatex=pdflatex -no-shell-escape %O %S"
    done = run_quietly([ENGINE, *options, safe, tex.name], tex.parent)
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
    """Run a command without stdin, capturing its output."""
    return subprocess.run(
        command,
        cwd=directory,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
