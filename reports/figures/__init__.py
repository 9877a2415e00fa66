"""The report's figures: vector PDF drawn from runs, and a PNG of one of them for the README."""
