"""Services for every room, without any physics: commands, limits, files, workers, compiled code."""
