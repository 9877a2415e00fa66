"""Compiled kernels follow their sources: nothing outdated is used, nothing compiled in vain."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from longwave.support.compiled.jit import njit

HOUSE = Path(__file__).parents[3]
SOLUTIONS = Path("longwave") / "solutions"

RUN_FILES = (
    *(
        f"support/compiled/{n}.py"
        for n in (
            "jit",
            "native_code",
            "kernel_folder",
            "shipped_kernels",
            "source_digest",
            "subnormals",
        )
    ),
    *(f"support/{name}.py" for name in ("atomic_file", "sealed_file", "lazy_exports")),
)

UNCOMPILED = shutil.ignore_patterns("__pycache__")

FILES = {
    "kernel.py": """
from longwave.support.compiled.jit import njit
from longwave.solutions.helper import SHIFT, cube
from longwave.solutions import tables

@njit(cache=True)
def kernel(x, out):
    out[0] = cube(x) + SHIFT + tables.WEIGHTS[0]
""",
    "helper.py": """
from longwave.support.compiled.jit import Intrinsic, njit
from longwave.solutions.constant import SHIFT
from longwave.solutions.generate import generate

def signature(context, x):
    from numba import types
    return types.float64(types.float64), generate

third_power = Intrinsic(signature)

@njit()
def cube(x):
    return 1.0 * third_power(x)
""",
    "constant.py": "SHIFT = 0.0\n",
    "generate.py": """
def generate(context, builder, signature, arguments):
    square = builder.fmul(arguments[0], arguments[0])
    return builder.fmul(square, arguments[0])
""",
    "tables.py": "import numpy as np\nWEIGHTS = np.array([0.0, 1.0])\n",
    "__init__.py": "",
}

RUN = """
import sys
import numpy as np
from longwave.solutions.kernel import kernel
out = np.zeros(1)
kernel(3.0, out)
print(*out, "made" if "numba" in sys.modules else "found")
"""


@pytest.fixture
def house(tmp_path: Path) -> Path:
    """Return a small project whose kernel is built from five files."""
    package = tmp_path / "house" / "longwave"
    for name in RUN_FILES:
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(HOUSE / name, package / name)
    (package / "solutions").mkdir()
    for name, text in FILES.items():
        (package / "solutions" / name).write_text(text)
    return package.parent


def call(house: Path, code: str = RUN, **environment: str) -> list[str]:
    """Return what the code prints in its own process; warnings on stderr are errors."""
    inherited = {"NUMBA_CACHE_DIR", "PYTHONDONTWRITEBYTECODE", "PYTHONPYCACHEPREFIX"}
    settings = {name: value for name, value in os.environ.items() if name not in inherited}
    settings |= {"PYTHONPATH": str(house), **environment}
    command = [sys.executable, "-W", "error", "-c", code]
    done = subprocess.run(
        command, capture_output=True, text=True, env=settings, cwd=house, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def change(house: Path, name: str, old: str, new: str) -> Callable[[], None]:
    """Change a file but keep its size and times; return a function that undoes it."""
    path = house / SOLUTIONS / name
    text, state = path.read_text(), path.stat()
    assert old in text
    assert len(old) == len(new)

    def write(content: str) -> None:
        path.write_text(content)
        os.utime(path, ns=(state.st_atime_ns, state.st_mtime_ns))

    write(text.replace(old, new))
    return lambda: write(text)


CHANGES = [
    ("helper.py", "1.0 *", "2.0 *", "54.0"),
    ("constant.py", "0.0", "5.0", "59.0"),
    ("tables.py", "[0.0", "[1.0", "60.0"),
    ("generate.py", "fmul(square, arguments[0])", "fadd(square, arguments[0])", "30.0"),
    ("kernel.py", "cube(x) + SHIFT", "cube(x) - -x   ", "28.0"),
]


@pytest.mark.slow
def test_results_follow_every_source_when_it_changes_and_back(house: Path) -> None:
    """A function, a constant, a table, LLVM code and the kernel's own file; times unchanged."""
    plain = {"PYTHONDONTWRITEBYTECODE": "1"}
    assert call(house, **plain) == ["27.0", "made"]
    backwards = []
    for name, old, new, expected in CHANGES:
        backwards.append(change(house, name, old, new))
        assert call(house, **plain) == [expected, "made"], name
    for back in backwards:
        back()
    (house / SOLUTIONS / "other.py").write_text("SHIFT = 1.0\n")
    assert call(house, **plain) == ["27.0", "found"]


@pytest.mark.slow
def test_results_of_old_byte_code_are_not_cached(house: Path) -> None:
    """Python runs old byte code if a change keeps time and size; its results must not be cached."""
    call(house)
    change(house, "helper.py", "1.0 *", "2.0 *")
    assert call(house)[0] == "27.0"
    for path in (house / SOLUTIONS / "__pycache__").glob("*.pyc"):
        path.unlink()
    assert call(house) == ["54.0", "made"]
    assert call(house) == ["54.0", "found"]


@pytest.mark.slow
def test_read_only_installation_uses_the_users_cache(house: Path, tmp_path: Path) -> None:
    (house / SOLUTIONS / "__pycache__").write_text("no folder can be made here")
    for state in ("made", "found"):
        assert call(house, XDG_CACHE_HOME=str(tmp_path / "cache")) == ["27.0", state]
    assert list((tmp_path / "cache").rglob("*.object"))


