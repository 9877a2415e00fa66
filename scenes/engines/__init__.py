"""How a scene becomes a run: domains, engines, what they cost, and which of them runs."""
