"""Numerical evidence: high-precision residuals, and mutated formulas that must be refuted."""
