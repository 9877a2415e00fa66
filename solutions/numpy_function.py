"""A closed form as a plain NumPy function of (xi, tau) and its parameters."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import sympy as sp

from solutions.record import ClosedForm
from solutions.special.numpy_functions import numpy_module
from solutions.straight_line import StraightLine
from solutions.symbols import tau, xi

__all__ = ["numpy_function"]


@lru_cache(maxsize=64)
def numpy_function(form: ClosedForm) -> Callable[..., Any]:
    """``f(xi, tau, *parameters) -> (U, U_xi, U_tau)`` in NumPy, by `lambdify` of the stable form.

    Derivatives are SymPy's; common subexpressions are shared. The arguments are doubles as they
    come: a `Wave` forms its phases from (site, time, eps) in double-double and keeps its digits
    at large arguments and near k = 1, where this function does not.

    >>> from solutions import closed_form
    >>> U, U_xi, U_tau = numpy_function(closed_form("soliton_sech"))(0.0, 0.0, 2.0)
    >>> float(U), float(U_xi) == 0.0
    (2.0, True)
    """
    program = StraightLine()
    value = program.record(form.stable)
    outputs = [value, program.derivative(value, xi), program.derivative(value, tau)]
    arguments = [xi, tau, *(parameter.symbol for parameter in form.parameters)]
    modules = [numpy_module(), "numpy"]
    return sp.lambdify(arguments, outputs, modules, cse=lambda values: (program.lines, values))
