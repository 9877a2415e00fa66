"""What every room needs and knows nothing of the field: commands, limits, files, workers, code."""
