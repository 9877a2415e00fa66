"""Readers of files, and what may stand at their paths, for `searches.swapped_files`.

Each reader has two contents that it takes, of the values `FIRST` and `SECOND`, and others that it
refuses when it meets them alone, of the value `FOREIGN`: links, pipes, arrays in other files, files
that are damaged, too long or another user's.
"""

from __future__ import annotations

import json
import os
import re
import shutil
from collections.abc import Callable, Iterable, Iterator, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np
import xarray as xr

from longwave.cli.certificates import read_certificates
from longwave.cli.verdict_lines import VerdictLines
from longwave.derive import LATTICES, read_lattice
from longwave.lattice.numeric_lattice import numeric_lattice
from longwave.reports.studies.estimates import Judged, judged_scenes
from longwave.runs.run_file import file_content, load_run, names_a_run, open_run
from longwave.runs.run_pack import (
    DONE,
    REFUSED,
    CellRecord,
    is_pack,
    load_row,
    merged_content,
    pack_content,
    read_pack,
)
from longwave.runs.run_store import RunStore
from longwave.runs.store_packs import INDEX, INDEXED_CHANGES, PACKS, pack_index
from longwave.runs.sweep_fields import swept_fields
from longwave.runs.sweep_file import load_sweep
from longwave.scenes.description.csv_table import with_columns
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.fits.force_data import read_force
from longwave.scenes.fits.sensor_records import read_record
from longwave.solutions.data_store import DataStore
from longwave.support.checkpoint import LOOP, CheckpointFolder
from longwave.support.compiled.kernel_folder import CacheFolder
from longwave.support.plain_data import plain_bytes
from longwave.support.sealed_file import write_sealed
from longwave.verify.problem_file import problem_texts

FIRST, SECOND, OTHER, FOREIGN = 1.0, 2.0, 11.0, 666.0
"""Values of the two contents, of runs that were not asked for, and of what is never to be read."""

NOBODY = 65534
"""A user to whom no file of ours belongs."""

EARLIER = 1_600_000_000 * 10**9
"""When all files were last written, in nanoseconds: a swapped one is told by no time."""

SHAPE = 20, 1000
"""Of a run's arrays: reading them takes some milliseconds."""

SCALES = "DIMENSION_LIST", "REFERENCE_LIST"
"""Attributes that the library alone may write."""

STAMP, TASK, KEY = "stamp", "task", "ab" + 38 * "0"

Values = Iterable[float]


class State(NamedTuple):
    """Something that may stand at a path: ``file``, or a link to it.

    ``value`` is what a reader finds that meets it alone; None if it refuses.
    """

    name: str
    file: Path
    value: float | None
    is_link: bool = False


class Case(NamedTuple):
    """A path, the states that take turns there, and a reader of its values."""

    path: Path
    states: Sequence[State]
    read: Callable[[], Values]


