"""How a scene becomes a run: domains, engines, their costs and records, and which of them runs."""
