"""Text of a scene file that runs in a moment; tests of the command line modify it."""

CHAIN = """
title = "short"
wave = "soliton_sech"
eps = 0.2
t0 = 0
snapshots = [0, 10]
tolerance = 1e-3
lattice = { K2 = 1, K4 = 1 }
parameters = { A = 1 }
domain = { compared = 60 }
"""
