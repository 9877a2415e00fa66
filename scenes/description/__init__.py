"""What a scene says: its record, its file, its tables, and what goes together in them."""
