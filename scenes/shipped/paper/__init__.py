"""The paper's scenes, as TOML files."""
