"""The closed forms, one file each."""
