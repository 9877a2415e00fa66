"""The interactive page of `longwave explore`."""