class Folder:
    """A new folder in which the states of a case are prepared."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.foreign = folder / "foreign"
        self.foreign.mkdir(parents=True)
        self.place = folder / "place"
        self.place.mkdir()

    def state(self, name: str, content: bytes, value: float | None, mode: int = 0o600) -> State:
        """Return a file of that content."""
        path = self.folder / f"{name.replace(' ', '_')}.state"
        path.write_bytes(content)
        path.chmod(mode)
        os.utime(path, ns=(EARLIER, EARLIER))
        return State(name, path, value)

    def pipe(self) -> State:
        """Return a pipe, which nobody writes to."""
        path = self.folder / "pipe.state"
        os.mkfifo(path)
        return State("pipe", path, None)

    def link(self, content: bytes, value: float | None = None) -> State:
        """Return a link to a file of that content in another folder."""
        path = self.foreign / "content"
        path.write_bytes(content)
        path.chmod(0o600)
        os.utime(path, ns=(EARLIER, EARLIER))
        return State("link", path, value, is_link=True)

    def sealed(self, content: bytes) -> bytes:
        """Return the content with its seal."""
        path = self.folder / "draft"
        write_sealed(path, content, durable=False)
        found = path.read_bytes()
        path.unlink()
        return found


def _damaged(sealed: bytes) -> bytes:
    """Return a sealed file whose last digit is another one."""
    last = b"0" if sealed[-2:-1] != b"0" else b"1"
    return sealed[:-2] + last + sealed[-1:]


def _even(contents: Sequence[bytes]) -> list[bytes]:
    """Return the contents, of one length: what follows the end of HDF5 is passed over."""
    longest = max(map(len, contents))
    return [content.ljust(longest, b"\0") for content in contents]


def _run(value: float) -> xr.Dataset:
    fields = {name: (("time", "site"), np.full(SHAPE, value)) for name in ("first", "second")}
    return xr.Dataset(fields, attrs={"value": value})


def _values(run: xr.Dataset) -> set[float]:
    found = {float(value) for v in run.variables.values() for value in np.unique(v.values)}
    return found | {float(run.attrs["value"])}


def _elsewhere(content: bytes, array: str, secret: Path) -> Iterator[tuple[str, bytes]]:
    """Yield files in HDF5 with an array in another file, one for each way to put it there."""
    raw, container = secret / "raw", secret / "held.h5"
    for kind in ("external", "virtual", "linked"):
        image = BytesIO(content)
        with h5py.File(image, "r+") as file:
            group, _, name = array.rpartition("/")
            old, inside = file[array], file[group or "/"]
            shape = old.shape
            attributes = {key: old.attrs[key] for key in old.attrs if key not in SCALES}
            del file[array]
            values = np.full(shape, FOREIGN)
            raw.write_bytes(values.tobytes())
            with h5py.File(container, "w") as other:
                other["a"] = values
            if kind == "linked":
                inside[name] = h5py.ExternalLink(container, "a")
            elif kind == "external":
                places = [(str(raw), 0, values.nbytes)]
                inside.create_dataset(name, shape, "f8", external=places).attrs.update(attributes)
            else:
                layout = h5py.VirtualLayout(shape, "f8")
                layout[...] = h5py.VirtualSource(container, "a", shape)
                inside.create_virtual_dataset(name, layout).attrs.update(attributes)
        yield kind, image.getvalue()


def _typed_run(folder: Folder, read: Callable[[Path], xr.Dataset]) -> Case:
    """Return a run that a user names: its name may be a link."""
    first, second = (file_content(_run(value)) for value in (FIRST, SECOND))
    foreign = dict(_elsewhere(first, "first", folder.foreign))
    contents = _even([first, second, *foreign.values()])
    values = [FIRST, SECOND, *len(foreign) * [None]]
    names = ["first", "second", *foreign]
    states = [folder.state(*state) for state in zip(names, contents, values, strict=True)]
    states += [folder.pipe(), folder.link(contents[1], SECOND)]
    path = folder.place / "run"

    def values_of() -> Values:
        if not names_a_run(path):
            raise ValueError("no run")
        return _values(read(path))

    return Case(path, states, values_of)


def a_run(folder: Folder) -> Case:
    """Return `load_run` of a name that a user typed."""
    return _typed_run(folder, load_run)


def a_run_in_parts(folder: Folder) -> Case:
    """Return `open_run`, whose values are read one after the other."""

    def read(path: Path) -> xr.Dataset:
        with open_run(path) as run:
            return run.map(lambda variable: variable.copy(data=variable.values)).assign_attrs(
                run.attrs
            )

    return _typed_run(folder, read)


def _sealed_states(
    folder: Folder, contents: Sequence[bytes], array: str, linked: bytes
) -> list[State]:
    """Return two sealed files in HDF5, the first with an array elsewhere, damaged, and links."""
    foreign = dict(_elsewhere(contents[0], array, folder.foreign)) if array else {}
    even = _even([*contents, linked, *foreign.values()])
    first, second, other, *rest = map(folder.sealed, even)
    states = [folder.state("first", first, FIRST), folder.state("second", second, SECOND)]
    states += [folder.state(*state, None) for state in zip(foreign, rest, strict=True)]
    states += [folder.state("damaged", _damaged(other), None), folder.pipe(), folder.link(other)]
    return states


def _store_file(folder: Folder) -> tuple[Path, list[State], Callable[[], Values]]:
    store = RunStore(folder.place)
    path = store.file_of(KEY)
    path.parent.mkdir()
    contents = [file_content(_run(value)) for value in (FIRST, SECOND, FOREIGN)]

    def read() -> Values:
        found = store.stored_runs().file(KEY)
        if found is None:
            raise ValueError("missing")
        return _values(load_run(found, follow=False))

    return path, _sealed_states(folder, contents[:2], "first", contents[2]), read


def a_stores_file(folder: Folder) -> Case:
    """Return a run's own file in a store."""
    return Case(*_store_file(folder))


