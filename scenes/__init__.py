"""Scenes: waves on lattices, run and compared. The paper's chain is in `scenes.chain`."""
