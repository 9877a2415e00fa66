"""A store of runs: a folder with one file for each scene, named by the key of the run.

The key is a digest of the scene and of the code that computes it: formulas of the waves, kernels,
engines, and the versions of packages that affect the numbers. Code that only draws or prints does
not count. So a scene is run once, and again only after a relevant change.

A run's file is NetCDF-4 with a checksum (`support.sealed_file`); a damaged file is computed again.
Small runs of sweeps are stored in packs (`runs.store_packs`), which are searched as well. A process
that computes a run holds its lock, which is released if the process is killed. Links inside the
store are never followed, because others may have put them there.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Container, Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from longwave.runs.store_packs import PackedRun, pack_index
from longwave.support.atomic_file import remove_dead_drafts
from longwave.support.checkpoint import LEAST, SHARE, CheckpointFolder, checkpoints_in, run_stamp
from longwave.support.file_lock import locked
from longwave.support.sealed_file import LOG, check_no_link, is_whole, write_sealed

if TYPE_CHECKING:
    import xarray as xr

    from longwave.lattice.refine import Announce
    from longwave.lattice.trial import Progress
    from longwave.scenes.description.scene import Scene

IRRELEVANT_PACKAGES = ("xarray", "h5netcdf")
"""Packages whose version does not affect the bits of a run."""

WAITING = "%s: waiting for another process that computes this run"
"""Log message for a run that is locked."""


class UnsavedRunError(OSError):
    """A finished run could not be written to a store; the attribute ``run`` holds it."""

    def __init__(self, error: OSError, run: xr.Dataset) -> None:
        super().__init__(error.errno, error.strerror or str(error), error.filename)
        self.run = run


class RunStore:
    """Runs in a folder, which is created when the first run is saved.

    Events are sent to the logger ``longwave.store``: damage as a warning; waiting for another
    process and resuming an unfinished run as information. ``least`` is the least number of seconds
    between two checkpoints of a run, ``share`` the largest share of its time that they take.
    """

    def __init__(self, folder: str | Path, least: float = LEAST, share: float = SHARE) -> None:
        self.folder = Path(folder)
        self._pace = least, share

    def key(self, scene: Scene) -> str:
        """Return the key of the scene's run; see `run_key`."""
        return run_key(scene)

    def path(self, scene: Scene) -> Path:
        """Return the path of the scene's file, whether it exists or not."""
        return self.file_of(self.key(scene))

    def file_of(self, key: str) -> Path:
        """Return the path of the file with this key, whether it exists or not."""
        return self.folder / key[:2] / f"{key}.nc"

    def find(self, scene: Scene) -> Path | None:
        """Return the run's file; None if the run has no file of its own or a damaged one."""
        path = self.path(scene)
        return path if is_whole(path) else None

    def stored_runs(self) -> StoredRuns:
        """Return a snapshot of the store's contents, for asking about many keys."""
        return StoredRuns(self)

    def run(
        self, scene: Scene, progress: Progress | None = None, announce: Announce | None = None
    ) -> xr.Dataset:
        """Return the scene's run, from its file or a pack; compute it as `fetch` does if needed."""
        from longwave.runs.run_file import load_run

        location = self._find_and_log(scene)
        if isinstance(location, PackedRun):
            return location.load()
        return load_run(location or self._compute(scene, progress, announce), follow=False)

    def _find_and_log(self, scene: Scene) -> Path | PackedRun | None:
        """Return the location of the scene's run and log it; None if the store does not have it."""
        file = self.path(scene)
        location: Path | PackedRun | None = file
        if not is_whole(file):
            entry = pack_index(self.folder).get(file.stem)
            location = None if entry is None else entry[1]
        if location is not None:
            path = location if isinstance(location, Path) else location.path
            LOG.info("%s: found in %s, not run again", scene.name, path)
        return location

    def keep(self, scene: Scene, run: xr.Dataset) -> Path:
        """Save a run that was computed elsewhere, under its scene's key; return the run's file."""
        path = self.path(scene)
        with self._locked(path):
            return _save(path, run)

    def fetch(
        self, scene: Scene, progress: Progress | None = None, announce: Announce | None = None
    ) -> Path:
        """Return the file of the scene's run; compute the run first if the store does not have it.

        A run that lies in a pack is copied to a file of its own. If another process is computing
        the run, this waits for it. An interrupted run is resumed and ends with the same bits as one
        without interruption. ``progress`` and ``announce`` are those of `scene_run.run`, whose
        errors this raises. Raises OSError before the run if the store cannot be written, and
        UnsavedRunError, which holds the run, if the finished run cannot be written.
        """
        location = self._find_and_log(scene)
        if isinstance(location, PackedRun):
            return self.keep(scene, location.load())
        return location or self._compute(scene, progress, announce)

    def _compute(self, scene: Scene, progress: Progress | None, announce: Announce | None) -> Path:
        from longwave.scenes.engines import scene_run

        path = self.path(scene)
        with self._locked(path):
            if is_whole(path):
                return path
            check_sources()
            folder = path.with_suffix(".unfinished")
            checkpoint = CheckpointFolder(folder, run_stamp(path.stem), *self._pace)
            checkpoint.tell(scene.name)
            with checkpoints_in(checkpoint):
                run = scene_run.run(scene, progress, announce)
            try:
                if not is_whole(path):  # without working locks, another process may have saved it
                    _save(path, run)
            except OSError as error:
                raise UnsavedRunError(error, run) from error
            checkpoint.clear()
            return path

    @contextmanager
    def _locked(self, path: Path) -> Iterator[None]:
        """Hold the lock of the run's file ``path``; remove drafts left by killed processes."""
        path.parent.mkdir(parents=True, exist_ok=True)
        check_no_link(path.parent)
        with locked(path.with_suffix(".lock"), lambda: LOG.info(WAITING, path)):
            remove_dead_drafts(path.parent, path.stem)
            yield


