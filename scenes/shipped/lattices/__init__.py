"""Scenes with other lattices or other reduced equations than the paper's, as TOML files."""
