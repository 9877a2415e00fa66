"""Random mutants of the code, and which of them the tests notice.

Each mutant has one small change: a comparison, an operator, a constant, a condition, a statement
that is gone.  The tests are run on it in a copy of the tree.  What survives is printed with its
line, before and after, to be killed by a new test or shown to change nothing.

    python -m searches.mutants verify/kernel --tests tests/verify/kernel
                                 [--count 300] [--seed 0] [--workers 1] [--seconds 120]
"""

from __future__ import annotations

import argparse
import ast
import copy
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from longwave.support.processes import Job, LocalWorkers, OutOfTime, in_order, run_program

HOUSE = Path(__file__).parents[1]

COMPARED: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
}
OPERATED: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Add,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
}

Change = Callable[[ast.AST], ast.AST]

ALIKE = ("annotation", "returns", "decorator_list", "type_params")
"""Fields of nodes in which a change says nothing: types, decorators."""


def other_comparison(node: ast.AST) -> ast.AST:
    """Return the first comparison of a chain turned."""
    assert isinstance(node, ast.Compare)
    node.ops[0] = COMPARED[type(node.ops[0])]()
    return node


def other_operator(node: ast.AST) -> ast.AST:
    """Return another operator between the same operands."""
    assert isinstance(node, ast.BinOp | ast.AugAssign)
    node.op = OPERATED[type(node.op)]()
    return node


def other_connective(node: ast.AST) -> ast.AST:
    """Return ``and`` for ``or``, and the other way."""
    assert isinstance(node, ast.BoolOp)
    node.op = ast.And() if isinstance(node.op, ast.Or) else ast.Or()
    return node


def other_constant(node: ast.AST) -> ast.AST:
    """Return the opposite truth value, or the next number."""
    assert isinstance(node, ast.Constant)
    node.value = not node.value if isinstance(node.value, bool) else node.value + 1  # type: ignore[operator]
    return node


def other_sign(node: ast.AST) -> ast.AST:
    """Return the operand of a minus or a not alone."""
    assert isinstance(node, ast.UnaryOp)
    return node.operand


def opposite(node: ast.AST) -> ast.AST:
    """Return the other branch of a condition."""
    assert isinstance(node, ast.If | ast.IfExp | ast.While)
    node.test = ast.UnaryOp(ast.Not(), node.test)
    return node


def nothing(_: ast.AST) -> ast.AST:
    """Return ``pass`` in the place of a statement."""
    return ast.Pass()


def changes(node: ast.AST) -> Iterator[Change]:
    """Yield the changes that a node admits."""
    match node:
        case ast.Compare() if type(node.ops[0]) in COMPARED:
            yield other_comparison
        case ast.BinOp() | ast.AugAssign() if type(node.op) in OPERATED:
            yield other_operator
        case ast.BoolOp():
            yield other_connective
        case ast.Constant(value=bool() | int()):
            yield other_constant
        case ast.UnaryOp(op=ast.USub() | ast.Not()):
            yield other_sign
        case ast.If() | ast.IfExp():
            yield opposite
        case ast.Raise() | ast.AugAssign() | ast.Expr(value=ast.Call()):
            yield nothing


Place = tuple[tuple[str, int | None], ...]
"""The fields and indices that lead from a module to a node."""


def places(node: ast.AST, above: Place = ()) -> Iterator[tuple[Place, ast.AST]]:
    """Yield every node that may be changed, with its place; annotations are left out."""
    yield above, node
    for name, value in ast.iter_fields(node):
        if name in ALIKE or (isinstance(node, ast.JoinedStr) and name == "values"):
            continue
        if isinstance(value, ast.AST):
            yield from places(value, (*above, (name, None)))
        elif isinstance(value, list):
            for index, inner in enumerate(value):
                if isinstance(inner, ast.AST):
                    yield from places(inner, (*above, (name, index)))


def at(tree: ast.AST, place: Place) -> ast.AST:
    """Return the node at a place."""
    found = tree
    for name, index in place:
        value = getattr(found, name)
        found = value if index is None else value[index]
    return found


@dataclass(frozen=True)
class Mutant:
    """One changed line of a file: the file's text after it, and the line before and after."""

    path: Path
    line: int
    before: str
    after: str
    text: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}\n    - {self.before}\n    + {self.after}"


