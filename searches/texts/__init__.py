"""Random statements in text whose truth is known by construction, to find wrong verdicts with.

`text_library.text_statement` makes the one of a kind, a seed and an index.  Nothing here is shared
with the prover or with SymPy: `trees` reads and differentiates formulas, `ball_judge` finds their
residuals in balls.
"""
