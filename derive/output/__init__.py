"""Reductions as text, LaTeX and JSON."""
