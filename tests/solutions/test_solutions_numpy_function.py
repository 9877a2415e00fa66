"""The lambdified stable form against the wave that is evaluated with care."""

import numpy as np
import pytest

from derive import mkdv_normal_form
from solutions import CATALOGUE, ClosedForm, Wave
from solutions.numpy_function import numpy_function

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
}


@pytest.mark.parametrize("form", CATALOGUE.of("mKdV"), ids=lambda form: form.name)
def test_lambdified_form_agrees_with_the_wave(form: ClosedForm) -> None:
    names = [parameter.name for parameter in form.parameters]
    values = {name: PARAMETERS[name] for name in names}
    normal_form = mkdv_normal_form(1, form.equation.s)
    wave = Wave(form, normal_form, **values)
    X, T = np.linspace(-3.0, 3.0, 7), 0.4
    a, b = float(normal_form.a), float(normal_form.b)
    U, U_xi, U_tau = numpy_function(form)(a * X, b * T, *values.values())
    expected = wave(X, T)
    for value, target in zip((U, a * U_xi, b * U_tau), expected, strict=True):
        np.testing.assert_allclose(value, target, rtol=0, atol=2e-12)
