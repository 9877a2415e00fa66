"""Parts of a derivation as text and as data for JSON.

In JSON a polynomial is ``{"text": ..., "terms": [...]}``; a term has its jets and its coefficient
as numerator and denominator, each a list of [exponents, "p/q"] over the document's ``generators``.
"""

from collections.abc import Iterator
from typing import Any

from longwave.derive.algebra.formula_printing import text_of
from longwave.derive.algebra.jets import DifferentialPolynomial
from longwave.derive.lattice import Lattice
from longwave.derive.normal_form import NORMAL_EQUATIONS, NormalForm
from longwave.derive.output.notation import Notation

Data = dict[str, Any]


def head_lines(lattice: Lattice) -> Iterator[str]:
    """Yield title, equations of motion, and messages on forces without an energy."""
    yield lattice.title
    yield from (f"  {line}" for line in lattice.equations())
    yield from (f"  not an energy: {line}" for line in lattice.missing_energies)


def form_data(form: NormalForm) -> Data:
    """Return a normal form as JSON-ready data."""
    return {
        "equation": form.equation,
        "normal_form": NORMAL_EQUATIONS[form.equation].text,
        "map": form.map_text,
        **{name: text_of(value) for name, value in {**form.values, "c": form.c}.items()},
    }


def polynomial_data(polynomial: DifferentialPolynomial, notation: Notation) -> Data:
    """Return one polynomial as JSON-ready data."""
    return {
        "text": notation.text(polynomial),
        "terms": [
            {
                "jets": [list(jet) for jet in monomial],
                **{
                    name: [[list(exponents), str(n)] for exponents, n in value.terms(below=below)]
                    for name, below in (("numerator", False), ("denominator", True))
                },
            }
            for monomial, value in polynomial.terms.items()
        ],
    }
