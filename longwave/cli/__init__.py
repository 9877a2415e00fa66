"""The command line: the tree of its words, and what each of them does."""
