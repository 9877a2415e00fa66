"""Chains on a bench, one file each."""