class StoredRuns(Container[str]):
    """Snapshot of a store's contents: its packs, and the keys of runs with a file of their own.

    ``key in stored_runs`` is true if the cell need not be run: its run is in a pack or an undamaged
    file, or its scene was refused.
    """

    def __init__(self, store: RunStore) -> None:
        self.packs = pack_index(store.folder)
        self._store = store
        self._files = frozenset(path.stem for path in store.folder.glob("??/*.nc"))

    def file(self, key: str) -> Path | None:
        """Return the run's own file; None if there is none or it is damaged."""
        path = self._store.file_of(key)
        return path if key in self._files and is_whole(path) else None

    def __contains__(self, key: object) -> bool:
        return isinstance(key, str) and (self.packs.settles(key) or self.file(key) is not None)


def run_key(scene: Scene) -> str:
    """Return the key of a scene's run, 40 hexadecimal digits; equal scenes have equal keys.

    Raises ValueError for a scene with a user-defined wave, because only its name is known.
    """
    if not isinstance(scene.wave, str):
        got = f"your own wave {scene.wave.name} (use longwave.run and save_run)"
        raise ValueError(f"wave must be a shipped one for a run in a store, got {got}")
    fields = json.dumps(_canonical(json.loads(scene.json())), sort_keys=True)
    text = f"{type(scene).__name__}\n{fields}\n{code_digest()}"
    return hashlib.sha256(text.encode()).hexdigest()[:40]


def _save(path: Path, run: xr.Dataset) -> Path:
    from longwave.runs.run_file import file_content

    if "unfinished" in run.attrs:
        got = f"an unfinished one ({run.attrs['unfinished']})"
        raise ValueError(f"run must be finished to be saved in a store, got {got}")
    write_sealed(path, file_content(run))
    return path


def _canonical(value: Any) -> Any:
    """Return a value with one form for equal numbers, such as 1, 1.0 and True, or 0.0 and -0.0.

    >>> _canonical([1, -0.0, "a", {"k": 2.5}])
    [1.0, 0.0, 'a', {'k': 2.5}]
    """
    if isinstance(value, dict):
        return {name: _canonical(item) for name, item in value.items()}
    if isinstance(value, list):
        return [_canonical(item) for item in value]
    if isinstance(value, int) and abs(value) < 2**53:
        return float(value)
    return value + 0.0 if isinstance(value, float) else value


@lru_cache
def code_digest() -> str:
    """Return the digest of the sources and package versions that affect a run's numbers."""
    from longwave.support.provenance import provenance

    origin = provenance()
    versions = [
        text for text in origin["versions"].split(", ") if not text.startswith(IRRELEVANT_PACKAGES)
    ]
    return hashlib.sha256("\n".join([origin["code"], *versions]).encode()).hexdigest()


@lru_cache
def runs_its_sources() -> bool:
    """Whether the loaded modules are the same as the source files on disk."""
    from longwave.support.compiled.source_digest import runs_as_written
    from longwave.support.provenance import code_files

    names = (
        ".".join(("longwave", *file.with_suffix("").parts)).removesuffix(".__init__")
        for file in code_files()
    )
    return runs_as_written(tuple(zip(names, code_files().values(), strict=True)))


def check_sources() -> None:
    """Raise ValueError if the sources changed since they were loaded: no run may be saved then."""
    if not runs_its_sources():
        raise ValueError(
            "sources must not change while a process saves runs in a store, got some that changed "
            "since it started (start it again)"
        )
