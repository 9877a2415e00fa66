"""Studies: what an evaluation or a computation costs, and how exact it is."""
