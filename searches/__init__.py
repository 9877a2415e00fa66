"""Searches that try to break the promises: forged certificates, random statements and scenes,
opponents that maximise an error over its estimate, fuzzing, mutants. Run from a checkout, as in
``python -m searches.verdicts``; nothing here is installed."""
