"""Seeds of hostile inputs: small files of each kind, and those that are shipped."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

HOUSE = Path(__file__).resolve().parents[1]

SMALL_SCENE = """\
title = "small"
wave = "soliton_sech"
eps = 0.1
t0 = -10
snapshots = [0, 10]
observables = ["strain", "error_curve"]
curve_points = 11
tolerance = 1e-3

[lattice]
K2 = 1
K3 = 0
K4 = 1

[parameters]
A = 1

[domain]
compared = 40
"""

STATED_SCENE = """\
title = "stated"
wave = "rogue_cn"
eps = 0.1
t0 = -5
snapshots = [-5, 0, 5]
observables = ["strain", "error_curve", "time_step_error", "domain_error"]
curve_points = 11
look_points = 5

[lattice]
K2 = 1
K4 = 1

[parameters]
k = 0.5

[scheme]
name = "kahan_li_8"
step = 0.5

[domain]
kind = "ring"
sites = 512
compared = 50
"""

SMALL_LATTICE_SCENE = """\
title = "small"
lattice = "toda"
wave = "kdv_soliton"
eps = 0.2
slow_times = [0, 0.2]
half_width = 3
tolerance = 1e-3

[constants]
a = 1
b = 1

[parameters]
kappa = 1
"""

DISORDERED_SCENE = """\
title = "small"
lattice = "fput_strain"
wave = "soliton_sech"
eps = 0.2
order = "slaved"
times = [0, 20]
half_width = 3
tolerance = 1e-2

[constants]
K2 = 1
K3 = 0
K4 = 1

[parameters]
A = 1

[disorder]
of = "mass"
spread = 0.1
seed = 1
sites = [10, 100]
"""

PERTURBED_SCENE = """\
title = "small"
lattice = "fput"
wave = "perturbed_plane"
eps = 0.1
order = "slaved"
tolerance = 1e-2

[envelope]
k = 1

[parameters]
amplitude = 0.3

[constants]
K2 = 1
K3 = 0.6
K4 = 1
"""

FORCE_LAWS = tuple(
    "\n".join([header, *(row.format(x / 8, x / 8 + x**3 / 999) for x in range(-8, 9, 2))])
    for header, row in (
        ("stretch,force", "{:.3f},{:.4f}"),
        ("stretch,force,deviation", "{:.3f},{:.4f},0.001"),
        ("force;stretch", "{1:.4f};{0:.3f}"),
    )
)

LATTICES = (
    """\
name = "mass_in_mass"
title = "Mass in mass"
fields = ["u", "v"]
masses = ["m1", "m2"]
positive = ["K2", "g", "m1", "m2"]

[[spring]]
between = ["u[n]", "u[n+1]"]
force = "K2*x + K4*x**3"

[[spring]]
between = ["u[n]", "v[n]"]
force = "g*x"

[constants]
K2 = 1.0
K4 = 0.5

[covariance]
K2 = {K2 = 1e-4, K4 = 1e-3}
K4 = {K2 = 1e-3, K4 = 0.04}
""",
    """\
name = "strain"
fields = ["y"]
positive = ["K2"]

[[bond]]
stretch = "y[n]"
action = {y = "F[n+1] - 2*F[n] + F[n-1]"}
force = "K2*x + K3*x**2 + eps*K4*x**3"
""",
    """\
name = "site"
fields = ["u"]
masses = ["1"]
positive = ["K", "h"]

[[spring]]
between = ["u[n]", "u[n+2]"]
force = "K*tanh(x)"

[[site]]
field = "u"
force = "h*sin(x)"
""",
    """\
name = "plane"
fields = ["u"]
positive = ["a", "b"]

[[spring]]
between = ["u[n, m]", "u[n+1, m]"]
force = "a*x + a*x**2"

[[spring]]
between = ["u[n, m]", "u[n, m+1]"]
force = "b*x"
""",
)

SWEEPS = (
    """\
title = "small"

[scene]
wave = "soliton_sech"
eps = 0.1
t0 = 0
snapshots = [5]
tolerance = 1e-2
lattice = { K2 = 1, K4 = 1 }
parameters = { A = 1 }
domain = { compared = 20 }

[set]
tolerance = 1e-3

[grid]
eps = [0.1, 0.2]

[list]
parameters.A = [0.5, 1]
lattice.K4 = [1, 2]
""",
    """\
scene = "toda_soliton"

[set]
slow_times = [0, 0.1]
half_width = 2

