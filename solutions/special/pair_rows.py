"""The rows of the scratch array of `extended`, each a block.

They are at distances that LLVM knows, so that it runs the loops on vectors.
"""

U, J, R, V, WORK, POWER = range(6)
"""The argument; its quarter periods and whether they are odd; the rest; the rest times the rate."""

S, C, G, X, Y = range(6, 11)
"""sin v, cos v, 1, 2 cos 2v, sin 2v, or g sinh v, g cosh v, g = exp(-|v|), 2 cosh 2v, sinh 2v."""

X2, X3, REST = range(11, 14)
"""2 cos 4v, 2 cos 6v; 2 cos 8v and 2 cos 10v in double."""

THETA3, THETA4, SINE, COSINE, RISE, PLUS, MINUS = range(14, 21)
"""The series, and the slopes of theta_3 and theta_4."""

SN, CN, DN, EPSILON, ZETA, THETA = range(21, 27)

ROWS = 27
