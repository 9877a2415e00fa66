"""longwave: derive the long-wave limit of a lattice, check its solutions, test them on the lattice.

The main names of all rooms are available here: lattices and their reductions, closed forms and
proofs, scenes, runs and pictures. Each is imported on first use, so `import longwave` is quick.

>>> import longwave
>>> longwave.mkdv_normal_form(4, 1).s
1
"""

from typing import Any

from longwave.support.lazy_exports import lazy_exports

__version__: str

_PUBLIC_NAMES = {
    "longwave.derive": "LATTICES Bond Lattice NormalForm Reduction Scaling SlowVariable Stencil "
    "envelope find_scaling mkdv_normal_form reduce",
    "longwave.solutions": "CATALOGUE ClosedForm Equation Parameter Wave closed_form",
    "longwave.verify.proof": "check_certificate prove_equal",
    "longwave.verify.proof.text_prover": "prove",
    "longwave.verify.verdict": "Verdict",
    "longwave.session": "animate converge fit_scene plot resume run sweep",
    "longwave.runs.run_file": "load_run save_run",
    "longwave.scenes.fits.force_fit": "fit_force",
    "longwave.scenes.description.named_scenes": "load_scene shipped_scenes",
    "longwave.scenes.description.numerics": "Discretisation Tolerance",
    "longwave.scenes.description.scene": "Scene",
    "longwave.scenes.observed.view": "relative_sup_error",
    "longwave.waves.exact_orbit": "exact_orbit",
    "longwave.waves.exact_wave": "exact_wave waves_of_all_eps",
}

__all__ = ["__version__", *sorted(" ".join(_PUBLIC_NAMES.values()).split())]

_import_name, __dir__ = lazy_exports(__name__, _PUBLIC_NAMES)


def __getattr__(name: str) -> Any:
    """Import a public name from its room, or look up the version."""
    if name == "__version__":
        from importlib.metadata import version

        return version("longwave")
    return _import_name(name)
