"""Evidence beside the proofs: residuals at many digits, and misprints that must be refuted."""
