"""The lattice site by site: its state, what crosses its ends, and stepping it through times."""