def mutants(paths: Sequence[Path], count: int, seed: int) -> list[Mutant]:
    """Draw so many different mutants of the files, evenly from all that there are."""
    found = []
    for path in paths:
        tree = ast.parse((HOUSE / path).read_text("utf-8"))
        for place, node in places(tree):
            found += [(path, tree, place, change) for change in changes(node)]
    draw = random.Random(seed)
    drawn = draw.sample(found, min(count, len(found)))
    return [mutant_at(path, tree, place, change) for path, tree, place, change in drawn]


def mutant_at(path: Path, tree: ast.Module, place: Place, change: Change) -> Mutant:
    """Return the mutant with a change at a place."""
    changed = copy.deepcopy(tree)
    old = at(changed, place)
    before, line = ast.unparse(old), getattr(old, "lineno", 0)
    new = change(old)
    name, index = place[-1]
    above = at(changed, place[:-1])
    if index is None:
        setattr(above, name, new)
    else:
        getattr(above, name)[index] = new
    after = ast.unparse(ast.fix_missing_locations(new))
    text = ast.unparse(ast.fix_missing_locations(changed)) + "\n"
    return Mutant(path, line, before.splitlines()[0], after.splitlines()[0], text)


class Copy:
    """A copy of the tree in which mutants are tested one after another."""

    def __init__(self, folder: Path, tests: Sequence[str], seconds: float) -> None:
        self._folder, self._tests, self._seconds = folder, tests, seconds
        listing = subprocess.run(
            ["git", "ls-files"], cwd=HOUSE, check=True, capture_output=True, text=True
        )
        for name in listing.stdout.splitlines():
            if (HOUSE / name).exists():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(HOUSE / name, folder / name, follow_symlinks=False)

    def survives(self, mutant: Mutant | None) -> bool:
        """Return whether the tests pass with a mutant (None: with no change)."""
        if mutant is None:
            return self._tests_pass()
        target = self._folder / mutant.path
        original = target.read_text("utf-8")
        target.write_text(mutant.text, "utf-8")
        try:
            return self._tests_pass()
        finally:
            target.write_text(original, "utf-8")

    def _tests_pass(self) -> bool:
        """Run the tests; what takes too long has failed, and is killed with what it started."""
        words = ["-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *self._tests]
        settings = [f"PYTHONPATH={self._folder}", "PYTHONDONTWRITEBYTECODE=1"]
        command = ["env", *settings, sys.executable, "-P", *words]
        try:
            return run_program(command, self._folder, self._seconds)[0] == 0
        except OutOfTime:
            return False


def tested(drawn: Sequence[Mutant], tests: Sequence[str], seconds: float) -> list[Mutant]:
    """Return the mutants that survive; print each when it is found."""
    with tempfile.TemporaryDirectory() as folder:
        tree = Copy(Path(folder), tests, seconds)
        if not tree.survives(None):
            raise SystemExit("mutants: the tests must pass before anything is changed")
        found = []
        for mutant in drawn:
            if tree.survives(mutant):
                found.append(mutant)
                print(mutant, flush=True)
        return found


def python_files(path: str) -> list[Path]:
    """Return the file, or the files of a folder."""
    place = HOUSE / path
    return sorted(place.rglob("*.py")) if place.is_dir() else [place]


def main(arguments: Sequence[str] | None = None) -> int:
    """Test mutants and print what survives, with the counts by file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("paths", nargs="+", help="files or folders of the code")
    parser.add_argument("--tests", nargs="+", required=True, help="what pytest is called with")
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=120.0, help="for the tests of one mutant")
    given = parser.parse_args(arguments)
    paths = [file.relative_to(HOUSE) for path in given.paths for file in python_files(path)]
    drawn = mutants(paths, given.count, given.seed)
    start, shares = time.monotonic(), [drawn[i :: given.workers] for i in range(given.workers)]
    jobs = (Job(tested, (share, given.tests, given.seconds)) for share in shares)
    parts = in_order(jobs, LocalWorkers(given.workers, isolated=True))
    survivors = [mutant for part in parts for mutant in part]
    for name, number in Counter(str(mutant.path) for mutant in survivors).most_common():
        print(f"{number:5d} {name}")
    killed = len(drawn) - len(survivors)
    taken = time.monotonic() - start
    print(f"{killed} of {len(drawn)} killed ({killed / len(drawn):.1%}), {taken:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
