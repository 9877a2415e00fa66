"""The closed forms: each is built by the function of its name (``solutions.catalogue``)."""
