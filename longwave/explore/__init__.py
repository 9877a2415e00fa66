"""The page of `longwave explore`."""
