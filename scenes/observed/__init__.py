"""What is observed of a run: observables, what records them, and the record of a run."""
