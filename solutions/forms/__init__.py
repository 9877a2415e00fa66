"""The closed forms: each is made by the function of its name (``solutions.catalogue``)."""
