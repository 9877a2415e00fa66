"""Pictures and films of runs and sweeps, for the report and for `longwave plot` and `animate`."""
