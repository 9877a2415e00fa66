"""Random statements whose truth is known by construction, to find wrong verdicts with.

`library.statement` makes the one of a seed and an index; `searches.verdict_search` asks the
prover.
"""