def _as_link(folder: Folder, case: Case, mine: Path) -> Case:
    """Return the case with the folder ``mine`` swapped, by a link to a folder of the same names."""
    shutil.copytree(mine, folder.foreign / mine.name)
    link = next(state for state in case.states if state.is_link)
    first = next(state for state in case.states if state.value == FIRST)
    inside = case.path.relative_to(mine)
    shutil.copy2(link.file, folder.foreign / mine.name / inside)
    shutil.copy2(first.file, case.path)
    home = folder.folder / "home"
    mine.rename(home)
    states = [
        State("first", home, FIRST),
        State("link", folder.foreign / mine.name, None, is_link=True),
    ]
    return Case(mine, states, case.read)


def a_stores_inner_folder(folder: Folder) -> Case:
    """Return the folder of a run's own file in a store."""
    case = a_stores_file(folder)
    return _as_link(folder, case, case.path.parent)


def _pack(values: Sequence[float], keys: Sequence[str] = ("k0", "k1")) -> bytes:
    """Return a pack of runs of these values."""
    return pack_content(
        CellRecord(key, DONE, numbers={"error": value, "steps": value}, run=_run(value))
        for key, value in zip(keys, values, strict=True)
    )


def _packs(folder: Folder, path: Path, read: Callable[[], Values]) -> Case:
    contents = [_pack([value, value]) for value in (FIRST, SECOND, FOREIGN)]
    return Case(path, _sealed_states(folder, contents[:2], "0/arrays/first", contents[2]), read)


def a_packs_row(folder: Folder) -> Case:
    """Return one run of a pack."""
    path = folder.place / "p.h5"
    return _packs(folder, path, lambda: _values(load_row(path, 0, 0)))


def a_packs_table(folder: Folder) -> Case:
    """Return the table of a pack."""
    path = folder.place / "p.h5"

    def read() -> Values:
        numbers = read_pack(path).numbers
        return {float(value) for name in ("error", "steps") for value in numbers[name]}

    return _packs(folder, path, read)


def merged_packs(folder: Folder) -> Case:
    """Return a pack as it is merged into another."""
    path = folder.place / "p.h5"

    def read() -> Values:
        if not is_pack(path):
            raise ValueError("no pack")
        with h5py.File(BytesIO(merged_content([(path, 1)]))) as file:
            groups = [*file.values()]
            arrays = [a for group in groups for a in group["arrays"].values()]
            return {float(v) for array in arrays for v in np.unique(array[()])}

    return _packs(folder, path, read)


def _packed(folder: Folder, read: Callable[[Any], Values]) -> Case:
    """Return the pack of the key "k0" in a store with an index; the two packs have other rows."""
    path = folder.place / PACKS / "ab" / "p.h5"
    path.parent.mkdir(parents=True)
    for number in range(INDEXED_CHANGES):
        content = pack_content([CellRecord(f"other{number}", REFUSED)])
        write_sealed(path.with_name(f"{number}.h5"), content, durable=False)
    contents = [
        _pack([FIRST, OTHER]),
        _pack([OTHER, SECOND], ("k1", "k0")),
        _pack([FOREIGN, FOREIGN]),
    ]
    states = _sealed_states(folder, contents[:2], "0/arrays/first", contents[2])
    shutil.copy2(states[0].file, path)
    pack_index(folder.place)
    assert (path.parents[1] / INDEX).exists()

    def values() -> Values:
        entry = pack_index(folder.place).get("k0")
        if entry is None or entry[1] is None:
            raise ValueError("missing")
        return read(entry[1])

    return Case(path, states, values)


def a_packed_run(folder: Folder) -> Case:
    """Return a run by its key, through the index of packs."""
    return _packed(folder, lambda place: _values(place.load()))


