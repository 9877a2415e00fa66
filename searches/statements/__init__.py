"""Random statements of known truth, which SymPy builds and the prover gets in text.

`library.statement` makes the one of a seed and an index.
"""
