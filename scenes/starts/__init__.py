"""Starts of runs: waves with their derivation and initial data, and chains on a bench."""
