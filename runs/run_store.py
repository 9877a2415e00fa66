"""A store of runs: a folder in which each scene's run lies under a key of all that it follows from.

The key is a digest of the scene and of what computes it: the formulas of the waves, the kernels,
the engines, and the packages whose numbers end up in a run. What is drawn or printed of it does not
count. So a scene is run once, and again only when something that matters has changed.

A run's file is NetCDF-4, sealed (`support.sealed_file`): one that was damaged is made anew. Small
runs of sweeps lie many to a file (`runs.store_packs`), and are found there as well. Whoever makes a
run holds its lock; a process that is killed lets go of it. Whoever else writes there may
leave links instead: none that lies in the store is followed.
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

UNMOVED = ("xarray", "h5netcdf")
"""Packages whose version does not move a run's bits."""

WAITING = "%s: another process is making this run, which is waited for"


class UnkeptRunError(OSError):
    """A finished run that could not be written: ``run`` holds it."""

    def __init__(self, error: OSError, run: xr.Dataset) -> None:
        super().__init__(error.errno, error.strerror or str(error), error.filename)
        self.run = run


class RunStore:
    """The runs in a folder, which is made when the first of them is kept.

    What happens on the way is told to the logger ``longwave.store``: damage as a warning, waiting
    for another process and going on with an unfinished run as information. ``least`` are the
    seconds between two checkpoints of a run, ``share`` the most of its time that they take.
    """

    def __init__(self, folder: str | Path, least: float = LEAST, share: float = SHARE) -> None:
        self.folder = Path(folder)
        self._pace = least, share

    def key(self, scene: Scene) -> str:
        """`run_key` of the scene."""
        return run_key(scene)

    def path(self, scene: Scene) -> Path:
        """Where the scene's run is, or would be."""
        return self.file_of(self.key(scene))

    def file_of(self, key: str) -> Path:
        """Where the run of that key is, or would be."""
        return self.folder / key[:2] / f"{key}.nc"

    def find(self, scene: Scene) -> Path | None:
        """The file of the scene's run; None if there is none of its own, or only a damaged one."""
        path = self.path(scene)
        return path if is_whole(path) else None

    def held(self) -> HeldRuns:
        """What the store holds now, of which many keys are asked."""
        return HeldRuns(self)

    def run(
        self,
        scene: Scene,
        progress: Progress | None = None,
        announce: Announce | None = None,
    ) -> xr.Dataset:
        """The scene's run, of a file of its own or of a sweep's pack, or made as by `fetch`."""
        from longwave.runs.run_file import load_run

        found = self._told_place(scene)
        if isinstance(found, PackedRun):
            return found.load()
        return load_run(found or self._made(scene, progress, announce), follow=False)

    def _told_place(self, scene: Scene) -> Path | PackedRun | None:
        """Where the scene's run is, which is told."""
        path = self.path(scene)
        found = path if is_whole(path) else self._packed(path.stem)
        if found is not None:
            place = found if isinstance(found, Path) else found.path
            LOG.info("%s: found in %s, not run again", scene.name, place)
        return found

    def _packed(self, key: str) -> PackedRun | None:
        held = pack_index(self.folder).get(key)
        return None if held is None else held[1]

    def keep(self, scene: Scene, run: xr.Dataset) -> Path:
        """Put the run of a scene that was made elsewhere into the store; return its file.

        Raises ValueError for an unfinished run and OSError where it cannot be written.
        """
        path = self.path(scene)
        with self._alone(path):
            return _kept(path, run)

    def fetch(
        self,
        scene: Scene,
        progress: Progress | None = None,
        announce: Announce | None = None,
    ) -> Path:
        """The file of the scene's run, which is made if there is none; one in a sweep's pack gets
        a file.

        If another process is making it, that is waited for; one that was begun is gone on with, and
        ends with the bits of one that was not interrupted. ``progress`` and ``announce`` are as in
        `scene_run.run`. Raises what that raises; OSError before the run if the store cannot be
        written; UnkeptRunError, which holds the run, if it could not be written after it.
        """
        found = self._told_place(scene)
        if isinstance(found, PackedRun):
            return self.keep(scene, found.load())
        return found or self._made(scene, progress, announce)

    def _made(self, scene: Scene, progress: Progress | None, announce: Announce | None) -> Path:
        from longwave.scenes.engines import scene_run

        path = self.path(scene)
        with self._alone(path):
            if is_whole(path):
                return path
            check_sources()
            folder = path.with_suffix(".unfinished")
            checkpoint = CheckpointFolder(folder, run_stamp(path.stem), *self._pace)
            checkpoint.tell(scene.name)
            with checkpoints_in(checkpoint):
                run = scene_run.run(scene, progress, announce)
            try:
                if not is_whole(path):  # where locks do nothing, another may have made it
                    _kept(path, run)
            except OSError as error:
                raise UnkeptRunError(error, run) from error
            checkpoint.clear()
            return path

    @contextmanager
    def _alone(self, path: Path) -> Iterator[None]:
        """Be the only one who makes the run of that file; drafts of killed processes go."""
        path.parent.mkdir(parents=True, exist_ok=True)
        check_no_link(path.parent)
        with locked(path.with_suffix(".lock"), lambda: LOG.info(WAITING, path)):
            remove_dead_drafts(path.parent, path.stem)
            yield


