"""Snippets of a page, in the order in which they are run."""

import re
from collections.abc import Iterator
from dataclasses import dataclass

_FENCE = re.compile(r"^```(\{?[\w-]+\}?)([^\n]*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_CAPTION = re.compile(r":caption: (\S+)\n\n?")

SLOW = re.compile(r"^.*: .*(so far|left) \(Ctrl-C stops it\)\n", re.MULTILINE)
"""Pattern of messages that appear only on a slow machine."""


@dataclass(frozen=True)
class Snippet:
    """Fenced block: `kind` is its language, `caption` the name of the file that it contains."""

    kind: str
    text: str
    caption: str = ""


@dataclass(frozen=True)
class Command:
    """Command of a console block, and the output shown below it."""

    line: str
    output: str


def snippets(page: str) -> Iterator[Snippet]:
    r"""Yield the page's blocks, those of directives aside, which Sphinx itself reads.

    >>> [snippet.kind for snippet in snippets("```pycon\n>>> 1\n1\n```\n```{waves}\n```\n")]
    ['pycon']
    """
    for kind, argument, text in _FENCE.findall(page):
        caption = _CAPTION.match(text)
        if kind == "{code-block}":
            body = text[caption.end() :] if caption else text
            yield Snippet(argument.strip(), body, caption[1] if caption else "")
        elif not kind.startswith("{"):
            yield Snippet(kind, text)


def commands(text: str) -> Iterator[Command]:
    r"""Yield the commands of a console block.

    >>> list(commands("$ longwave --version\nlongwave 1.2\n"))
    [Command(line='longwave --version', output='longwave 1.2\n')]
    """
    for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
        line, _, output = part.partition("\n")
        yield Command(line, output)
