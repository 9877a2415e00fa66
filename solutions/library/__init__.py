"""Published solutions and wrong variants, as problem files (``longwave list --library``)."""
