"""The paper's chain: mKdV waves with leading data, in windows and on rings, by two engines."""
