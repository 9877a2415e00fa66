"""Another user of the machine tries what is kept, shared, served and run: nothing is read or run.

Every attempt is made by a process of that user's, and beside it stands one that succeeds where a
protection is taken away: it could have been made.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray as xr

from longwave.runs import run_file
from longwave.runs.run_file import file_content, load_run, save_run
from longwave.runs.run_pack import DONE, CellRecord, pack_content
from longwave.runs.run_store import RunStore
from longwave.runs.store_packs import PACKS, pack_index
from longwave.solutions.data_store import DataStore
from longwave.support import sealed_file
from longwave.support.compiled import kernel_folder
from longwave.support.compiled.kernel_folder import CacheFolder, cache_folder
from longwave.support.file_lock import locked
from longwave.support.plain_data import plain_bytes
from longwave.support.processes import Job, LocalWorkers, run_apart
from longwave.support.sealed_file import is_whole, write_sealed
from tests.runs.unfinished_scenes import chain
from tests.support.compiled.cache_places import caches_in, forget
from tests.support.process_jobs import CLUSTER, POOL

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root makes a second user"
    ),
]

NOBODY = 65534
SECRET = 666.0
HOUSE = Path(__file__).parents[1]
SMALL = chain(
    "small", observables=["strain"], snapshots=[0, 2], domain="ring", step=0.5, sites=192,
    compared=20,
)  # fmt: skip


def _dropped(function: Callable[..., Any], arguments: tuple[Any, ...]) -> tuple[int, Any]:
    """In a process of its own: become the second user, and return who that is and what came."""
    os.setgroups([])
    os.setgid(NOBODY)
    os.setuid(NOBODY)
    os.umask(0)
    try:
        return os.geteuid(), function(*arguments)
    except OSError as error:
        return os.geteuid(), type(error).__name__


def as_nobody(function: Callable[..., Any], *arguments: Any) -> Any:
    """What a function gives the second user, or the name of the error of the system."""
    user, found = run_apart(Job(_dropped, (function, arguments), seconds=300.0)).result()
    assert user == NOBODY
    return found


@pytest.fixture
def common() -> Iterator[Path]:
    """A folder that both users can look into."""
    folder = Path(tempfile.mkdtemp(prefix="second-user-"))
    folder.chmod(0o755)
    yield folder
    shutil.rmtree(folder)


@contextlib.contextmanager
def mask(bits: int) -> Iterator[None]:
    """Make files with that mask in the body."""
    before = os.umask(bits)
    try:
        yield
    finally:
        os.umask(before)


def read(path: Path) -> bytes:
    return path.read_bytes()


def write(path: Path, content: bytes) -> str:
    path.write_bytes(content)
    return "written"


def link(path: Path, target: Path) -> str:
    path.unlink(missing_ok=True)
    path.symlink_to(target)
    return "linked"


def listed(folder: Path) -> list[str]:
    return os.listdir(folder)


def other_folder(folder: Path, files: dict[str, bytes], mode: int) -> str:
    """Put a folder of one's own in the place of one that was there."""
    if folder.exists():
        folder.rename(folder.with_name("away"))
    folder.mkdir()
    for name, content in files.items():
        (folder / name).write_bytes(content)
        (folder / name).chmod(0o600 if mode == 0o700 else 0o644)
    folder.chmod(mode)
    return "planted"


# caches


@pytest.fixture
def bases(common: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Path, Path]]:
    """Where caches are kept: a place that users share, and one's own."""
    yield from caches_in(common, monkeypatch)


MODULE = kernel_folder.__name__


def _forged(cache: CacheFolder, name: str, data: bytes) -> bytes:
    """A file that is right in all but its owner."""
    return _sealed(cache._title(name) + b"\n" + data)


def _sealed(content: bytes) -> bytes:
    return content + sealed_file._seal(hashlib.sha256(content))


