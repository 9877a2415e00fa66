"""Functions that are known by their differential equations alone."""

from __future__ import annotations

from flint import fmpq

from ..axioms import FUNCTIONS, Function
from ..balls import BALLS
from ..bounds import Interval
from ..elementary import whole
from ..field import Field, rule
from ..ring import Element

FUNCTIONS |= {
    "erf": Function("entire", "2*exp(-z**2)/sqrt(pi)", symmetry="same", free=True,
                    values=Interval(fmpq(-1), fmpq(1), True, True)),
    "airyai": Function("entire", "airyaiprime(z)", free=True),
    "airyaiprime": Function("entire", "z*airyai(z)", free=True),
    "airybi": Function("entire", "airybiprime(z)", free=True),
    "airybiprime": Function("entire", "z*airybi(z)", free=True),
    "lambertw": Function("cut", "lambertw(z)/(z*(1 + lambertw(z)))", free=True,
                         values=Interval(fmpq(0)), between=(fmpq(0), None)),
}  # fmt: skip

BALLS |= {
    "airyai": lambda z: z.airy_ai(),
    "airyaiprime": lambda z: z.airy_ai(derivative=1),
    "airybi": lambda z: z.airy_bi(),
    "airybiprime": lambda z: z.airy_bi(derivative=1),
}


@rule("exp", first=True)
def exponential_of_lambert(field: Field, node: int) -> Element | None:
    """exp(n W(f)) = (f/W(f))**n."""
    times, u = field.nodes.multiple(field.nodes.all[node][1])
    match field.nodes.all[u]:
        case ("lambertw", f):
            return (field.image(f) / field.image(u)) ** whole(times)
    return None
