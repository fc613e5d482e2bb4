"""The systems of the paper's comparison: S2AG, its ablations and the baselines (reference section G)."""
