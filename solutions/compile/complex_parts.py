"""Real and imaginary part of a formula, as it is written: nothing is expanded or simplified."""

import sympy as sp

Parts = tuple[sp.Expr, sp.Expr]


def complex_parts(expression: sp.Expr) -> Parts:
    """Real and imaginary part of sums, products and powers of real expressions, I and exp(I ...).

    Every symbol and function without I in it is taken for real. Raises ValueError where I stands
    in another function or in a divisor.

    >>> x, y = sp.symbols("x y", real=True)
    >>> complex_parts((1 + 2 * sp.I * x) / (1 + x**2) * sp.exp(sp.I * y))[1]
    2*x*cos(y)/(x**2 + 1) + sin(y)/(x**2 + 1)
    """
    if not expression.has(sp.I):
        return expression, sp.S.Zero
    if expression == sp.I:
        return sp.S.Zero, sp.S.One
    if expression.is_Add:
        pairs = [complex_parts(term) for term in expression.args]
        return sp.Add(*(re for re, _ in pairs)), sp.Add(*(im for _, im in pairs))
    if expression.is_Mul:
        return _product(expression)
    if expression.is_Pow and expression.exp.is_Integer and expression.exp > 0:
        return _product(sp.Mul(*[expression.base] * int(expression.exp), evaluate=False))
    if isinstance(expression, sp.exp):
        growth, angle = complex_parts(expression.args[0])
        return sp.exp(growth) * sp.cos(angle), sp.exp(growth) * sp.sin(angle)
    raise ValueError(
        f"I must stand in sums, products and exponentials alone, got {expression} "
        "(write the real and the imaginary part)"
    )


def _product(product: sp.Expr) -> Parts:
    """The real factors stay together; the others are multiplied one by one."""
    real = sp.Mul(*(factor for factor in product.args if not factor.has(sp.I)))
    re, im = real, sp.S.Zero
    for factor in product.args:
        if factor.has(sp.I):
            other_re, other_im = complex_parts(factor)
            re, im = re * other_re - im * other_im, re * other_im + im * other_re
    return re, im
