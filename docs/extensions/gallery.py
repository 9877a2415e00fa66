"""The gallery: each script draws one picture, which is shown with the script below it."""

import ast
import runpy
from collections.abc import Iterable
from pathlib import Path

from longwave.reports.pictures.style import save, styled


def scripts(folder: Path) -> list[Path]:
    """Return the gallery's scripts, in the order of their names."""
    return sorted(folder.glob("*.py"))


def draw(script: Path, folder: Path) -> Path:
    """Run the script and write the picture that its function `picture` returns."""
    with styled():
        return save(runpy.run_path(str(script))["picture"](), folder / f"{script.stem}.png")


def markdown(paths: Iterable[Path]) -> str:
    """Return the gallery as Markdown: title, text, picture and source of each script."""
    return "\n\n".join(_entry(path) for path in paths)


def _entry(path: Path) -> str:
    source = path.read_text(encoding="utf-8")
    tree = ast.parse(source)
    title, _, text = (ast.get_docstring(tree) or path.stem).partition("\n")
    code = "\n".join(source.splitlines()[tree.body[0].end_lineno or 0 :]).strip()
    parts = [
        f"## {title.rstrip('.')}",
        text.strip(),
        f"![{title}](generated/gallery/{path.stem}.png)",
        f"```{{code-block}} python\n:caption: docs/gallery/{path.name}\n\n{code}\n```",
    ]
    return "\n\n".join(parts)
