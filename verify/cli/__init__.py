"""The subcommands of ``python -m verify``, one file each."""
