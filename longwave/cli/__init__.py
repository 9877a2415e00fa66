"""The command line: the tree of commands, and one module for each command."""
