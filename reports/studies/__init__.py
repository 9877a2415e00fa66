"""Studies: how exact an evaluation is, what hard cases do, what proofs and accuracy cost."""
