"""Exact algebra: numbers, polynomials in jets, series in eps, elimination."""
