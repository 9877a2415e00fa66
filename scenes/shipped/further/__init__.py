"""Scenes on the paper's chain that are not in the paper, as TOML files."""