class HeldRuns(Container[str]):
    """What a store held when it was asked: its packs, and by one listing the files of runs.

    ``key in held`` says whether its cell is not run again: for there is its run, in a pack or a
    whole file, or it has none.
    """

    def __init__(self, store: RunStore) -> None:
        self.packs = pack_index(store.folder)
        self._store = store
        self._files = frozenset(path.stem for path in store.folder.glob("??/*.nc"))

    def file(self, key: str) -> Path | None:
        """The run's own file; None if there is none, or only a damaged one."""
        path = self._store.file_of(key)
        return path if key in self._files and is_whole(path) else None

    def __contains__(self, key: object) -> bool:
        return isinstance(key, str) and (self.packs.settles(key) or self.file(key) is not None)


def run_key(scene: Scene) -> str:
    """The key of a scene's run, 40 hexadecimal digits; equal scenes have equal keys.

    Raises ValueError for a scene with a wave of one's own, of which only the name is known.
    """
    if not isinstance(scene.wave, str):
        raise ValueError(
            f"wave must be a shipped one for its run to be kept in a store, got one of your "
            f"own, {scene.wave.name} (run it and save it)"
        )
    asked = json.dumps(_canonical(json.loads(scene.json())), sort_keys=True)
    text = f"{type(scene).__name__}\n{asked}\n{code_that_matters()}"
    return hashlib.sha256(text.encode()).hexdigest()[:40]


def _kept(path: Path, run: xr.Dataset) -> Path:
    from longwave.runs.run_file import file_content

    if "unfinished" in run.attrs:
        raise ValueError(
            f"run must have come to its end to be kept in a store, got one that did not "
            f"({run.attrs['unfinished']})"
        )
    write_sealed(path, file_content(run))
    return path


def _canonical(value: Any) -> Any:
    """The same for values that are equal: 1, 1.0 and True; 0.0 and -0.0.

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
def code_that_matters() -> str:
    """The digest of the sources and the versions that a run's numbers follow from."""
    from longwave.support.provenance import provenance

    made = provenance()
    versions = [text for text in made["versions"].split(", ") if not text.startswith(UNMOVED)]
    return hashlib.sha256("\n".join([made["code"], *versions]).encode()).hexdigest()


@lru_cache
def runs_its_sources() -> bool:
    """Whether what is in memory is what the files say."""
    from longwave.support.compiled.source_digest import runs_as_written
    from longwave.support.provenance import code_files

    files = code_files()
    stems = [".".join(("longwave", *file.with_suffix("").parts)) for file in files]
    names = [stem.removesuffix(".__init__") for stem in stems]
    return runs_as_written(tuple(zip(names, files.values(), strict=True)))


def check_sources() -> None:
    """Raise ValueError if what is in memory may not be what the files say: no run is kept then."""
    if not runs_its_sources():
        raise ValueError(
            "sources must be what this process runs for its runs to be kept in a store, got some "
            "that changed since it began (start it again)"
        )
