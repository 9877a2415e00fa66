"""Checker of certificates of waves: it repeats each proof from the statement alone."""
