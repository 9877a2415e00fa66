"""The lattice with numbers: its model, kernels, schemes and engines; no waves and no symbols."""
