"""The rows of the scratch array of `extended`, each a block.

They are at distances that LLVM knows, so that it runs the loops on vectors.  As NumPy's integers
they have one type: for every plain one numba would compile anew what takes it.
"""

import numpy as np

U, LOW, J, Q, R, V, WORK, POWER = map(np.int64, range(8))
"""The argument and its third float; its quarter periods; these modulo 4, and whether they are odd;
the rest; the rest times the rate."""

S, C, G, X, Y = map(np.int64, range(8, 13))
"""sin v, cos v, 1, 2 cos 2v, sin 2v, or g sinh v, g cosh v, g = exp(-|v|), 2 cosh 2v, sinh 2v."""

X2, X3, REST = map(np.int64, range(13, 16))
"""2 cos 4v, 2 cos 6v; 2 cos 8v and 2 cos 10v in double."""

THETA3, THETA4, SINE, COSINE, RISE, PLUS, MINUS = map(np.int64, range(16, 23))
"""The series, and the slopes of theta_3 and theta_4."""

SN, CN, DN, EPSILON, ZETA, THETA = map(np.int64, range(23, 29))

ROWS = 29
