"""Every name that an output of `longwave derive` may have, as a constant of a lattice.

    python -m searches.output_names

A name that the output gives a value to, ``name = ...``, or lists among the terms of an equation
must not be a constant's.  The judge reads the printed lines alone.  Exit status 1 for a collision.
"""

from __future__ import annotations

import re
import string
import sys
import tempfile
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

from longwave.derive.__main__ import main as derive

FURTHER = (
    *("F0", "F1", "F2", "F3", "F1a", "F2a", "F2b", "G2", "G4", "R5", "R7", "omega", "a1", "a2"),
    *("a3", "mean", "second", "detuning", "loss", "drift", "Gamma", "gamma", "ybar", "xi", "tau"),
    *("sin", "exp", "sign", "Abs", "mass", "pi", "eps"),
)
NAMES = (*string.ascii_letters, *FURTHER)
"""Every letter, and what outputs call their own."""

SHAPES = {
    "polynomial": "{0}*x + 2*x**2 + x**3",
    "power": "-{0}*(1 + x)**(-3)",
    "exponential": "{0}*sinh({0}*x)",
}
REFUSED = re.compile(
    r"error: .*(must have names other|must not be a constant of|must name constants|expected )"
)
"""Refusals in one line that say which name is in the way."""


def document(name: str, law: str, *, pinned: bool) -> str:
    """Return a chain with a constant of that name, as a file."""
    force = SHAPES[law].format(name)
    tie = '[[site]]\nfield = "f"\nforce = "x + x**3"\n' if pinned else ""
    field = "f" if name != "f" else "g"
    spring = f'[[spring]]\nbetween = ["{field}[n]", "{field}[n+1]"]\nforce = "{force}"\n'
    return f'fields = ["{field}"]\npositive = ["{name}"]\n{spring}{tie}'.replace(
        '"f"', f'"{field}"'
    )


def printed(words: list[str]) -> tuple[int, str]:
    """Return the exit status and what a command prints, errors included."""
    out = StringIO()
    with redirect_stdout(out), redirect_stderr(out):
        status = derive(words)
    return status, out.getvalue()


def collisions(name: str) -> Iterator[str]:
    """Yield the collisions with a constant of this name, one a command."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "chain.toml"
        for law in SHAPES:
            for words in ([], ["--envelope", "k=pi"], ["--envelope", "k"]):
                path.write_text(document(name, law, pinned=bool(words) and law == "polynomial"))
                status, text = printed([str(path), *words])
                if status:
                    if not REFUSED.match(text):
                        yield f"{law} {words}: {text.strip()}"
                    continue
                own = re.findall(r"^\s*(?:where )?([A-Za-z][A-Za-z0-9]*) = ", text, re.MULTILINE)
                kinds = r"^(?:carrier|normal form|ansatz|  X =|i A).*$"
                heads = re.findall(kinds, text, re.MULTILINE)
                head = " ".join(heads).replace("c.c.", "")
                words_of = re.findall(
                    r"(?<![A-Za-z0-9_])[A-Za-z][A-Za-z0-9]*(?![A-Za-z0-9~])", head
                )
                labels = re.findall(r"([A-Za-z][A-Za-z0-9]*)\(x\) = ", text)
                if name in {*own, *words_of, *labels}:
                    [line] = [ln for ln in text.splitlines() if re.search(rf"\b{name}\b", ln)][:1]
                    yield f"{law} {words}: {name} in {line!r}"


def main() -> int:
    """Search, print, count."""
    found = 0
    for name in NAMES:
        for words in collisions(name):
            found += 1
            print(f"{name}: {words}", flush=True)
    print(f"{found} collisions over {len(NAMES)} names")
    return int(found > 0)


if __name__ == "__main__":
    sys.exit(main())
