"""The paper's systems: S2AG, its ablations and the baselines, all trained by one loop (reference section G)."""