def _fields(place: Any) -> Values:
    found = swept_fields(("cell",), (1,), {0: place}, ())
    return {float(v) for _, variable, _ in found for v in np.unique(variable.values)}


def a_swept_field(folder: Folder) -> Case:
    """Return the fields of a sweep, read from a pack."""
    return _packed(folder, _fields)


def the_packs_folder(folder: Folder) -> Case:
    """Return the folder of a store's packs."""
    case = a_packed_run(folder)
    return _as_link(folder, case, folder.place / PACKS)


def a_folder_of_packs(folder: Folder) -> Case:
    """Return one of the folders in it."""
    case = a_packed_run(folder)
    return _as_link(folder, case, case.path.parent)


def the_index_of_packs(folder: Folder) -> Case:
    """Return the index of a store's packs; a foreign one has other numbers for the same packs."""
    places = folder.place, folder.foreign / "store"
    for place, value in zip(places, (FIRST, FOREIGN), strict=True):
        for number in range(INDEXED_CHANGES):
            path = place / PACKS / f"{number}.h5"
            path.parent.mkdir(parents=True, exist_ok=True)
            write_sealed(path, _pack([value], [f"k{number}"]), durable=False)
            os.utime(path, ns=(EARLIER, EARLIER))
        pack_index(place)
    mine, other = ((place / PACKS / INDEX).read_bytes() for place in places)
    states = [
        folder.state("first", mine, FIRST), folder.state("damaged", _damaged(other), FIRST),
        folder.pipe()._replace(value=FIRST), folder.link(other, FIRST),
    ]  # fmt: skip

    def read() -> Values:
        index = pack_index(folder.place)
        return {index.table.record(row).numbers["error"] for row in range(len(index))}

    return Case(folder.place / PACKS / INDEX, states, read)


def _checkpoint(folder: Folder, value: float, stamp: str = STAMP) -> bytes:
    place = folder.folder / "draft"
    memory = {"seconds": 1.0, "state": np.full(10**5, value), "last": value}
    CheckpointFolder(place, stamp).write("1", TASK, memory)
    content = (place / f"1{LOOP}").read_bytes()
    shutil.rmtree(place)
    return content


def a_checkpoint(folder: Folder) -> Case:
    """Return a checkpoint of a loop."""
    place = folder.place / "run.unfinished"
    place.mkdir()
    states = [
        folder.state("first", _checkpoint(folder, FIRST), FIRST),
        folder.state("second", _checkpoint(folder, SECOND), SECOND),
        folder.state("of another run", _checkpoint(folder, FOREIGN, "other"), None),
        folder.state("damaged", _damaged(_checkpoint(folder, FOREIGN)), None),
        folder.pipe(),
        folder.link(_checkpoint(folder, FOREIGN)),
    ]

    def read() -> Values:
        keeper = CheckpointFolder(place, STAMP)
        keeper.tell("run")
        memory = keeper.read("1", TASK)
        if memory is None:
            raise ValueError("missing")
        return {memory["last"], *np.unique(memory["state"]).tolist()}

    return Case(place / f"1{LOOP}", states, read)


def a_checkpoints_folder(folder: Folder) -> Case:
    """Return the folder of a run's checkpoints."""
    case = a_checkpoint(folder)
    return _as_link(folder, case, case.path.parent)


def _cache(
    folder: Folder, name: str, written: Callable[[float], bytes], read: Callable[[], Values]
) -> Case:
    """Return a file of a cache, in ``folder.place``."""
    folder.place.chmod(0o700)

    def content(value: float, called: str = name) -> bytes:
        (folder.place / called).unlink(missing_ok=True)
        CacheFolder(folder.place).write(called, written(value))
        found = (folder.place / called).read_bytes()
        (folder.place / called).unlink()
        return found

    states = [
        folder.state("first", content(FIRST), FIRST),
        folder.state("second", content(SECOND), SECOND),
        folder.state("open to others", content(FOREIGN), None, 0o666),
        folder.state("of another name", content(FOREIGN, "other"), None),
        folder.state("damaged", _damaged(content(FOREIGN)), None),
        folder.pipe(),
        folder.link(content(FOREIGN)),
    ]
    if os.geteuid() == 0:
        states.append(folder.state("another user's", content(FOREIGN), None))
        os.chown(states[-1].file, NOBODY, NOBODY)
    return Case(folder.place / name, states, read)


