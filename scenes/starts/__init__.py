"""What runs start from: waves with their derivation and their data, and chains on a bench."""
