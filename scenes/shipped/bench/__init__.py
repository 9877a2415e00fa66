"""Chains on a bench, as TOML files."""
