"""Solutions by the functions of Bessel, Weierstrass, Airy and Lambert, erf and theta functions."""

from __future__ import annotations

import random

from searches.texts.drafts import Known
from searches.texts.text_statement import TextStatement

KNOWN = (
    Known("x**2*u_xx + x*u_x + (x**2 - a**2)*u", "u = bessel_j(a, x)", "x>0 a", 2),
    Known("x**2*u_xx + x*u_x + (x**2 - a**2)*u", "u = b*bessel_y(a, x)", "x>0 a b"),
    Known("x**2*u_xx + x*u_x - (x**2 + a**2)*u", "u = bessel_i(a, x) + b*bessel_k(a, x)",
          "x>0 a b"),
    Known("u_xx + u_x/x - u_tt", "u = bessel_j(0, k*x)*cos(k*t)", "x>0 t k>0", 2),
    Known("u_t - u_xx - u_x/x", "u = bessel_i(0, k*x)*exp(k**2*t)", "x>0 t k>0"),
    Known("u_x + v ;; v_x - u + v/x", "u = bessel_j(0, x) ;; v = bessel_j(1, x)", "x>0"),
    Known("u_x + bessel_j(1, x)", "u = bessel_j(0, x)", "x"),
    Known("u - 4*bessel_j(2, x)/x + bessel_j(3, x)", "u = bessel_j(1, x)", "x>0"),
    Known("diff(u[n], t) - (u[n-1] - u[n+1])/2", "u = bessel_j(n, t)", "n t>0"),
    Known("u_xx - 6*u**2 + g/2", "u = weierstrass_p(x, g, h)", "x g h", 2),
    Known("u_x**2 - 4*u**3 + g*u + h", "u = weierstrass_p(x, g, h)", "x g h", 2),
    Known("u_x - v ;; v_x - 6*u**2 + g/2",
          "u = weierstrass_p(x, g, h) ;; v = weierstrass_p_prime(x, g, h)", "x g h"),
    Known("u_t + 6*u*u_x + u_xxx", "u = c/6 - 2*weierstrass_p(x - c*t, g, h)", "x t c g h", 2),
    Known("u_t - u_xx", "u = jacobi_theta_1(x, exp(-4*t))", "x t>0", 2),
    Known("u_t - u_xx", "u = a*jacobi_theta_2(x, exp(-4*t)) + jacobi_theta_4(x, exp(-4*t))",
          "x t>0 a"),
    Known("4*t*u_t + u_xx", "u = jacobi_theta_3(x, t)", "x t:0:1"),
    Known("u_xx - x*u", "u = a*airy_ai(x) + airy_bi(x)", "x a", 2),
    Known("u_x - v ;; v_x - x*u", "u = airy_bi(x) ;; v = airy_bi_prime(x)", "x"),
    Known("I*u_t + u_xx", "u = airy_ai(x - t**2)*exp(I*(t*x - 2*t**3/3))", "x t", 2),
    Known("u_t - u_xx", "u = erf(x/(2*sqrt(t)))", "x t>0", 2),
    Known("u_xx + 2*x*u_x", "u = a + erf(x)", "x a"),
    Known("u_t + u*u_x", "u = lambert_w(t*exp(x))/t", "x t>0"),
    Known("u*exp(u) - x", "u = lambert_w(x)", "x>0"),
)  # fmt: skip

WEIGHTS = [known.weight for known in KNOWN]


def known_special(draw: random.Random) -> TextStatement | None:
    """One of `KNOWN` under symmetries."""
    return draw.choices(KNOWN, WEIGHTS)[0].draft(draw).statement("special: known")


MAKERS = ((known_special, 1.0),)
