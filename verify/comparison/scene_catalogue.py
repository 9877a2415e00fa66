"""The scenes that come with the package: the paper's, further ones, and families of them."""

from collections.abc import Sequence
from importlib.resources import as_file, files
from importlib.resources.abc import Traversable
from pathlib import Path

from verify.comparison.scene import Scene

FOLDER = files("verify.comparison.scenes")
FURTHER = files("verify.comparison.scenes.further")


def shipped_scenes() -> tuple[str, ...]:
    """Names of the paper's scenes, which come with the package, sorted.

    >>> "rational_2_eps_0.05" in shipped_scenes()
    True
    """
    return _names(FOLDER)


def further_scenes() -> tuple[str, ...]:
    """Names of the scenes that come with the package and go beyond the paper, sorted.

    >>> "rogue_cn_k_0.5_long" in further_scenes()
    True
    """
    return _names(FURTHER)


def load_scene(name: str) -> Scene:
    """The shipped scene of that name, the paper's or a further one; ValueError lists them."""
    for folder in (FOLDER, FURTHER):
        if name in _names(folder):
            with as_file(folder / f"{name}.toml") as path:
                return Scene.from_toml(path)
    known = ", ".join((*shipped_scenes(), *further_scenes()))
    raise ValueError(f"scene must be a TOML file or a shipped scene, got {name!r} (one of {known})")


def _names(folder: Traversable) -> tuple[str, ...]:
    found = (entry.name for entry in folder.iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in found if name.endswith(".toml")))


ORDERS = (2, 3, 4, 5)
EPS = (0.1, 0.05, 0.025, 0.0125, 0.00625)

SLOW_START = -1.25
"""T = eps^3 t at the beginning: t = -10000 at eps = 0.05, as in the paper's scene."""

SLOW_SNAPSHOTS = (-0.625, 0.0, 0.625)
"""Slow times of the snapshots: those of the paper's scene."""

HALF_WIDTH = 75.0
"""Half-width of the compared region in X, 1500 sites at eps = 0.05."""


def rational_family_scenes(
    orders: Sequence[int] = ORDERS, eps: Sequence[float] = EPS, tolerance: float = 1e-4
) -> dict[str, Scene]:
    """The scenes Y_j at each eps by name, same slow times and same range of X.

    >>> scene = rational_family_scenes()["Y5_eps_0.025"]
    >>> scene.wave, scene.t0, scene.compared
    ('rational_5', -80000.0, 3000)
    """
    scenes = [_member(order, value, tolerance) for order in orders for value in eps]
    return {scene.name: scene for scene in scenes}


def _member(order: int, eps: float, tolerance: float) -> Scene:
    return Scene.of(
        name=f"Y{order}_eps_{eps:g}",
        title=f"Rational solution of order {order}, eps = {eps:g}",
        wave=f"rational_{order}",
        eps=eps,
        t0=_time(SLOW_START, eps),
        snapshots=tuple(_time(T, eps) for T in SLOW_SNAPSHOTS),
        K2=4.0,
        K4=1.0,
        compared=round(HALF_WIDTH / eps),
        tolerance=tolerance,
        observables=("strain",),
    )


def _time(T: float, eps: float) -> float:
    """The lattice time of a slow time, rounded to whole units."""
    return float(round(T / eps**3))


def find_scene(text: str) -> Scene:
    """The scene in a TOML file, or the shipped one or member of a family of that name.

    Raises ValueError for a file that cannot be read and a name that is none.
    """
    if text.endswith(".toml") or Path(text).is_file():
        return Scene.from_toml(text)
    family = rational_family_scenes()
    return family[text] if text in family else load_scene(text)
