"""Machine code that advances rings: splittings of any chain or plane, Nystroem methods."""
