"""Time-stepping schemes as tables, their order and their stability."""
