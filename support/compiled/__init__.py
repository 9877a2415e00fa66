"""Compiled code and its cache on disk, which follows the sources."""
