"""The lambdified stable form against the wave that is evaluated with care."""

import numpy as np
import pytest
import sympy as sp

from longwave.derive import NormalForm
from longwave.solutions import CATALOGUE, ClosedForm, Wave, closed_form
from longwave.solutions.numpy_function import numpy_function

PARAMETERS = {
    "k": 0.6,
    "alpha": 0.7,
    "X_0": 0.3,
    "A": 1.5,
    "A_1": 1.4,
    "A_2": 0.6,
    "p": 1.2,
    "q": 0.8,
    "kappa": 0.9,
    "U_0": 0.5,
    "a": 0.3,
}


OTHERS = map(closed_form, ("kdv_cnoidal", "kp_lump", "nls_plane", "nls_akhmediev"))


@pytest.mark.parametrize("form", [*CATALOGUE.of("mKdV"), *OTHERS], ids=lambda form: form.name)
def test_lambdified_form_agrees_with_the_wave(form: ClosedForm) -> None:
    values = {parameter.name: PARAMETERS[parameter.name] for parameter in form.parameters}
    equation = form.equation
    sign = [1] if equation.free_sign else []
    s = sp.Integer(1 if sign else equation.s)
    across = sp.Integer(1 if equation.has_across else 0)
    a, b = sp.Rational(5, 4), sp.Rational(-2, 3)
    normal_form = NormalForm(a, b, s, 1, equation.normal, 1, across, equation.r)
    X, Z, T = np.linspace(-3.0, 3.0, 7), 0.7, 0.4
    place = [float(a) * X, Z, float(b) * T] if across else [float(a) * X, float(b) * T]
    U, U_xi, *U_zeta, U_tau = numpy_function(form)(*place, *sign, *values.values())
    expected = Wave(form, normal_form, **values)(X, T, **({"Z": Z} if across else {}))
    found = (U, float(a) * U_xi, float(b) * U_tau, *U_zeta)
    for value, target in zip(found, expected, strict=True):
        np.testing.assert_allclose(value, target, rtol=0, atol=2e-12)
