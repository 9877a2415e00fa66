"""What can be seen of a run: a view of it, and the observables that a scene may ask for."""
