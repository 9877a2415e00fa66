"""The report: figures, tables and LaTeX, made from the objects of the other rooms.

This room holds no mathematics: formulas, coefficients and errors are asked from `derive`,
`solutions` and `verify`.
"""
