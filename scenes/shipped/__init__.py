"""Shipped scenes as TOML files, one folder for each kind."""
