"""The proofs that `wearfem verify` runs, one module each: a docstring, and `claims()` that yields each claim as it is settled."""