@pytest.mark.slow
def test_without_any_cache_it_runs_and_says_so_once(house: Path, tmp_path: Path) -> None:
    (house / SOLUTIONS / "__pycache__").write_text("")
    (tmp_path / "file").write_text("")
    code = """
import warnings
import numpy as np
out = np.zeros(2)
with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("always")
    from longwave.solutions.kernel import kernel
    kernel(3.0, out)
    kernel(3, out[1:])
assert [w.category for w in told] == [RuntimeWarning], told
print(*out)
"""
    assert call(house, code, XDG_CACHE_HOME=str(tmp_path / "file")) == ["27.0", "27.0"]


@pytest.mark.slow
def test_old_versions_are_removed_and_damage_costs_a_compilation(house: Path) -> None:
    for number in range(12):
        (house / SOLUTIONS / "__pycache__" / f"longwave.solutions.kernel-{number}").mkdir(
            parents=True
        )
    call(house)
    assert len(list((house / SOLUTIONS / "__pycache__").glob("longwave.solutions.kernel-*"))) == 8
    [path] = house.rglob("*.object")
    path.write_bytes(path.read_bytes()[:1000])
    assert call(house) == ["27.0", "made"]
    assert call(house) == ["27.0", "found"]


@pytest.mark.slow
def test_processes_that_compile_at_once_find_their_own_signatures(house: Path) -> None:
    """Numba's own index can give one of them the other's machine code."""

    def told(number: str) -> list[str]:
        return call(house, RUN.replace("3.0", number))

    with ThreadPoolExecutor(3) as pool:
        assert [*pool.map(told, ["3", "3.0", "3.0"])] == [["27.0", "made"]] * 3
    assert told("3") == told("3.0") == ["27.0", "found"]


@pytest.mark.slow
def test_machine_code_of_the_lattice_is_compiled_anew(tmp_path: Path) -> None:
    """The force in the machine code is changed from y^3 to y^2 and back."""
    for room in ("lattice", "support"):
        shutil.copytree(HOUSE / room, tmp_path / "longwave" / room, ignore=UNCOMPILED)
    code = """
import numpy as np
from longwave.lattice.kernels.ring_kernel import RingKernel
from longwave.lattice.model import Model
y, s = np.linspace(0.0, 1.0, 64)[None], np.zeros((1, 64))
chain = Model(1.0, 0.0, 1.0).lattice
RingKernel(chain, 64).advance(y, s, np.full(2, 0.05), np.full(1, 0.1), 3)
print(y[0, 30])
"""
    [before] = call(tmp_path, code, PYTHONDONTWRITEBYTECODE="1")
    assert len(list(tmp_path.rglob("*.object"))) == 1
    writer = tmp_path / "longwave" / "lattice" / "kernels" / "row_code.py"
    text = writer.read_text()
    changed = text.replace("code.fma(x, result, factor)", "code.builder.fadd(result, factor)")
    assert changed != text
    writer.write_text(changed)
    assert call(tmp_path, code, PYTHONDONTWRITEBYTECODE="1") != [before]
    writer.write_text(text)
    assert call(tmp_path, code, PYTHONDONTWRITEBYTECODE="1") == [before]
    assert len(list(tmp_path.rglob("*.object"))) == 2


ORDER = """
import numpy as np
from longwave.support.compiled.jit import njit

@njit(cache=True, fastmath={"contract"})
def summed(a, b, out):
    for i in range(out.size):
        out[i] += a[i] * b[i]

@njit(cache=True)
def product(a, b, out):
    for i in range(out.size):
        out[i] = a[i] * b[i]
"""

CALL = """
import hashlib, sys
import numpy as np
from longwave.solutions.order import product, summed
a, b, c = np.random.default_rng(0).standard_normal((3, 1, 1998)).view(complex)
out = c.copy()
{first}
summed(a[0], b[0], out[0])
print(hashlib.sha256(out.tobytes()).hexdigest())
"""


def test_a_function_takes_no_flags_from_the_kernel_that_calls_it_first() -> None:
    @njit()
    def inner(a: float, b: float, c: float) -> float:
        return a * b + c

    @njit(fastmath={"contract"})
    def loose(a: float, b: float, c: float) -> float:
        return inner(a, b, c)

    @njit()
    def strict(a: float, b: float, c: float) -> float:
        return inner(a, b, c)

    a = 1.0 + 2.0**-30
    loose(a, a, -1.0)
    assert strict(a, a, -1.0) == a * a - 1.0


@pytest.mark.slow
def test_machine_code_does_not_depend_on_what_was_compiled_before(
    house: Path, tmp_path: Path
) -> None:
    """Numba compiles complex products with the flags of the first kernel that needs them."""
    (house / SOLUTIONS / "order.py").write_text(ORDER)
    other = "product(a[0], b[0], c[0])"
    found = {
        first: call(house, CALL.format(first=first), NUMBA_CACHE_DIR=str(tmp_path / str(place)))
        for place, first in enumerate(("", other))
    }
    assert found[""] == found[other]
