"""Scenes of any lattice: found by their name or in a file, and run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from longwave.scenes.chain.scene import (
    Scene,
    further_scenes,
    rational_family_scenes,
    shipped_scenes,
)
from longwave.scenes.chain.scene import (
    load_scene as load_chain_scene,
)
from longwave.scenes.chain.scene_fields import parse_document, read_document
from longwave.scenes.lattice_scene import (
    LatticeScene,
    load_lattice_scene,
    shipped_lattice_scenes,
)
from longwave.scenes.lattice_scene_file import names_a_lattice
from longwave.support.user_files import STANDARD_INPUT, shown

if TYPE_CHECKING:
    import xarray as xr

    from longwave.lattice.refine import Announce
    from longwave.lattice.trial import Progress

AnyScene: TypeAlias = Scene | LatticeScene


def load_scene(text: str | Path) -> AnyScene:
    """The scene in a TOML file, or the shipped one of that name.

    ``-`` is the standard input, a file of a lattice being looked for in the working folder.

    Raises ValueError for a file that cannot be read and a name that is none.
    """
    name = str(text)
    if name == STANDARD_INPUT or name.endswith(".toml") or Path(name).is_file():
        return _of_document(read_document(name), Path(name))
    if name in shipped_lattice_scenes():
        return load_lattice_scene(name)
    family, names = rational_family_scenes(), (*shipped_scenes(), *further_scenes())
    if name in family:
        return family[name]
    if name in names:
        return load_chain_scene(name)
    known = ", ".join((*names, *shipped_lattice_scenes()))
    raise ValueError(
        f"scene must be a TOML file or a shipped scene, got {shown(text)} (one of {known})"
    )


def scene_of_toml(text: str) -> AnyScene:
    """The scene that ``toml`` wrote; ValueError in one line for what is none."""
    return _of_document(parse_document(text.encode(), "a text"), Path("scene"))


def _of_document(document: Mapping[str, Any], path: Path) -> AnyScene:
    swept = {"grid", "list", "random"} & document.keys()
    if "scene" in document and swept:
        raise ValueError(
            f"{path}: a scene must be one, got a sweep, which has [{min(swept)}] (run it with "
            "`longwave sweep`)"
        )
    kind = LatticeScene if names_a_lattice(document) else Scene
    return kind.of_document(document, path)


def run(
    scene: AnyScene | str | Path,
    progress: Progress | None = None,
    announce: Announce | None = None,
) -> xr.Dataset:
    """Run a scene, given as such, by its name or by its file, and return what it asks for.

    The data set holds lattice and wave at the times that are asked for, ``error`` and what the
    scene's observables add; attributes say what made it, its estimated error and cost, and what can
    be trusted of it (`Scene.run`, `LatticeScene.run`). ``progress`` is called with the share of the
    work that is done, ``announce`` with the seconds that are expected to pass, if they are many.

    Raises ValueError in one line for what is no scene and for what the wave, the lattice or the
    limits do not admit, and UnfinishedRun on Ctrl-C.
    """
    if isinstance(scene, str | Path):
        scene = load_scene(scene)
    made: Callable[..., xr.Dataset] | None = getattr(scene, "run", None)
    if made is None:
        raise ValueError(
            f"scene must be a scene, its name or its file, got {shown(scene)} (such as "
            "'rogue_cn_k_0.5')"
        )
    return made(progress, announce)
