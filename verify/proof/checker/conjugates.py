"""Complex conjugates of formulas, as formulas."""

from __future__ import annotations

from . import axioms
from .limits import CertificateError
from .nodes import Nodes
from .signs import Signs


def conjugate(nodes: Nodes, signs: Signs, node: int) -> int:
    """The complex conjugate of a node as a node."""
    made = nodes.made

    def inside(part: int) -> int:
        return conjugate(nodes, signs, part)

    if signs.is_real(node):
        return node
    match nodes.all[node]:
        case ("I",):
            return made("Mul", nodes.rational(-1), node)
        case (("Add" | "Mul") as name, *parts):
            return made(name, *map(inside, parts))
        case ("Pow", base, exponent) if exponent.q == 1:
            return made("Pow", inside(base), exponent)
        case ("poly", terms, *parts):
            return made("poly", terms, *map(inside, parts))
        case ("conjugate", inner):
            return int(inner)
        case (str(name), inner) if name in ("exp", *axioms.HYPERBOLIC, *axioms.TRIGONOMETRIC):
            return made(name, inside(inner))
        case (("jacobi_sn" | "jacobi_cn" | "jacobi_dn") as name, z, m) if signs.is_real(m):
            return made(name, inside(z), m)
        case (name, *_):
            raise CertificateError(f"the conjugate of {name} does not follow from the domain")
    raise CertificateError("a node has no conjugate")