[grid]
eps = { from = 0.1, to = 0.2, count = 2, log = true }

[random]
count = 2
seed = 1
parameters.kappa = { from = 0.5, to = 1 }
constants.b = { choose = [1, 2] }
""",
)

PROBLEMS = """\
[[problem]]
name = "KdV soliton"
equation = "u_t + 6*u*u_x + u_xxx"
solution = "u = 2*k**2*sech(k*(x - 4*k**2*t))**2"
parameters = "k: k>0"
domain = "t > 0"
source = "free text"
expect = "PROVED"

[[problem]]
name = "wrong speed"
variant_of = "KdV soliton"
solution = "u = 2*k**2*sech(k*(x - 2*k**2*t))**2"
note = "the speed"
expect = "REFUTED"

[[problem]]
name = "for which c"
equation = ["u_t + c*u_x"]
solution = "u = sin(x - b*t)"
solve = "c"
"""


@cache
def seeds(kind: str) -> tuple[str, ...]:
    """Return the files that are changed; the shipped ones take longer than those made small."""
    folders = {"scene": "scenes/shipped/paper", "lattice scene": "scenes/shipped/lattices"}
    if kind == "lattice":
        return LATTICES
    if kind == "force law":
        return FORCE_LAWS
    if kind == "sweep":
        shipped = sorted((HOUSE / "runs" / "sweeps").glob("*.toml"))
        return *(SWEEPS * 20), *(path.read_text(encoding="utf-8") for path in shipped)
    if kind == "problem":
        return PROBLEMS, *(text for file in _library() for text in file)
    found = sorted((HOUSE / folders[kind]).glob("*.toml"))
    texts = [path.read_text(encoding="utf-8") for path in found]
    small = [SMALL_SCENE, STATED_SCENE]
    if kind == "lattice scene":
        small = [SMALL_LATTICE_SCENE, DISORDERED_SCENE, PERTURBED_SCENE]
    return *(small * 20), *texts


def _library() -> Iterator[list[str]]:
    """Yield the published problems, three a text."""
    for path in sorted((HOUSE / "solutions" / "library").glob("*.toml")):
        tables = re.split(r"^(?=\[\[problem\]\])", path.read_text(encoding="utf-8"), flags=re.M)
        yield ["".join(tables[i : i + 3]) for i in range(1, len(tables), 3)]


PROVED = (
    "kink",
    "soliton_sech",
    "rational_2",
    "kdv_soliton",
    "rogue_cn",
    "wave_cn",
    "nls_peregrine",
)
"""Closed forms whose certificates are changed; so are those of `STATED`, all within a second."""

STATED = (
    ("u_t + 6*u*u_x + u_xxx", "u = 2*k**2*sech(k*(x - 4*k**2*t))**2", "k: k>0"),
    ("diff(u, t, t) = u_xx - sin(u)", "u = 4*atan(exp((x - v*t)/sqrt(1 - v**2)))", "v: -1<v<1"),
    ("I*psi_t + psi_xx + 2*abs(psi)**2*psi", "psi = a*sech(a*x)*exp(I*a**2*t)", "a: a>0"),
    ("diff(u[n], t, t) = u[n+1] - 2*u[n] + u[n-1]", "u[n] = cos(k*n - 2*sin(k/2)*t)", "k: 0<k<1"),
)


@cache
def certificates() -> tuple[str, ...]:
    """Return certificates of closed forms and of statements in text, as JSON."""
    from longwave import prove
    from longwave.verify.proof.catalogue_proofs import prove_named

    named = [[prove_named(name).certificate] for name in PROVED]
    stated = [list(prove(*texts[:2], parameters=texts[2]).certificates) for texts in STATED]
    return tuple(json.dumps(one) for one in named + stated if one)


@cache
def run_files() -> tuple[bytes, ...]:
    """Return files of small runs of both kinds."""
    import tempfile

    from longwave.runs.run_file import save_run
    from longwave.scenes.description.named_scenes import load_scene
    from longwave.scenes.engines import scene_run

    found = []
    with tempfile.TemporaryDirectory() as folder:
        for text in (SMALL_SCENE, STATED_SCENE, SMALL_LATTICE_SCENE):
            path = Path(folder) / "scene.toml"
            path.write_text(text, encoding="utf-8")
            save_run(scene_run.run(load_scene(str(path))), path.with_suffix(".nc"))
            found.append(path.with_suffix(".nc").read_bytes())
    return tuple(found)