@pytest.mark.parametrize("bits", [0o022, 0])
def test_a_cache_is_neither_read_nor_written_by_another(
    bits: int, bases: tuple[Path, Path], common: Path
) -> None:
    with mask(bits):
        cache = cache_folder(MODULE)
        cache.write("code", b"secret")
        assert cache.path is not None
        assert cache.path.parent == bases[0]
        DataStore("maker", "key", cache).write("data", 1.0)
    kept = cache.path / "code"
    for attempt in (
        (read, kept),
        (listed, cache.path),
        (write, kept, b""),
        (link, kept, common),
        (other_folder, cache.path, {}, 0o700),
    ):
        assert as_nobody(*attempt) == "PermissionError"
    assert cache.read("code") == b"secret"
    cache.path.chmod(0o755)  # what stands in the way is the mode
    kept.chmod(0o644)
    assert b"secret" in as_nobody(read, kept)
    assert cache.read("code") is None


@pytest.mark.parametrize("mode", [0o700, 0o755, 0o777])
def test_a_planted_cache_is_not_read(
    mode: int, bases: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    bases[0].mkdir()
    bases[0].chmod(0o777)  # as NUMBA_CACHE_DIR may be
    cache = cache_folder(MODULE)
    assert cache.path is not None
    cache.write("code", b"mine")
    store = DataStore("maker", "key", cache)
    files = {
        "code": _forged(cache, "code", b"planted"),
        f"{store._stem}.data": _forged(cache, f"{store._stem}.data", plain_bytes(SECRET)),
    }
    assert as_nobody(other_folder, cache.path, files, mode) == "planted"
    assert cache.path.stat().st_uid == NOBODY
    assert (cache.read("code"), store.read("data")) == (None, None)
    forget()
    with pytest.warns(RuntimeWarning, match="must be private to the user"):
        again = cache_folder(MODULE)
    assert again.path is not None
    assert again.path.parent == bases[1]
    assert again.read("code") is None
    monkeypatch.setattr(kernel_folder, "_fault", lambda *_, **__: "")
    assert (cache.read("code"), store.read("data")) == (b"planted", SECRET)


# a shared store


@pytest.fixture
def store(common: Path) -> RunStore:
    """A store into which everybody may write."""
    made = RunStore(common / "store")
    with mask(0):
        made.path(SMALL).parent.mkdir(parents=True)
        (made.folder / PACKS / "ab").mkdir(parents=True)
    return made


@pytest.fixture
def letter(common: Path) -> Path:
    """A file that the first user alone may read."""
    path = common / "letter"
    path.write_bytes(np.full(6, SECRET).tobytes())
    path.chmod(0o600)
    assert as_nobody(read, path) == "PermissionError"
    return path


def _pointing(image: bytes, array: str, letter: Path) -> bytes:
    """A file in HDF5 of whose arrays one is said to stand in the letter."""
    stream = BytesIO(image)
    with h5py.File(stream, "r+") as file:
        group, _, name = array.rpartition("/")
        shape, told = file[array].shape, dict(file[array].attrs)
        del file[array]
        places = [(str(letter), 0, 8 * int(np.prod(shape)))]
        file[group or "/"].create_dataset(name, shape, "f8", external=places).attrs.update(told)
    return stream.getvalue()


def _run() -> xr.Dataset:
    return xr.Dataset({"a": (("t", "x"), np.ones((1, 6)))}, attrs={"scene": "none"})


def test_a_link_in_the_place_of_a_run_is_replaced(store: RunStore, letter: Path) -> None:
    path, before = store.path(SMALL), letter.read_bytes()
    assert as_nobody(link, path, letter) == "linked"
    assert path.lstat().st_uid == NOBODY
    assert store.find(SMALL) is None
    assert store.fetch(SMALL) == path
    assert not path.is_symlink()
    assert path.stat().st_uid == os.geteuid()
    assert letter.read_bytes() == before
    assert as_nobody(link, path, letter) == "linked"
    save_run(_run(), path)  # which follows a name that a user typed
    assert letter.read_bytes() != before


def test_a_link_in_the_place_of_a_lock_is_removed(store: RunStore, common: Path) -> None:
    lock, elsewhere = store.path(SMALL).with_suffix(".lock"), common / "elsewhere"
    assert as_nobody(link, lock, elsewhere) == "linked"
    store.fetch(SMALL)
    assert not elsewhere.exists()
    assert as_nobody(link, lock, elsewhere) == "linked"
    os.close(os.open(lock, os.O_RDWR | os.O_CREAT, 0o666))  # as a lock that follows would
    assert elsewhere.exists()


def test_no_run_is_made_or_found_through_the_link_of_another(
    store: RunStore, common: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, elsewhere = store.path(SMALL), common / "elsewhere"
    path.parent.rmdir()
    elsewhere.mkdir()
    write_sealed(elsewhere / path.name, file_content(_run()))
    assert as_nobody(link, path.parent, elsewhere) == "linked"
    assert store.find(SMALL) is None
    assert not is_whole(path)
    with pytest.raises(OSError, match="link"):
        load_run(path, follow=False)
    with pytest.raises(OSError, match="must not be a link"):
        store.fetch(SMALL)
    monkeypatch.setattr(sealed_file, "_opened_folder", lambda *_: contextlib.nullcontext())
    assert store.find(SMALL) == path


def test_a_planted_run_gives_no_byte_of_another_file(
    store: RunStore, letter: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = store.path(SMALL)
    sealed = _sealed(_pointing(file_content(_run()), "a", letter))
    assert as_nobody(write, path, sealed) == "written"
    for follow in (True, False):
        with pytest.raises(ValueError, match="in the file itself, got another file"):
            load_run(path, follow=follow)
    with pytest.raises(ValueError, match="in the file itself, got another file"):
        store.run(SMALL)
    monkeypatch.setattr(run_file, "check_contents", lambda *_: None)
    assert float(load_run(path)["a"].max()) == SECRET


def test_planted_packs_are_not_believed(
    store: RunStore, letter: Path, common: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    packs, elsewhere = store.folder / PACKS, common / "elsewhere"
    elsewhere.mkdir()
    whole = pack_content([CellRecord("k", DONE, run=_run())])
    write_sealed(elsewhere / "p.h5", whole)
    sealed = _sealed(_pointing(whole, "0/arrays/a", letter))
    assert as_nobody(link, packs / "cd", elsewhere) == "linked"
    assert as_nobody(link, packs / "ab" / "link.h5", elsewhere / "p.h5") == "linked"
    assert as_nobody(write, packs / "ab" / "pointing.h5", sealed) == "written"
    assert len(pack_index(store.folder)) == 0
    monkeypatch.setattr("longwave.runs.hdf_contents._is_external", lambda _: False)
    held = pack_index(store.folder).get("k")
    assert held is not None
    assert held[1] is not None
    assert float(held[1].load()["a"].max()) == SECRET


def test_what_another_holds_or_made_a_pipe_of_is_no_trap(store: RunStore) -> None:
    path = store.path(SMALL)
    assert as_nobody(os.mkfifo, path) is None
    assert as_nobody(os.mkfifo, path.with_suffix(".lock")) is None
    assert store.find(SMALL) is None
    with locked(path.with_suffix(".lock")):
        pass


# the page


EXPLORE = [sys.executable, "-m", "longwave", "explore"]


def _answer(port: int, path: str, host: str) -> int:
    """The status of an answer to a request."""
    request = f"GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"
    with contextlib.closing(socket.create_connection(("127.0.0.1", port), timeout=300)) as line:
        line.sendall(request.encode())
        return int(line.recv(20).split()[1])


def _readable(folder: Path) -> str:
    """What a user can read of processes and of files in a folder."""
    found = []
    places = [
        *(
            place
            for name in ("cmdline", "environ")
            for place in Path("/proc").glob(f"[0-9]*/{name}")
        ),
        *folder.glob("*"),
    ]
    for place in places:
        with contextlib.suppress(OSError):
            found.append(place.read_bytes().decode(errors="replace"))
    return "\n".join(found)


@pytest.mark.parametrize("browser", [False, True])
def test_a_page_is_its_users_alone(browser: bool, common: Path) -> None:
    """With a browser that stays open, and has the address among its arguments."""
    pytest.importorskip("panel")
    command, shown = [*EXPLORE, *([] if browser else ["--no-browser"])], common / "shown"
    lines = ["#!/bin/sh", f'echo "$1" > {shown}.new', f"mv {shown}.new {shown}", "sleep 600", ""]
    (common / "browser").write_text("\n".join(lines))
    (common / "browser").chmod(0o755)
    files = common / "files"
    files.mkdir(mode=0o755)
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, cwd=HOUSE,
        env={**os.environ, "BROWSER": f"{common}/browser %s", "TMPDIR": str(files)},
        start_new_session=True,
    )  # fmt: skip
    try:
        assert process.stdout is not None
        found = re.search(r":(\d+)/\?token=([\w-]{43}) ", process.stdout.readline())
        assert found
        port, token, right = int(found[1]), found[2], f"127.0.0.1:{found[1]}"
        while browser and not shown.exists():
            assert process.poll() is None
            time.sleep(0.05)
        readable = as_nobody(_readable, files)
        assert "explore" in readable
        assert token not in readable
        if browser:
            page = Path(shown.read_text().strip().removeprefix("file://"))
            assert str(page) in readable
            assert as_nobody(read, page) == "PermissionError"
            page.chmod(0o644)
            assert token in as_nobody(_readable, files)
        for path, host in (
            ("/", right), ("/?token=wrong", right), ("/autoload.js", right), ("/ws", right),
            (f"/?token={token}", "evil.example"), (f"/?token={token}", f"evil.example:{port}"),
        ):  # fmt: skip
            assert as_nobody(_answer, port, path, host) == 403
        assert as_nobody(_answer, port, f"/?token={token}", right) == 200
    finally:
        os.killpg(process.pid, 9)
        process.communicate()


# a worker


PLANTED = """import os
with open({mark!r}, "a") as stream:
    stream.write(__name__ + chr(10))
"""


def _plant(folder: Path, mark: Path) -> str:
    (folder / "longwave").mkdir()
    for name in ("pickle.py", "subprocess.py", "socket.py", "longwave/__init__.py"):
        (folder / name).write_text(PLANTED.format(mark=str(mark)))
    return "planted"


def _run_in(folder: Path, script: Path, words: list[str]) -> str:
    done = subprocess.run(
        [sys.executable, *words, str(script)],
        cwd=folder, env={**os.environ, "PYTHONPATH": str(HOUSE)}, capture_output=True, text=True,
        timeout=600, check=False,
    )  # fmt: skip
    return done.stdout


@pytest.mark.parametrize("code", [CLUSTER, POOL], ids=["cluster", "processes"])
def test_a_planted_module_is_not_run(code: str, common: Path) -> None:
    folder, mark, script = common / "folder", common / "mark", common / "script.py"
    folder.mkdir()
    folder.chmod(0o777)
    script.write_text(code)
    assert as_nobody(_plant, folder, mark) == "planted"
    assert "4" in _run_in(folder, script, [])
    assert not mark.exists()
    subprocess.run([sys.executable, "-c", "import pickle"], cwd=folder, check=False)
    assert "pickle" in mark.read_text()


def _descriptors(number: int, content: bytes) -> list[str]:
    """Write into all that a process has open."""
    folder = Path(f"/proc/{number}/fd")
    for place in folder.iterdir():
        with contextlib.suppress(OSError):
            os.write(os.open(place, os.O_WRONLY | os.O_NONBLOCK), content)
    return [str(folder)]


def test_nobody_else_reaches_a_workers_pipe() -> None:
    workers = LocalWorkers(1)
    worker = workers.start()
    try:
        assert as_nobody(_descriptors, worker.process.pid, b"") == "PermissionError"
        assert _descriptors(worker.process.pid, b"")
    finally:
        workers.stop()