def machine_code(folder: Folder) -> Case:
    """Return a file of the cache of machine code."""

    def read() -> Values:
        data = CacheFolder(folder.place).read("code")
        if data is None:
            raise ValueError("missing")
        return set(np.unique(np.frombuffer(data)).tolist())

    return _cache(folder, "code", lambda value: np.full(10**5, value).tobytes(), read)


def numbers_of_waves(folder: Folder) -> Case:
    """Return a file of the cache of waves."""
    store = DataStore("maker", "key", CacheFolder(folder.place))

    def read() -> Values:
        found = store.read("data")
        if found is None:
            raise ValueError("missing")
        return set(np.unique(found).tolist())

    def written(value: float) -> bytes:
        return plain_bytes(np.full(10**4, value))

    return _cache(folder, f"{store._stem}.data", written, read)


def the_cache_folder(folder: Folder) -> Case:
    """Return the folder of a cache, in turn with a link, and one that is open to others."""
    case = _as_link(folder, machine_code(folder), folder.place)
    link = next(state for state in case.states if state.is_link)
    link.file.chmod(0o700)
    shared = folder.folder / "shared"
    shutil.copytree(link.file, shared)
    shared.chmod(0o777)
    return Case(case.path, [*case.states, State("open to others", shared, None)], case.read)


NUMBER = re.compile(r"(?<![\w.])(?:1|2|666)\.0(?![\w.])")


def _text(
    folder: Folder,
    written: Callable[[float], str],
    read: Callable[[Path], object],
    most: int,
    name: str = "file.toml",
) -> Case:
    """Return a text that a user names. The values are all those in the resulting object."""
    first, second, foreign = (written(value) for value in (FIRST, SECOND, FOREIGN))
    path = folder.place / name
    longer = foreign + "\n" * most
    states = [
        folder.state("first", first.encode(), FIRST),
        folder.state("second", second.encode(), SECOND),
        folder.state("too long", longer.encode(), None),
        folder.state("no UTF-8", foreign.encode() + b"\xff", None),
        folder.pipe(),
        folder.link(second.encode(), SECOND),
        State("device", Path("/dev/zero"), None, is_link=True),
    ]
    return Case(path, states, lambda: _numbers(read(path)))


def _numbers(found: object) -> set[float]:
    """Return the values that the text of an object holds."""
    return {float(number) for number in NUMBER.findall(str(found))}


SCENE = """lattice = "chain"
wave = "soliton_sech"
eps = 0.1
t0 = 0
snapshots = [0, 4]
observables = ["strain"]
constants = {{K2 = {0}, K4 = {0}}}
parameters = {{A = {0}}}
scheme = {{name = "rk4", step = 0.5}}
domain = {{kind = "ring", sites = 192, compared = 20}}
"""

SWEEP = """title = "of {0}"
[scene]
lattice = "fput_strain"
wave = "rogue_cn"
eps = 0.1
slow_times = [-0.5, 0, 0.5]
half_width = 10
tolerance = 1e-3
constants = {{ K2 = 1.5, K3 = 0, K4 = {0} }}
[grid]
eps = [0.05, 0.07]
parameters.k = [0.25, 0.5]
"""

LATTICE = """name = "x"
title = "{0} and {0}"
fields = ["u"]
positive = ["K2"]
[[spring]]
between = ["u[n]", "u[n+1]"]
force = "K2*x"
"""

PROBLEM = """[[problem]]
name = "one of {0}"
equation = ["u_t + {0}*u_x"]
solution = ["u = x - {0}*t"]
"""

LINES = """{{"key": "a", "verdict": {0}}}
{{"key": "b", "verdict": {0}}}
"""


def a_scene(folder: Folder) -> Case:
    """Return a scene."""

    def read(path: Path) -> object:
        stated = json.loads(load_scene(path).json())
        return [float(number) for _, number in stated["constants"] + stated["parameters"]]

    return _text(folder, SCENE.format, read, 10**6)


