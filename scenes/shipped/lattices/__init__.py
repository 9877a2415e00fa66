"""Scenes on further lattices and waves, as TOML files."""
