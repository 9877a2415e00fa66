"""Domains, engines, cost models and run records, and the choice of engine for a scene."""