def a_scenes_lattice(folder: Folder) -> Case:
    """Return the lattice that a scene names."""
    scene = folder.place / "scene.toml"
    scene.write_text(
        'lattice = "file.toml"\nwave = "soliton_sech"\neps = 0.1\nt0 = 0\nsnapshots = [0, 4]\n'
        "constants = {K2 = 1.5}\nparameters = {A = 0.5}\ntolerance = 1e-3\nhalf_width = 10\n"
    )
    return _text(folder, LATTICE.format, lambda _: load_scene(scene).document(), 10**6)


def a_lattice(folder: Folder) -> Case:
    """Return a lattice."""
    return _text(folder, LATTICE.format, lambda path: read_lattice(path).title, 10**5)


def a_sweep(folder: Folder) -> Case:
    """Return a sweep."""
    return _text(folder, SWEEP.format, lambda path: load_sweep(path).json(), 10**6)


def problems(folder: Folder) -> Case:
    """Return statements."""
    return _text(folder, PROBLEM.format, problem_texts, 10**7)


def certificates(folder: Folder) -> Case:
    """Return certificates."""
    read: Callable[[Path], object] = read_certificates
    return _text(folder, '[{{"a": {0}}}, {{"b": {0}}}]'.format, read, 10**7, "file.json")


def estimates(folder: Folder) -> Case:
    """Return records of estimates."""
    fields = dict.fromkeys(Judged.__dataclass_fields__, 0)

    def written(value: float) -> str:
        return json.dumps(fields | {"estimate": value, "own": value}) + "\n"

    return _text(folder, written, judged_scenes, 10**8, "file.jsonl")


def verdict_lines(folder: Folder) -> Case:
    """Return stored verdicts, which nobody else may have written."""

    def read(path: Path) -> object:
        return VerdictLines(str(path), 1.0, lambda: "")._records

    case = _text(folder, LINES.format, read, 0, "lines.jsonl")
    content = LINES.format(FOREIGN).encode()
    states = [state for state in case.states if state.name not in ("too long", "no UTF-8")]
    states.append(folder.state("open to others", content, None, 0o666))
    if os.geteuid() == 0:
        states.append(folder.state("another user's", content, None))
        os.chown(states[-1].file, NOBODY, NOBODY)
    return Case(case.path, states, case.read)


def a_scenes_table(folder: Folder) -> Case:
    """Return a table that a scene names."""
    table = {"file": "file.csv"}
    return _text(
        folder, "a,b\n{0},{0}\n{0},{0}\n".format, lambda p: with_columns(table, p.parent), 10**6,
        "file.csv",
    )  # fmt: skip


def a_force_law(folder: Folder) -> Case:
    """Return the points of a force law, on a line through 0 of the value's slope."""

    def written(slope: float) -> str:
        rows = (f"{x / 64},{slope * x / 64}" for x in range(-32, 33))
        return "\n".join(["stretch,force", *rows, ""])

    def read(path: Path) -> object:
        data = read_force(path)
        inside = data.stretch != 0
        return np.unique(data.force[inside] / data.stretch[inside]).tolist()

    return _text(folder, written, read, 10**8, "file.csv")


def a_record_of_sensors(folder: Folder) -> Case:
    """Return a record of sensors."""
    dimer = LATTICES["mass_dimer"]
    lattice = numeric_lattice(dimer, {str(symbol): 1 for symbol in dimer.constants})

    def read(path: Path) -> object:
        return read_record(path, lattice, 4, (0.0, 1.0)).values.tolist()

    written = f"time;strain_0_1;strain_0_2\n0.5;{'{0}'};{'{0}'}\n0.75;{'{0}'};{'{0}'}\n".format
    return _text(folder, written, read, 10**8, "file.csv")


READERS: dict[str, Callable[[Folder], Case]] = {
    build.__name__: build
    for build in (
        a_run, a_run_in_parts, a_stores_file, a_stores_inner_folder, a_packs_row, a_packs_table,
        merged_packs, a_packed_run, a_swept_field, the_packs_folder, a_folder_of_packs,
        the_index_of_packs, a_checkpoint, a_checkpoints_folder, machine_code, numbers_of_waves,
        the_cache_folder, a_scene, a_scenes_lattice, a_lattice, a_sweep, problems, certificates,
        estimates, verdict_lines, a_scenes_table, a_force_law, a_record_of_sensors,
    )
}  # fmt: skip
