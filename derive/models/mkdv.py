"""The paper's reduction: the strain FPUT lattice to mKdV."""

from functools import lru_cache

from sympy import Expr, Symbol

from longwave.derive.algebra.exact_numbers import Number, exact
from longwave.derive.algebra.jets import EpsSeries
from longwave.derive.expansion import expand
from longwave.derive.models.lattices import FPUT_STRAIN
from longwave.derive.multiscale import reduce
from longwave.derive.normal_form import NormalForm
from longwave.derive.output.notation import Notation, signed_sum
from longwave.derive.reduction import Reduction
from longwave.derive.scaling import Scaling
from longwave.derive.symbols import eps


@lru_cache
def mkdv_reduction() -> Reduction:
    """Return the reduction under the paper's ansatz, through the paper's eq. (8)."""
    scaling = Scaling()
    return reduce(FPUT_STRAIN, scaling, orders=scaling.leading_order)


def mkdv_normal_form(K2: Number, K4: Number) -> NormalForm:
    """Return the normal form of the mKdV equation at K2 > 0 and K4 != 0.

    Numbers are taken exactly (a float as its shortest decimal); symbols are allowed.
    Raises ValueError for K2 <= 0, K4 = 0, NaN and infinity.

    >>> mkdv_normal_form(4, 1)
    NormalForm(a=sqrt(6)/2, b=sqrt(6)/16, s=1, c=2)
    """
    return _normal_form(exact("K2", K2), exact("K4", K4))


@lru_cache(maxsize=256)
def _normal_form(stiffness: Expr, cubic: Expr) -> NormalForm:
    if stiffness.is_positive is False:
        raise ValueError(
            f"K2 must satisfy K2 > 0, got {stiffness} (c^2 = K2 is the square of the sound speed)"
        )
    if cubic.is_zero:
        raise ValueError("K4 must satisfy K4 != 0, got 0 (K4 = 0 leaves a linear equation)")
    return mkdv_reduction().normal_form(K2=stiffness, K4=cubic)


def _velocity() -> EpsSeries:
    """Return d/dt of the paper's ansatz."""
    scaling = Scaling()
    return expand(FPUT_STRAIN, scaling, scaling.amplitude + scaling.time).velocity()


def initial_velocity() -> Expr:
    """Return s = dy/dt of the ansatz by the chain rule (the paper's eqs. (10), (11)).

    It is an expression in ``eps``, ``c`` and the symbols ``Y_X``, ``Y_T``.

    >>> initial_velocity()
    Y_T*eps**4 - Y_X*c*eps**2
    """
    return sum(
        eps**order * number.as_expr() * Symbol(f"Y_{Notation().subscript(jet)}")
        for order, part in _velocity().parts.items()
        for [jet], number in part.terms.items()
    )


def initial_velocity_latex() -> str:
    r"""Return the initial velocity in LaTeX, highest order first.

    >>> print(initial_velocity_latex())
    s = \epsilon^{4} Y_{T} - \epsilon^{2} c Y_{X}
    """
    orders = sorted(_velocity().parts.items(), reverse=True)
    formulas = {order: Notation().latex(part) for order, part in orders}
    return "s = " + signed_sum(
        (formula.startswith("-"), rf"\epsilon^{{{order}}} {formula.removeprefix('-')}")
        for order, formula in formulas.items()
    )
