"""The symbols of the derivation, under the paper's names, with their assumptions.

``K2`` (so that the sound speed is real), the frame speed ``c`` and the small parameter ``eps``
are positive; everything else is real.  Lattice: site ``n``, time ``t``, strain about a uniform
state ``ybar``, wavenumber ``k`` per site.  Slow variables: ``X = eps (n - c t)``, ``T = eps^3 t``.
"""

from sympy import Symbol

K2 = Symbol("K2", positive=True)
K3 = Symbol("K3", real=True)
K4 = Symbol("K4", real=True)
c = Symbol("c", positive=True)
eps = Symbol("eps", positive=True)

n = Symbol("n", real=True)
t = Symbol("t", real=True)
X = Symbol("X", real=True)
T = Symbol("T", real=True)

k = Symbol("k", real=True)
ybar = Symbol("ybar", real=True)
x = Symbol("x", real=True)

LATEX_NAMES = {ybar: r"\overline{y}", eps: r"\epsilon"}
