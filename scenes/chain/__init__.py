"""mKdV waves on the paper's chain: data, domains, observables, engines, runs."""
