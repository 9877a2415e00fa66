"""Runs: made at the command line, kept as files."""
