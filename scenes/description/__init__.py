"""Descriptions of scenes: the record, its TOML file and tables, and rules between their fields."""
