"""Fits to measurements: force laws from measured points, scenes from sensor records."""
