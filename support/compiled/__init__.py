"""Compiled code: kernels, their cache on disk, and the source digests it depends on."""
